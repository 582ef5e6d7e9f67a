// The other process of the graph's tests: MODE [options of run_node].

#include <thread>

#include "msgs/actions.pb.h"
#include "msgs/geometry.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"

namespace {

using namespace prehend;
using namespace std::chrono_literals;

msgs::Clock clock_message(std::int64_t time) {
  msgs::Clock message;
  message.set_time(time);
  return message;
}

// Publishes 1 … count on /numbers at once, then ticks on /ticks.
void talk(graph::Node& node) {
  const int count = node.declare_parameter<int>({.name = "count", .default_value = 10});
  auto numbers = node.advertise<msgs::Clock>("/numbers", graph::QoS::queue(5000));
  auto ticks = node.advertise<msgs::Clock>("/ticks", graph::QoS::queue(10));
  for (int i = 1; i <= count; ++i) numbers.publish(clock_message(i));
  std::int64_t tick = 0;
  auto timer = node.create_timer(0.01, [&] { ticks.publish(clock_message(++tick)); });
  node.spin();
}

void listen(graph::Node& node) {
  std::int64_t sum = 0;
  auto subscription =
      node.subscribe<msgs::Clock>("/numbers", graph::QoS::queue(10),
                                  [&](const graph::Received<msgs::Clock>& m) { sum += m->time(); });
  node.spin();
}

// Keeps every message of /big for ever.
void hoard(graph::Node& node) {
  std::vector<graph::Received<msgs::PointCloud>> kept;
  auto subscription = node.subscribe<msgs::PointCloud>(
      "/big", graph::QoS::queue(100),
      [&](const graph::Received<msgs::PointCloud>& m) { kept.push_back(m); });
  node.spin();
}

// /answer answers; /hang and the action /hang_action do not before the process dies.
void serve(graph::Node& node) {
  auto answer = node.serve<msgs::Clock, msgs::Clock>(
      "/answer", [](const msgs::Clock& request) { return clock_message(request.time() + 1); });
  auto hang = node.serve<msgs::Clock, msgs::Clock>("/hang", [](const msgs::Clock& request) {
    std::this_thread::sleep_for(60s);
    return request;
  });
  auto action = node.serve_action<msgs::Clock, msgs::Clock, msgs::Clock>(
      "/hang_action", [](const msgs::Clock& goal, graph::ActionContext<msgs::Clock>& context) {
        context.feedback(goal);
        std::this_thread::sleep_for(60s);
        return goal;
      });
  node.spin();
}

// Sends a goal to /count and waits.
void command(graph::Node& node) {
  auto client = node.action_client<msgs::Clock, msgs::Clock, msgs::Clock>("/count");
  const auto goal = client.send(clock_message(1000000));
  node.spin();
}

// Sends a goal to /pour; says on /ended when that is over, and on /heard what came on /numbers.
void take_part(graph::Node& node) {
  const auto ended = node.advertise<msgs::Clock>("/ended", graph::QoS::latched(1));
  const auto heard = node.advertise<msgs::Clock>("/heard", graph::QoS::queue(1000));
  const auto numbers = node.subscribe<msgs::Clock>(
      "/numbers", graph::QoS::queue(10),
      [&](const graph::Received<msgs::Clock>& m) { heard.publish(*m); });
  const auto client = node.action_client<msgs::Clock, msgs::Clock, msgs::Clock>("/pour");
  const auto goal = client.send(clock_message(1), [](const msgs::Clock&) {});
  goal.on_result([&](const auto& outcome) {
    ended.publish(clock_message(static_cast<std::int64_t>(outcome.status())));
  });
  node.spin();
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "";
  const auto set_up = mode == "talk"        ? talk
                      : mode == "listen"    ? listen
                      : mode == "hoard"     ? hoard
                      : mode == "serve"     ? serve
                      : mode == "take_part" ? take_part
                                            : command;
  return prehend::graph::run_node(argc - 1, argv + 1, {"test_" + mode, "A node for tests."},
                                  set_up);
}
