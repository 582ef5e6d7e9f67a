#include "drivers/ros/driver/action_server.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "msgs/ros/from_ros.h"
#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {
namespace {

using recording::RosError;
using recording::RosValue;
using Fields = RosValue::Fields;

std::int64_t wall_clock() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class Ros1ActionServer : public RosActionServer {
 public:
  Ros1ActionServer(RosPeer& peer, const std::string& name, std::string type, Handler handler)
      : type_(std::move(type)),
        handler_(std::move(handler)),
        status_(peer.advertise(name + "/status", "actionlib_msgs/GoalStatusArray",
                               {.is_latched = true, .depth = 1})),
        feedback_(peer.advertise(name + "/feedback", type_ + "ActionFeedback", {})),
        result_(peer.advertise(name + "/result", type_ + "ActionResult", {})),
        goals_(peer.subscribe(name + "/goal", type_ + "ActionGoal", {},
                              [this](std::string_view bytes) { take_goal(bytes); })),
        cancels_(peer.subscribe(name + "/cancel", "actionlib_msgs/GoalID", {},
                                [this](std::string_view bytes) { take_cancel(bytes); })),
        teller_([this] { tell_often(); }) {}
  ~Ros1ActionServer() override {
    stops_ = true;
    teller_.join();
  }

  void feedback(const RosValue& feedback) override {
    const std::lock_guard lock(mutex_);
    if (!running_) return;
    feedback_->publish(write(type_ + "ActionFeedback",
                             stamped({{"status", status_of(*running_)}, {"feedback", feedback}})));
  }
  void finish(bool success, bool cancelled, const RosValue& result,
              const std::string& text) override {
    const std::lock_guard lock(mutex_);
    if (!running_) return;
    Goal goal = std::move(*running_);
    running_.reset();
    goal.status = cancelled ? kPreempted : success ? kSucceeded : kAborted;
    goal.text = text;
    end(goal, result);
  }

 private:
  // actionlib_msgs/GoalStatus
  static constexpr std::int64_t kActive = 1, kPreempted = 2, kSucceeded = 3, kAborted = 4,
                                kRejected = 5, kPreempting = 6;
  struct Goal {
    std::string id;
    std::int64_t stamp = 0;
    std::int64_t status = kActive;
    std::string text;
  };

  static std::string write(const std::string& type, const RosValue& value) {
    return ros::type_of(type, ros::Version::kRos1).write(value, recording::RosEncoding::kRos1);
  }
  static RosValue stamped(Fields fields) {
    fields.emplace_back(
        "header", RosValue(Fields{{"stamp", ros::ros_time(wall_clock(), ros::Version::kRos1)}}));
    return RosValue(std::move(fields));
  }
  static RosValue status_of(const Goal& goal) {
    return RosValue(Fields{
        {"goal_id", RosValue(Fields{{"stamp", ros::ros_time(goal.stamp, ros::Version::kRos1)},
                                    {"id", RosValue(std::string_view(goal.id))}})},
        {"status", RosValue(goal.status)},
        {"text", RosValue(std::string_view(goal.text))}});
  }
  void end(const Goal& goal, const RosValue& result) {
    result_->publish(
        write(type_ + "ActionResult", stamped({{"status", status_of(goal)}, {"result", result}})));
    last_ = goal;
    tell();
  }
  void tell() {
    RosValue::List list;
    if (last_) list.push_back(status_of(*last_));
    if (running_) list.push_back(status_of(*running_));
    status_->publish(write("actionlib_msgs/GoalStatusArray",
                           stamped({{"status_list", RosValue(std::move(list))}})));
  }
  // Clients hold a server that says nothing for dead (actionlib: 5 Hz).
  void tell_often() {
    while (!stops_) {
      {
        const std::lock_guard lock(mutex_);
        tell();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }
  void take_goal(std::string_view bytes) {
    const std::lock_guard lock(mutex_);
    Goal goal;
    std::string refusal = "another goal runs";
    try {
      const RosValue message = ros::type_of(type_ + "ActionGoal", ros::Version::kRos1)
                                   .read(bytes, recording::RosEncoding::kRos1);
      goal.id = message["goal_id"]["id"].text();
      goal.stamp = ros::ros_nanoseconds(message["goal_id"]["stamp"]);
      if (!running_) refusal = handler_.begin(message["goal"]);
    } catch (const RosError& error) {
      refusal = std::string("the goal is not understood: ") + error.what();
    }
    if (refusal.empty()) {
      running_ = goal;
      return tell();
    }
    goal.status = kRejected;
    goal.text = refusal;
    end(goal, RosValue(Fields{}));
  }
  void take_cancel(std::string_view bytes) {
    {
      const std::lock_guard lock(mutex_);
      try {
        const RosValue message = ros::type_of("actionlib_msgs/GoalID", ros::Version::kRos1)
                                     .read(bytes, recording::RosEncoding::kRos1);
        // No name: all goals; a time: those that are older.
        const std::string_view id = message["id"].text();
        const std::int64_t stamp = ros::ros_nanoseconds(message["stamp"]);
        if (!running_) return;
        const bool is_meant = id == running_->id || (id.empty() && stamp == 0) ||
                              (stamp != 0 && running_->stamp <= stamp);
        if (!is_meant) return;
        running_->status = kPreempting;
      } catch (const RosError&) {
        return;  // cancels nothing
      }
    }
    handler_.cancel();
  }

  const std::string type_;
  const Handler handler_;
  std::mutex mutex_;  // guards the next two, and the order of what is published
  std::optional<Goal> running_, last_;
  std::unique_ptr<RosPublisher> status_, feedback_, result_;
  std::unique_ptr<RosSubscription> goals_, cancels_;
  std::atomic<bool> stops_ = false;
  std::thread teller_;
};

/// Half of a service of ROS 2: answers requests.
class ServiceAnswerer {
 public:
  /// Whom an answer is for.
  struct Caller {
    std::uint64_t client = 0;
    std::int64_t sequence = 0;
  };
  using Take = std::function<void(const Caller&, const RosValue& request)>;
  ServiceAnswerer(RosPeer& peer, const std::string& name, std::string type, Take take)
      : type_(std::move(type)),
        take_(std::move(take)),
        replies_(peer.advertise(name, type_ + "_Response", {}, RosChannel::kReply)),
        requests_(peer.subscribe(
            name, type_ + "_Request", {}, [this](std::string_view bytes) { receive(bytes); },
            RosChannel::kRequest)) {}

  void answer(const Caller& caller, Fields fields) {
    fields.emplace_back("client", RosValue(caller.client));
    fields.emplace_back("sequence", RosValue(caller.sequence));
    replies_->publish(ros::type_of(type_ + "_Response", ros::Version::kRos2)
                          .write(RosValue(std::move(fields)), recording::RosEncoding::kCdr));
  }

 private:
  void receive(std::string_view bytes) {
    try {
      const RosValue request = ros::type_of(type_ + "_Request", ros::Version::kRos2)
                                   .read(bytes, recording::RosEncoding::kCdr);
      const auto* client = std::get_if<std::uint64_t>(&request["client"].content());
      take_({client ? *client : 0, request["sequence"].integer()}, request);
    } catch (const RosError&) {
      // Of another middleware, or of another version of the type: nobody to answer.
    }
  }

  const std::string type_;
  const Take take_;
  std::unique_ptr<RosPublisher> replies_;
  std::unique_ptr<RosSubscription> requests_;
};

class Ros2ActionServer : public RosActionServer {
 public:
  using Caller = ServiceAnswerer::Caller;
  Ros2ActionServer(RosPeer& peer, const std::string& name, std::string type, Handler handler)
      : type_(std::move(type)),
        handler_(std::move(handler)),
        status_(peer.advertise(name + "/_action/status", "action_msgs/GoalStatusArray",
                               {.is_latched = true, .depth = 1})),
        feedback_(peer.advertise(name + "/_action/feedback", type_ + "_FeedbackMessage", {})),
        results_(peer, name + "/_action/get_result", type_ + "_GetResult",
                 [this](const Caller& caller, const RosValue& request) { ask(caller, request); }),
        cancels_(peer, name + "/_action/cancel_goal", "action_msgs/CancelGoal",
                 [this](const Caller& caller, const RosValue& request) {
                   take_cancel(caller, request);
                 }),
        goals_(
            peer, name + "/_action/send_goal", type_ + "_SendGoal",
            [this](const Caller& caller, const RosValue& request) { take_goal(caller, request); }) {
  }

  void feedback(const RosValue& feedback) override {
    const std::lock_guard lock(mutex_);
    if (!runs_) return;
    feedback_->publish(
        write(type_ + "_FeedbackMessage", {{"goal_id", uuid(id_)}, {"feedback", feedback}}));
  }
  void finish(bool success, bool cancelled, const RosValue& result, const std::string&) override {
    const std::lock_guard lock(mutex_);
    if (!runs_) return;
    runs_ = false;
    state_ = cancelled ? kCanceled : success ? kSucceeded : kAborted;
    // Kept as bytes, for who asks later.
    result_ = write(type_ + "_Result", std::get<Fields>(result.content()));
    tell();
    for (const Caller& caller : waiting_) answer(caller);
    waiting_.clear();
  }

 private:
  // action_msgs/GoalStatus
  static constexpr std::int64_t kUnknown = 0, kExecuting = 2, kCanceling = 3, kSucceeded = 4,
                                kCanceled = 5, kAborted = 6;

  static std::string write(const std::string& type, Fields fields) {
    return ros::type_of(type, ros::Version::kRos2)
        .write(RosValue(std::move(fields)), recording::RosEncoding::kCdr);
  }
  static RosValue uuid(const std::string& id) {
    return RosValue(Fields{{"uuid", ros::ros_bytes(id)}});
  }
  void tell() {
    RosValue::List list;
    list.emplace_back(Fields{{"goal_info", info()}, {"status", RosValue(state_)}});
    status_->publish(
        write("action_msgs/GoalStatusArray", {{"status_list", RosValue(std::move(list))}}));
  }
  RosValue info() const {
    return RosValue(
        Fields{{"goal_id", uuid(id_)}, {"stamp", ros::ros_time(stamp_, ros::Version::kRos2)}});
  }
  void answer(const Caller& caller) {
    const RosValue result = ros::type_of(type_ + "_Result", ros::Version::kRos2)
                                .read(result_, recording::RosEncoding::kCdr);
    results_.answer(caller, {{"status", RosValue(state_)}, {"result", result}});
  }
  void take_goal(const Caller& caller, const RosValue& request) {
    const std::lock_guard lock(mutex_);
    const std::int64_t now = wall_clock();
    // ROS 2 has no place for why it is not taken: the handler says it where it can.
    const bool accepted = !runs_ && handler_.begin(request["goal"]).empty();
    if (accepted) {
      runs_ = true;
      id_ = request["goal_id"]["uuid"].bytes();
      stamp_ = now;
      state_ = kExecuting;
      waiting_.clear();
    }
    goals_.answer(caller, {{"accepted", RosValue(std::int64_t{accepted})},
                           {"stamp", ros::ros_time(now, ros::Version::kRos2)}});
    if (accepted) tell();
  }
  void ask(const Caller& caller, const RosValue& request) {
    const std::lock_guard lock(mutex_);
    if (request["goal_id"]["uuid"].bytes() != id_) {
      return results_.answer(caller, {{"status", RosValue(std::int64_t{kUnknown})}});
    }
    if (runs_) return waiting_.push_back(caller);
    answer(caller);
  }
  void take_cancel(const Caller& caller, const RosValue& request) {
    bool is_meant = false;
    {
      const std::lock_guard lock(mutex_);
      const RosValue& goal = request["goal_info"];
      const std::string_view id = goal["goal_id"]["uuid"].bytes();
      const std::int64_t stamp = ros::ros_nanoseconds(goal["stamp"]);
      const bool is_any = id.find_first_not_of('\0') == std::string_view::npos;
      is_meant = runs_ && (id == id_ || (is_any && (stamp == 0 || stamp_ <= stamp)));
      constexpr std::int64_t kNone = 0, kUnknownGoal = 2, kTerminated = 3;
      RosValue::List cancelled;
      if (is_meant) {
        state_ = kCanceling;
        cancelled.push_back(info());
        tell();
      }
      cancels_.answer(caller,
                      {{"return_code", RosValue(is_meant                    ? kNone
                                                : id == id_ && !id_.empty() ? kTerminated
                                                                            : kUnknownGoal)},
                       {"goals_canceling", RosValue(std::move(cancelled))}});
    }
    if (is_meant) handler_.cancel();
  }

  const std::string type_;
  const Handler handler_;
  std::mutex mutex_;  // guards the next six, and the order of what is published
  bool runs_ = false;
  std::string id_;
  std::int64_t stamp_ = 0, state_ = kUnknown;
  std::string result_;
  std::vector<Caller> waiting_;
  std::unique_ptr<RosPublisher> status_, feedback_;
  ServiceAnswerer results_, cancels_, goals_;
};

}  // namespace

std::unique_ptr<RosActionServer> serve_action(RosPeer& peer, const std::string& name,
                                              const std::string& type,
                                              RosActionServer::Handler handler) {
  if (peer.version() == ros::Version::kRos1) {
    return std::make_unique<Ros1ActionServer>(peer, name, type, std::move(handler));
  }
  return std::make_unique<Ros2ActionServer>(peer, name, type, std::move(handler));
}

}  // namespace prehend::drivers::ros_link
