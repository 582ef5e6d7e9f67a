#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "nodes/report/collector.h"
#include "nodes/report/compose.h"
#include "nodes/report/processes.h"
#include "nodes/report/verdict.h"
#include "prehend/graph/node.h"

namespace {

using namespace prehend;

// Messages that were sent just before the result may still be under way.
constexpr auto kGrace = std::chrono::milliseconds(500);

void print_table(const std::vector<std::vector<std::string>>& rows) {
  std::size_t widest = 0;
  for (const auto& row : rows) widest = std::max(widest, row[0].size());
  for (const auto& row : rows) {
    std::printf("  %-*s  %s\n", static_cast<int>(widest), row[0].c_str(), row[1].c_str());
  }
}

void run(graph::Node& node) {
  const auto out = node.declare_parameter<std::string>(
      {.name = "out", .default_value = "out/report", .description = "folder of report.html"});
  const auto title = node.declare_parameter<std::string>(
      {.name = "title", .default_value = "prehend", .description = "title of the page"});
  const auto gripper_file = node.declare_parameter<std::string>(
      {.name = "gripper",
       .default_value = "config/robots/pg70_dsa.yaml",
       .description = "gripper model to draw"});
  const bool require_lift = node.declare_parameter<bool>(
      {.name = "require_lift",
       .default_value = false,
       .description = "also \"cannot be grasped\" is a failure"});
  const double timeout = node.declare_parameter<double>(
      {.name = "timeout",
       .default_value = 180.0,
       .unit = "s",
       .minimum = 1.0,
       .description = "wall time after which the run counts as failed"});
  const double patience = node.declare_parameter<double>(
      {.name = "patience",
       .default_value = 2.0,
       .unit = "s",
       .minimum = 0.0,
       .description = "wall time to wait for objects after a view without any"});
  const robot::GripperModel gripper = robot::read_gripper_model(gripper_file);

  nodes::Collector collector(node);
  node.spin_in_background();
  const bool ended = collector.wait_for_end(std::chrono::duration<double>(timeout),
                                            std::chrono::duration<double>(patience));
  std::string timeout_reason;
  if (!node.ok()) {
    timeout_reason = "stopped before the end";
  } else if (!ended) {
    timeout_reason = fmt::format("no result within {:.0f} s", timeout);
  } else {
    std::this_thread::sleep_for(kGrace);
  }

  const auto processes = nodes::list_processes();
  const nodes::Collected collected = collector.snapshot();
  const nodes::Verdict verdict = nodes::judge(collected, require_lift, timeout_reason);
  const auto page = nodes::compose_page(title, collected, verdict, gripper, processes);
  const auto file = std::filesystem::path(out) / "report.html";
  page.write(file);

  std::printf("\n%s\n", title.c_str());
  print_table(nodes::summarize(collected));
  std::printf("\n");
  print_table(nodes::stage_times(collected));
  std::printf("\n  %s: %s\n  report: %s\n\n",
              verdict.ungraspable ? "answer" : (verdict.success ? "success" : "failed"),
              verdict.text.c_str(), file.c_str());
  std::fflush(stdout);
  if (!verdict.success) throw std::runtime_error(verdict.text);
}

}  // namespace

int main(int argc, char** argv) {
  return prehend::graph::run_node(
      argc, argv,
      {"report",
       "Listens to a whole run and writes a page with pictures, charts and times when the grasp "
       "cycle has ended. Exits 0 on success, 1 with the reason otherwise."},
      run);
}
