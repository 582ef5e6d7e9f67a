#include "tools/own_message_types.h"

#include <google/protobuf/descriptor.h>

#include "msgs/actions.pb.h"
#include "msgs/geometry.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"

namespace prehend::tools {

const google::protobuf::Descriptor* own_message_type(const std::string& full_name) {
  // Naming one message of each file links all of that file's into the program and its pool.
  const auto* pool = msgs::Header::descriptor()->file()->pool();
  [[maybe_unused]] const google::protobuf::FileDescriptor* files[] = {
      msgs::MoveGripperGoal::descriptor()->file(), msgs::GraspPlan::descriptor()->file(),
      msgs::ObjectHypotheses::descriptor()->file(), msgs::GripperCommand::descriptor()->file(),
      msgs::graph::LogLine::descriptor()->file()};
  return pool->FindMessageTypeByName(full_name);
}

}  // namespace prehend::tools
