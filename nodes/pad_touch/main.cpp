#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "msgs/convert/pad_touch.h"
#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "nodes/hand_pads/hand_pads.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;

struct Settings {
  touch::PadTouchOptions touch;
  touch::SlipOptions slip;
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.touch.friction = node.declare_parameter<double>(
      {.name = "friction",
       .default_value = 0.0,
       .minimum = 0.0,
       .maximum = 10.0,
       .description = "of the pads on what they hold, for the holding torque; 0: the dynamic "
                      "friction of the robot's file",
       .read_only = true});
  s.touch.fit.gain_deviation = node.declare_parameter<double>(
      {.name = "gain_deviation",
       .default_value = s.touch.fit.gain_deviation,
       .minimum = 0.0,
       .maximum = 1.0,
       .description = "of the texels' gains from one another, relative, standard; normals and "
                      "curvatures are as uncertain as it makes them",
       .read_only = true});
  s.slip.window = node.declare_parameter<double>(
      {.name = "slip_window",
       .default_value = s.slip.window,
       .unit = "s",
       .minimum = 0.005,
       .maximum = 10.0,
       .description = "between frames that are compared to see whether the pattern moves",
       .read_only = true});
  s.slip.least_slip = node.declare_parameter<double>(
      {.name = "least_slip",
       .default_value = s.slip.least_slip,
       .unit = "m",
       .minimum = 1e-6,
       .maximum = 0.1,
       .description = "motion of the pattern in that time from which on it slips",
       .read_only = true});
  return s;
}

constexpr std::size_t kMostWaiting = 8;  // instants

/// The meaning of every frame, all pads of one instant in one message.
class TouchStage {
 public:
  TouchStage(graph::Node& node, const Settings& settings, const nodes::HandPads& hand)
      : node_(node),
        settings_(settings),
        hand_(hand),
        publisher_(node.advertise<msgs::Touch>("/touch", graph::QoS::queue(50))) {
    const robot::Platform& platform = hand.platform();
    for (const robot::HandPad& pad : platform.hand.pads) pads_.emplace(pad.name, Pad{pad, {}, {}});
    for (const auto& [name, pad] : pads_) {
      subscriptions_.push_back(node.subscribe<msgs::TactileFrame>(
          "/tactile/" + name, graph::QoS::queue(50),
          [this, name = name](const graph::Received<msgs::TactileFrame>& frame) {
            take(name, *frame);
          }));
    }
    if (pads_.empty()) {
      node.report(graph::Health::kWarning,
                  "the hand of " + platform.name + " has no tactile pads: /touch stays empty");
    }
  }

 private:
  struct Pad {
    const robot::HandPad& of;  // the platform's
    std::string made_for;      // what of the frames the watch was made for
    std::optional<touch::SlipWatch> watch;
  };

  // Topics come in no common order: an instant waits for all pads that are heard of, but not for
  // those that have fallen silent.
  void take(const std::string& name, const msgs::TactileFrame& frame) {
    msgs::PadTouch touch;
    touch.set_pad(name);
    const std::string problem = node_.shield("pad " + name, [&] { touch = meaning(name, frame); });
    if (!problem.empty()) touch.add_not_determined("everything: " + problem);
    heard_.insert(name);
    const std::int64_t stamp = frame.header().stamp();
    msgs::Touch& instant = waiting_[stamp];
    instant.mutable_header()->set_stamp(stamp);
    instant.mutable_header()->set_frame_id("pads");
    *instant.add_pads() = std::move(touch);
    if (stamp <= published_ || instant.pads_size() >= static_cast<int>(heard_.size())) {
      publish_until(stamp);
    } else if (waiting_.size() > kMostWaiting) {
      heard_.clear();
      for (const msgs::PadTouch& pad : waiting_.rbegin()->second.pads()) heard_.insert(pad.pad());
      publish_until(waiting_.begin()->first);
    }
  }

  void publish_until(std::int64_t stamp) {
    while (!waiting_.empty() && waiting_.begin()->first <= stamp) {
      publisher_.publish(std::move(waiting_.begin()->second));
      waiting_.erase(waiting_.begin());
    }
    published_ = stamp;
  }

  msgs::PadTouch meaning(const std::string& name, const msgs::TactileFrame& frame) {
    Pad& pad = pads_.at(name);
    prepare(frame, &pad);
    const std::vector<double> counts = convert::counts_of(frame);
    msgs::PadTouch message =
        convert::to_message(name, pad_touch(pad.watch->pad(), counts, settings_.touch));
    const int columns = static_cast<int>(frame.columns());
    convert::add_slip(pad.watch->update(graph::seconds(frame.header().stamp()), counts), columns,
                      &message);
    return message;
  }

  // Frames say how many texels there are, and may say it anew: another device, another calibration.
  void prepare(const msgs::TactileFrame& frame, Pad* pad) {
    const std::string wanted =
        fmt::format("{} {} {} {} {} {} {} {}", frame.rows(), frame.columns(),
                    frame.intensity_size(), frame.texel_width(), frame.texel_height(),
                    frame.full_scale(), frame.newton_per_count(), hand_.said_by());
    if (pad->watch && pad->made_for == wanted) return;
    pad->watch.emplace(hand_.felt(pad->of, frame), settings_.slip);
    pad->made_for = wanted;
  }

  graph::Node& node_;
  Settings settings_;
  const nodes::HandPads& hand_;
  std::map<std::string, Pad> pads_;
  std::map<std::int64_t, msgs::Touch> waiting_;  // by stamp [ns], for their other pads
  std::set<std::string> heard_;                  // pads that are heard of
  std::int64_t published_ = std::numeric_limits<std::int64_t>::min();  // ns
  graph::Publisher<msgs::Touch> publisher_;
  std::vector<graph::Subscription> subscriptions_;  // last: they end before the rest goes
};

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  const nodes::HandPads hand(node);
  const TouchStage stage(node, settings, hand);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"pad_touch",
     "Says what the frames of tactile pads mean. Takes /tactile/PAD of every pad of the platform's "
     "hand, simulated or real; publishes /touch: contact area, normal force, centre of pressure, "
     "contact normal, curvature, the torque that friction holds, and which texels slip, each with "
     "how far it is known, or why it is not."},
    run);

}  // namespace
