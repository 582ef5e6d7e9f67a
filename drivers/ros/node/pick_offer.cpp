#include "drivers/ros/node/pick_offer.h"

#include <cctype>
#include <chrono>
#include <utility>

#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {
namespace {

using recording::RosValue;
using Fields = RosValue::Fields;

constexpr std::chrono::seconds kAnswerTime(5);

std::string lower_case(std::string word) {
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}

}  // namespace

PickOffer::PickOffer(graph::Node& node, RosPeer& peer, const std::string& name,
                     const std::string& cycle)
    : node_(node),
      cycle_(cycle),
      start_(node.client<msgs::Empty, msgs::Acknowledge>("/cycle/start")),
      stop_(node.client<msgs::Empty, msgs::Acknowledge>("/cycle/stop")) {
  server_ =
      serve_action(peer, name, "prehend_msgs/Pick",
                   {[this](const RosValue& goal) { return begin(goal); }, [this] { cancel(); }});
  // What is latched is of cycles before.
  states_ = node.subscribe<msgs::CycleState>(
      "/cycle/state", graph::QoS::queue(64),
      [this](const graph::Received<msgs::CycleState>& state) { take_state(*state); });
  results_ = node.subscribe<msgs::CycleResult>(
      "/cycle/result", graph::QoS::queue(4),
      [this](const graph::Received<msgs::CycleResult>& result) { take_result(*result); });
}

PickOffer::~PickOffer() { server_.reset(); }

std::string PickOffer::begin(const RosValue& goal) {
  const std::int64_t object = goal["object"].integer(), grasp = goal["grasp"].integer();
  const auto refuse = [this](const std::string& why) {
    node_.log_warning("the action Pick of ROS is refused: {}", why);
    return why;
  };
  if (object < -1 || grasp < -1 || (object < 0 && grasp >= 0)) {
    return refuse("object is one of the plan, or -1; grasp one of that object's, or -1");
  }
  try {
    graph::Introspection().set_parameters(
        cycle_, {{"object", std::to_string(object)}, {"grasp", std::to_string(grasp)}});
  } catch (const std::exception& error) {
    return refuse(error.what());
  }
  {
    const std::lock_guard lock(mutex_);
    runs_ = true;
    cancelled_ = false;
  }
  const auto answer = start_.call({}, kAnswerTime);
  if (answer && answer->success()) return {};
  const std::lock_guard lock(mutex_);
  runs_ = false;
  return refuse(answer ? answer->reason() : answer.error());
}

void PickOffer::cancel() {
  {
    const std::lock_guard lock(mutex_);
    if (!runs_) return;
    cancelled_ = true;
  }
  stop_.call_async({}, kAnswerTime, [this](const graph::Outcome<msgs::Acknowledge>& answer) {
    if (!answer) node_.log_error("a pick that ROS cancelled was not stopped: {}", answer.error());
  });
}

void PickOffer::take_state(const msgs::CycleState& state) {
  {
    const std::lock_guard lock(mutex_);
    if (!runs_) return;
  }
  const std::string phase = lower_case(msgs::CycleState::Phase_Name(state.phase()));
  server_->feedback(RosValue(Fields{{"phase", ros::ros_text(phase)}}));
}

void PickOffer::take_result(const msgs::CycleResult& result) {
  bool cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(runs_, false)) return;
    cancelled = cancelled_;
  }
  const bool success = result.outcome() == msgs::CycleResult::SUCCEEDED;
  server_->finish(success, cancelled && !success,
                  RosValue(Fields{{"success", ros::ros_integer(success ? 1 : 0)},
                                  {"reason", ros::ros_text(result.reason())},
                                  {"object", ros::ros_integer(result.object_id())}}),
                  result.reason());
}

}  // namespace prehend::drivers::ros_link
