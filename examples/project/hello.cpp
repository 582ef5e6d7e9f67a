#include <string>

#include "msgs/sensors.pb.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;

void run(graph::Node& node) {
  const auto word = node.declare_parameter<std::string>(
      {.name = "word", .default_value = "hello", .description = "to say", .read_only = true});
  const auto publisher = node.advertise<msgs::Clock>("/hello", graph::QoS::latched());
  publisher.publish(msgs::Clock());
  node.log_info("{}", word);
  node.spin();
}

const graph::RegisteredNodeProgram registered({"hello", "Says hello."}, run);

}  // namespace
