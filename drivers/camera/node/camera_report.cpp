#include "drivers/camera/node/camera_report.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace prehend::drivers::camera {
namespace {

constexpr double kLookPeriod = 0.1;  // s
constexpr int kSampleLooks = 5, kPublishLooks = 10;
constexpr double kMostUnpaired = 0.1;  // part of the frames; two clocks drift past each other

}  // namespace

ViewSettings declare_view_settings(graph::Node& node) {
  ViewSettings settings;
  settings.rate = node.declare_parameter<double>(
      {.name = "rate",
       .default_value = 0.0,
       .unit = "1/s",
       .minimum = 0.0,
       .maximum = 1000.0,
       .description = "of what is published, at most; 0: all that comes",
       .read_only = true});
  settings.stale_time =
      node.declare_parameter<double>({.name = "stale_time",
                                      .default_value = settings.stale_time,
                                      .unit = "s",
                                      .minimum = 0.05,
                                      .maximum = 60.0,
                                      .description = "without an image, then it is an error",
                                      .read_only = true});
  return settings;
}

std::int64_t graph_stamp(const graph::Node& node, Time stamp) {
  return node.clock().now() - std::max(Time::zero(), steady_now() - stamp).count();
}

void ViewProblem::shield(const std::function<void()>& publish) {
  std::string words;
  try {
    publish();
  } catch (const std::exception& error) {
    words = error.what();
  }
  const std::lock_guard lock(mutex_);
  words_ = std::move(words);
}

std::string ViewProblem::words() const {
  const std::lock_guard lock(mutex_);
  return words_;
}

CameraReport::CameraReport(graph::Node& node, std::function<State()> state)
    : node_(node),
      state_(std::move(state)),
      report_(node),
      publisher_(node.advertise<msgs::DeviceStatus>("/camera/device", graph::QoS::latched(1))),
      timer_(kLookPeriod, [this] { look(); }) {}

void CameraReport::look() {
  const State state = state_();
  const std::string& trouble = state.trouble.empty() ? state.view_problem : state.trouble;
  const char* word = !state.trouble.empty()        ? "no images"
                     : !state.view_problem.empty() ? "images of no use"
                     : state.is_at_end             ? "at the end"
                     : state.views > 0             ? "streaming"
                                                   : "starting";
  if (!state.trouble.empty()) {
    quality_.restart();
  } else if (looks_ % kSampleLooks == 0) {
    quality_.sample(state.views, state.unpaired, 0, steady_now());
  }
  std::string remark = state.remark;
  if (state.views > 0 && quality_.harmed_part() > kMostUnpaired) {
    remark += (remark.empty() ? "" : "; ") +
              fmt::format("{:.0f} % of the frames come without a partner within half a frame",
                          100 * quality_.harmed_part());
  }
  report_.tell(trouble.empty() ? with_warning({Health::Level::kOk, word}, remark)
                               : Health{Health::Level::kError, trouble});
  if (looks_++ % kPublishLooks != 0) return;
  msgs::DeviceStatus status;
  status.mutable_header()->set_stamp(node_.clock().now());
  status.set_state(word);
  status.set_messages(state.views);
  status.set_damaged(state.unpaired);
  status.set_connections(state.connections);
  status.set_rate(quality_.rate());
  status.set_damaged_part(quality_.harmed_part());
  publisher_.publish(status);
}

}  // namespace prehend::drivers::camera
