#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <thread>

#include "nodes/gripper_source/gripper_source.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/report/collector.h"
#include "nodes/report/compose.h"
#include "nodes/report/processes.h"
#include "nodes/report/saved.h"
#include "nodes/report/verdict.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;

// Messages that were sent just before the result may still be under way.
constexpr auto kGrace = std::chrono::milliseconds(500);
constexpr double kStopTime = 15;  // s, for the page to be drawn and written

std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::size_t widest = 0;
  for (const auto& row : rows) widest = std::max(widest, row[0].size());
  std::string text;
  for (const auto& row : rows) text += fmt::format("  {:<{}}  {}\n", row[0], widest, row[1]);
  return text;
}

const char* kind_name(nodes::Verdict::Kind kind) {
  switch (kind) {
    case nodes::Verdict::Kind::kSuccess:
      return "success";
    case nodes::Verdict::Kind::kNotGraspable:
      return "not graspable";
    case nodes::Verdict::Kind::kFailure:
      return "failed";
  }
  return "";
}

std::string summary_text(const std::string& title, const nodes::Collected& collected,
                         const nodes::Verdict& verdict, const std::filesystem::path& page) {
  return "\n" + title + "\n" + aligned(nodes::summarize(collected)) + "\n" +
         aligned(nodes::stage_times(collected)) + "\n  report: " + page.string() + "\n  " +
         kind_name(verdict.kind) + ": " + verdict.text + "\n";
}

int run(graph::Node& node) {
  const auto out =
      node.declare_parameter<std::string>({.name = "out",
                                           .default_value = "out/report",
                                           .description = "folder of report.html and summary.txt",
                                           .read_only = true});
  const auto title = node.declare_parameter<std::string>({.name = "title",
                                                          .default_value = "prehend",
                                                          .description = "title of the page",
                                                          .read_only = true});
  const auto save = node.declare_parameter<std::string>(
      {.name = "save",
       .description = "folder for the predicted meshes (object_K.ply, .obj, .stl; metres, world "
                      "frame) and their grasps (object_K_grasps.json); empty: none",
       .read_only = true});
  const auto platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "stage_pg70",
       .description =
           "the robot that is drawn, its name (stage_pg70, kr5_sdh, ...) or file; of one "
           "whose gripper says what it is, the gripper",
       .read_only = true});
  const std::string platforms = nodes::declare_platforms(node);
  nodes::GripperSource gripper(node);
  const double timeout = node.declare_parameter<double>(
      {.name = "timeout",
       .default_value = 180.0,
       .unit = "s",
       .minimum = 1.0,
       .description = "wall time without anything new seen, planned or done, after which the run "
                      "counts as failed",
       .read_only = true});
  const double patience = node.declare_parameter<double>(
      {.name = "patience",
       .default_value = 2.0,
       .unit = "s",
       .minimum = 0.0,
       .description = "wall time to wait for objects after a view without any",
       .read_only = true});
  const robot::Platform drawn = robot::read_platform(robot::platform_file(platforms, platform));
  const bool has_gripper = drawn.hand_port == robot::HandPort::kGripper;
  if (has_gripper) gripper.listen();
  std::unique_ptr<nodes::DrawnRobot> robot =
      has_gripper ? nodes::make_drawn(*drawn.hand.gripper) : nodes::make_drawn(drawn);
  nodes::Collector collector(
      node, robot->pads(),
      has_gripper ? nodes::Collector::Moves::kGripper : nodes::Collector::Moves::kJoints);
  node.spin_in_background();
  const bool ended = collector.wait_for_end(std::chrono::duration<double>(timeout),
                                            std::chrono::duration<double>(patience));
  std::string timeout_reason;
  if (!node.ok()) {
    timeout_reason = "stopped before the end";
  } else if (!ended) {
    timeout_reason = fmt::format("no result, and nothing new for {:.0f} s", timeout);
  } else {
    std::this_thread::sleep_for(kGrace);
  }

  const auto processes = nodes::list_processes();
  const nodes::Collected collected = collector.snapshot();
  const nodes::Verdict verdict = nodes::judge(collected, timeout_reason);
  if (const auto model = gripper.model()) {
    robot = nodes::make_drawn(*model);
  } else if (has_gripper) {
    // Pictures do not need it to the millimetre: without a word the platform's is drawn.
    node.log_warning("the gripper is drawn as {}: {}", drawn.hand.gripper->name, gripper.missing());
  }
  const auto page = nodes::compose_page(title, collected, verdict, *robot, drawn, processes);
  const auto file = std::filesystem::path(out) / "report.html";
  page.write(file);

  const std::string summary = summary_text(title, collected, verdict, file);
  std::ofstream(std::filesystem::path(out) / "summary.txt") << summary;
  std::fputs(summary.c_str(), stdout);
  std::fflush(stdout);
  if (!save.empty()) nodes::save_predictions(collected, save);
  if (verdict.kind == nodes::Verdict::Kind::kFailure) throw std::runtime_error(verdict.text);
  return verdict.kind == nodes::Verdict::Kind::kSuccess ? 0 : graph::kAnswerIsNo;
}

const prehend::graph::RegisteredNodeProgram registered(
    {"report",
     "Listens to a whole run and writes a page with pictures, charts and times when the grasp "
     "cycle has ended. Exits 0 on success, 3 when nothing can be grasped, 1 with the reason "
     "otherwise.",
     kStopTime},
    run);

}  // namespace
