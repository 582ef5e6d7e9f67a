#include "nodes/gripper_source/gripper_source.h"

#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/gripper.h"

namespace prehend::nodes {
namespace {

std::string listed(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : "; ") + word;
  return all;
}

}  // namespace

GripperSource::GripperSource(graph::Node& node) : node_(node) {
  const auto file = node.declare_parameter<std::string>(
      {.name = "gripper",
       .description = "gripper model (config/robots), for a graph without a robot; empty: the one "
                      "that the robot has (/gripper/model)",
       .read_only = true,
       .reads_file = true});
  if (file.empty()) return;
  said_[""] = {convert::describe_gripper(file), robot::read_gripper_model(file),
               file + " (parameter gripper)", ""};
  decide();
}

void GripperSource::listen(std::function<void()> on_news) {
  on_news_ = std::move(on_news);
  subscription_ = node_.subscribe<msgs::GripperDescription>(
      "/gripper/model", graph::QoS::latched(4), [this](const auto& message) { take(message); });
}

void GripperSource::take(const graph::Received<msgs::GripperDescription>& message) {
  const std::string sender(message.info().sender);
  Said said{*message, {}, fmt::format("{} (node {})", message->file(), sender), ""};
  said.broken = node_.shield("gripper of node " + sender,
                             [&] { said.model = convert::from_message(*message); });
  std::string problem;
  {
    const std::lock_guard lock(mutex_);
    said_[sender] = said;
    decide();
    problem = problem_;
  }
  if (problem.empty()) {
    node_.report(graph::Health::kOk, "the gripper is " + said.model.name + " of " + said.place);
  } else {
    node_.report(graph::Health::kError, problem);
  }
  if (on_news_) on_news_();
}

void GripperSource::decide() {
  model_.reset();
  description_.Clear();
  problem_.clear();
  const Said* first = nullptr;
  for (const auto& [sender, said] : said_) {
    if (!said.broken.empty()) {
      problem_ = "The gripper of " + said.place + " cannot be read: " + said.broken;
      return;
    }
    if (!first) {
      first = &said;
      continue;
    }
    const auto different = robot::differences(first->model, said.model);
    if (different.empty()) continue;
    problem_ = fmt::format(
        "Two grippers: {} and {} differ in {}. Name one file in both places, or leave the "
        "parameter "
        "gripper empty",
        first->place, said.place, listed(different));
    return;
  }
  if (!first) return;
  model_ = first->model;
  description_ = first->description;
}

std::optional<robot::GripperModel> GripperSource::model() const {
  const std::lock_guard lock(mutex_);
  return model_;
}

msgs::GripperDescription GripperSource::description() const {
  const std::lock_guard lock(mutex_);
  return description_;
}

std::string GripperSource::differs_from(const msgs::GraspPlan& plan) const {
  if (!plan.has_gripper()) return "";
  const robot::GripperModel planned = convert::from_message(plan.gripper());
  const std::lock_guard lock(mutex_);
  if (!model_) return "";
  const auto different = robot::differences(planned, *model_);
  if (different.empty()) return "";
  return fmt::format(
      "the grasps were planned for the gripper of {}, the robot has that of {}; they differ in {}. "
      "Leave the planner's parameter gripper empty, or name the robot's file",
      plan.gripper().file(), description_.file(), listed(different));
}

std::string GripperSource::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

std::string GripperSource::missing() const {
  const std::lock_guard lock(mutex_);
  if (model_) return "";
  if (!problem_.empty()) return problem_;
  return "no robot says which gripper it has (/gripper/model). Start one, or give the parameter "
         "gripper";
}

}  // namespace prehend::nodes
