#pragma once

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {

struct Result {
  int exit_code;
  std::string output;
};

/// Parses JSON by protobuf, which refuses what is none.
inline google::protobuf::Value parsed(const std::string& text) {
  google::protobuf::Value value;
  const auto status = google::protobuf::util::JsonStringToMessage(text, &value);
  EXPECT_TRUE(status.ok()) << status.ToString() << "\n" << text;
  return value;
}

/// Member of a JSON object; a failure when it is not there.
inline google::protobuf::Value member(const google::protobuf::Value& object,
                                      const std::string& name) {
  const auto& fields = object.struct_value().fields();
  const auto found = fields.find(name);
  if (found != fields.end()) return found->second;
  ADD_FAILURE() << "no member " << name << " in " << object.ShortDebugString();
  return {};
}

inline std::string text_of(const google::protobuf::Value& object, const std::string& name) {
  return member(object, name).string_value();
}

/// Element of a JSON array whose member `name` is `text`; a failure when there is none.
inline google::protobuf::Value element(const google::protobuf::Value& array,
                                       const std::string& name, const std::string& text) {
  for (const auto& value : array.list_value().values()) {
    const auto& fields = value.struct_value().fields();
    if (fields.count(name) && fields.at(name).string_value() == text) return value;
  }
  ADD_FAILURE() << "no element with " << name << " = " << text << " in "
                << array.ShortDebugString();
  return {};
}

/// The node "arm" publishes /camera/stereo at 100 Hz, takes /gripper/command, serves /add_one and
/// /count; the prehend command runs as a process.
class Command : public ::testing::Test {
 protected:
  Command()
      : registry_(graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}),
        node_(node_options("arm")) {
    node_.declare_parameter<double>({.name = "speed",
                                     .default_value = 1.5,
                                     .unit = "m/s",
                                     .minimum = 0,
                                     .maximum = 10,
                                     .description = "of the arm"});
    node_.declare_parameter<std::string>({.name = "tool.name", .default_value = "a \"b\": c"});
    camera_ = node_.advertise<msgs::StereoPair>("/camera/stereo", graph::QoS::latched(1));
    command_ = node_.subscribe<msgs::GripperCommand>(
        "/gripper/command", graph::QoS::queue(10),
        [this](const graph::Received<msgs::GripperCommand>& command) {
          value_ = command->value();
          ++commands_;
        });
    service_ = node_.serve<msgs::Clock, msgs::Clock>("/add_one", [](const msgs::Clock& request) {
      if (request.time() < 0) throw std::runtime_error("negative");
      msgs::Clock response;
      response.set_time(request.time() + 1);
      return response;
    });
    // Counts to the goal's `opening`, one feedback each 10 ms; endless when it is negative.
    action_ = node_.serve_action<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                 msgs::MoveGripperResult>(
        "/count", [](const msgs::MoveGripperGoal& goal,
                     graph::ActionContext<msgs::MoveGripperFeedback>& context) {
          msgs::MoveGripperFeedback feedback;
          msgs::MoveGripperResult result;
          while (!context.cancelled() && feedback.opening() != goal.opening()) {
            feedback.set_opening(feedback.opening() + 1);
            context.feedback(feedback);
            context.sleep_for(std::chrono::milliseconds(10));
          }
          result.set_opening(feedback.opening());
          result.set_reached(!context.cancelled());
          return result;
        });
    timer_ = node_.create_timer(0.01, [this] {
      msgs::StereoPair pair;
      pair.mutable_header()->set_frame_id("left_camera");
      pair.mutable_header()->set_stamp(node_.clock().now() - 500'000'000);
      pair.set_width(640);
      pair.set_data(std::string(5000, 'x'));
      camera_.publish(pair);
    });
    node_.spin_in_background();
  }

  graph::NodeOptions node_options(const std::string& name) const {
    graph::NodeOptions options;
    options.name = name;
    options.registry = registry_.endpoint();
    return options;
  }

  Result run(const std::vector<std::string>& arguments) {
    ChildProgram program("prehend", arguments, scratch_.path("out.txt"), registry_.endpoint());
    return {program.wait(std::chrono::seconds(20)).value_or(-1), program.output()};
  }

  ScratchDirectory scratch_;
  graph::Registry registry_;
  std::atomic<double> value_{0};
  std::atomic<int> commands_{0};
  graph::Node node_;
  graph::Publisher<msgs::StereoPair> camera_;
  graph::Subscription command_;
  graph::Service service_;
  graph::ActionServer action_;
  graph::Node::Timer timer_;
};

}  // namespace prehend::testing
