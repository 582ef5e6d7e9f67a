#include "drivers/ros/driver/action_client.h"

#include <chrono>
#include <mutex>
#include <utility>

#include "drivers/ros/driver/goal_ids.h"
#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {
namespace {

using recording::RosError;
using recording::RosValue;
using Fields = RosValue::Fields;

/// The goal that is under way.
class CurrentGoal {
 public:
  void begin(const GoalId& id, RosActionClient::Done done) {
    const std::lock_guard lock(mutex_);
    id_ = id;
    done_ = std::move(done);
  }
  GoalId id() const {
    const std::lock_guard lock(mutex_);
    return id_;
  }
  bool is_running() const {
    const std::lock_guard lock(mutex_);
    return static_cast<bool>(done_);
  }
  /// Tells its end, once, if it is still this one.
  void end(const GoalId& id, GoalEnd end, const RosValue* result, const std::string& text) {
    RosActionClient::Done done;
    {
      const std::lock_guard lock(mutex_);
      if (id != id_ || !done_) return;
      done = std::exchange(done_, nullptr);
    }
    done(end, result, text);
  }

 private:
  mutable std::mutex mutex_;
  GoalId id_{};
  RosActionClient::Done done_;
};

std::int64_t wall_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

class Ros1ActionClient : public RosActionClient {
 public:
  Ros1ActionClient(RosPeer& peer, const std::string& name, const std::string& type)
      : type_(type),
        goal_(peer.advertise(name + "/goal", type + "ActionGoal", {})),
        cancel_(peer.advertise(name + "/cancel", "actionlib_msgs/GoalID", {})),
        result_(peer.subscribe(name + "/result", type + "ActionResult", {},
                               [this](std::string_view bytes) { take(bytes); })) {}

  bool has_server() const override { return goal_->readers() > 0 && result_->writers() > 0; }

  void send(const RosValue& goal, Done done) override {
    const GoalId id = random_goal_id();
    const std::string text = text_of(id);
    const RosValue stamp = ros::ros_time(wall_now(), ros::Version::kRos1);
    std::string bytes = write(
        type_ + "ActionGoal",
        RosValue(Fields{{"header", RosValue(Fields{{"stamp", stamp}})},
                        {"goal_id", RosValue(Fields{{"stamp", stamp}, {"id", RosValue(text)}})},
                        {"goal", goal}}));
    current_.begin(id, std::move(done));
    goal_->publish(std::move(bytes));
  }
  void cancel() override {
    if (!current_.is_running()) return;
    const std::string text = text_of(current_.id());
    cancel_->publish(write("actionlib_msgs/GoalID", RosValue(Fields{{"id", RosValue(text)}})));
  }

 private:
  static std::string write(const std::string& type, const RosValue& value) {
    return ros::type_of(type, ros::Version::kRos1).write(value, recording::RosEncoding::kRos1);
  }
  void take(std::string_view bytes) {
    try {
      const RosValue message = ros::type_of(type_ + "ActionResult", ros::Version::kRos1)
                                   .read(bytes, recording::RosEncoding::kRos1);
      const RosValue& status = message["status"];
      const GoalId id = current_.id();
      if (status["goal_id"]["id"].text() != text_of(id)) return;  // of another client
      const std::string text(status["text"].text());
      switch (status["status"].integer()) {
        case 3:  // SUCCEEDED
          return current_.end(id, GoalEnd::kSucceeded, &message["result"], text);
        case 2:  // PREEMPTED
        case 8:  // RECALLED
          return current_.end(id, GoalEnd::kCancelled, &message["result"], text);
        case 5:  // REJECTED
          return current_.end(id, GoalEnd::kRejected, nullptr, text);
        default:
          return current_.end(id, GoalEnd::kAborted, &message["result"], text);
      }
    } catch (const RosError& error) {
      current_.end(current_.id(), GoalEnd::kAborted, nullptr,
                   std::string("the server's result is not understood: ") + error.what());
    }
  }

  const std::string type_;
  CurrentGoal current_;
  std::unique_ptr<RosPublisher> goal_, cancel_;
  std::unique_ptr<RosSubscription> result_;
};

/// Half of a service of ROS 2: sends requests, takes the answers to them.
class ServiceCaller {
 public:
  using Take = std::function<void(std::int64_t sequence, const RosValue& response)>;
  using Damaged = std::function<void(const std::string&)>;
  ServiceCaller(RosPeer& peer, const std::string& name, const std::string& type, Take take,
                Damaged damaged)
      : type_(type),
        take_(std::move(take)),
        damaged_(std::move(damaged)),
        requests_(peer.advertise(name, type + "_Request", {}, RosChannel::kRequest)),
        replies_(peer.subscribe(
            name, type + "_Response", {}, [this](std::string_view bytes) { receive(bytes); },
            RosChannel::kReply)) {}

  bool has_server() const { return requests_->readers() > 0 && replies_->writers() > 0; }
  std::int64_t call(Fields fields) {
    const std::int64_t sequence = [this] {
      const std::lock_guard lock(mutex_);
      return ++sequence_;
    }();
    fields.emplace_back("client", RosValue(client_));
    fields.emplace_back("sequence", RosValue(sequence));
    requests_->publish(ros::type_of(type_ + "_Request", ros::Version::kRos2)
                           .write(RosValue(std::move(fields)), recording::RosEncoding::kCdr));
    return sequence;
  }

 private:
  void receive(std::string_view bytes) {
    try {
      const RosValue response = ros::type_of(type_ + "_Response", ros::Version::kRos2)
                                    .read(bytes, recording::RosEncoding::kCdr);
      const auto* client = std::get_if<std::uint64_t>(&response["client"].content());
      if (client && *client == client_) take_(response["sequence"].integer(), response);
    } catch (const RosError& error) {
      damaged_(std::string("the server's answer is not understood: ") + error.what());
    }
  }

  const std::string type_;
  const std::uint64_t client_ = random_client_id();
  std::mutex mutex_;
  std::int64_t sequence_ = 0;
  const Take take_;
  const Damaged damaged_;
  std::unique_ptr<RosPublisher> requests_;
  std::unique_ptr<RosSubscription> replies_;
};

class Ros2ActionClient : public RosActionClient {
 public:
  Ros2ActionClient(RosPeer& peer, const std::string& name, const std::string& type)
      : type_(type),
        send_(
            peer, name + "/_action/send_goal", type + "_SendGoal",
            [this](std::int64_t sequence, const RosValue& response) {
              answered(sequence, response);
            },
            [this](const std::string& why) { damaged(why); }),
        result_(
            peer, name + "/_action/get_result", type + "_GetResult",
            [this](std::int64_t sequence, const RosValue& response) { ended(sequence, response); },
            [this](const std::string& why) { damaged(why); }),
        cancel_(
            peer, name + "/_action/cancel_goal", "action_msgs/CancelGoal",
            [](std::int64_t, const RosValue&) {}, [](const std::string&) {}) {}

  bool has_server() const override {
    return send_.has_server() && result_.has_server() && cancel_.has_server();
  }
  void send(const RosValue& goal, Done done) override {
    const GoalId id = random_goal_id();
    const std::lock_guard lock(mutex_);  // until the request's number is known
    current_.begin(id, std::move(done));
    is_cancelled_ = is_accepted_ = false;
    sent_ = send_.call({{"goal_id", uuid(id)}, {"goal", goal}});
  }
  void cancel() override {
    const std::lock_guard lock(mutex_);
    is_cancelled_ = true;
    if (is_accepted_) ask_to_cancel();  // else once it is
  }

 private:
  static RosValue uuid(const GoalId& id) {
    return RosValue(Fields{{"uuid", ros::ros_bytes(bytes_of(id))}});
  }
  void ask_to_cancel() {
    const GoalId id = current_.id();
    cancel_.call({{"goal_info", RosValue(Fields{{"goal_id", uuid(id)}})}});
  }
  void answered(std::int64_t sequence, const RosValue& response) {
    {
      const std::lock_guard lock(mutex_);
      if (sequence != sent_) return;
      if (response["accepted"].integer() != 0) {
        is_accepted_ = true;
        const GoalId id = current_.id();
        asked_ = result_.call({{"goal_id", uuid(id)}});
        if (is_cancelled_) ask_to_cancel();
        return;
      }
    }
    current_.end(current_.id(), GoalEnd::kRejected, nullptr, {});
  }
  void ended(std::int64_t sequence, const RosValue& response) {
    {
      const std::lock_guard lock(mutex_);
      if (sequence != asked_) return;
    }
    // action_msgs/GoalStatus
    constexpr std::int64_t kSucceeded = 4, kCanceled = 5;
    const std::int64_t status = response["status"].integer();
    current_.end(current_.id(),
                 status == kSucceeded  ? GoalEnd::kSucceeded
                 : status == kCanceled ? GoalEnd::kCancelled
                                       : GoalEnd::kAborted,
                 &response["result"], {});
  }
  void damaged(const std::string& why) {
    current_.end(current_.id(), GoalEnd::kAborted, nullptr, why);
  }

  const std::string type_;
  CurrentGoal current_;
  std::mutex mutex_;  // guards the next four
  std::int64_t sent_ = 0, asked_ = 0;
  bool is_accepted_ = false, is_cancelled_ = false;
  ServiceCaller send_, result_, cancel_;
};

}  // namespace

const char* to_string(GoalEnd end) {
  switch (end) {
    case GoalEnd::kSucceeded:
      return "succeeded";
    case GoalEnd::kCancelled:
      return "was cancelled";
    case GoalEnd::kRejected:
      return "was rejected";
    default:
      return "was aborted";
  }
}

std::unique_ptr<RosActionClient> action_client(RosPeer& peer, const std::string& name,
                                               const std::string& type) {
  if (peer.version() == ros::Version::kRos1) {
    return std::make_unique<Ros1ActionClient>(peer, name, type);
  }
  return std::make_unique<Ros2ActionClient>(peer, name, type);
}

}  // namespace prehend::drivers::ros_link
