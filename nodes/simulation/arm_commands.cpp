#include "nodes/simulation/arm_commands.h"

#include <stdexcept>

namespace prehend::nodes {

ArmCommands::ArmCommands(graph::Node& node, CommandedArm& arm,
                         const EmergencyStopListener& emergency)
    : node_(node),
      arm_(arm),
      emergency_(emergency),
      subscription_(node.subscribe<msgs::JointCommand>(
          "/arm/command", graph::QoS::queue(20),
          [this](const graph::Received<msgs::JointCommand>& message) { command(*message); })) {}

void ArmCommands::command(const msgs::JointCommand& command) {
  try {
    switch (command.mode()) {
      case msgs::JointCommand::STOP:
        arm_.command_arm({}, {});
        break;
      case msgs::JointCommand::POSITION:
        if (command.joint_name().empty()) throw std::invalid_argument("no joint is named");
        if (command.joint_name_size() != command.value_size()) {
          throw std::invalid_argument("it has not one value a joint");
        }
        if (const std::string why = emergency_.refusal(); !why.empty()) {
          throw std::invalid_argument(why);
        }
        if (arm_.command_arm({command.joint_name().begin(), command.joint_name().end()},
                             {command.value().begin(), command.value().end()})) {
          node_.log_info("/arm/command moves the arm");
        }
        if (!emergency_.refusal().empty()) arm_.command_arm({}, {});  // it came meanwhile
        break;
      default:
        throw std::invalid_argument("an arm takes POSITION and STOP alone");
    }
    said_.clear();
  } catch (const std::invalid_argument& error) {
    // A stream goes on: what is wrong with it is said when it begins.
    const std::string words = error.what();
    if (words != said_) node_.log_warning("/arm/command refused: {}", words);
    said_ = words;
  }
}

}  // namespace prehend::nodes
