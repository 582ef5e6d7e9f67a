#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/platform/table_scene.h"

namespace prehend::eval {

/// How a launch on one scene ended, by the simulation's truth.
struct PickResult {
  enum class Outcome {
    kPicked,      // raised, carried, put down, and nothing else moved by more than 2 cm
    kNoGrasp,     // the answer was that nothing can be grasped
    kFailed,      // it said so
    kFalseClaim,  // it said success, the truth does not
  };
  std::string scene, platform;
  int bodies = 0;
  Outcome outcome = Outcome::kFailed;
  std::string body;      // that was raised most; empty: none
  double raised = 0;     // m
  double carried = 0;    // m, along the table
  double disturbed = 0;  // m, that any other body was moved
  int attempts = 0;
  double score = 0;    // of the executed grasp
  double seconds = 0;  // wall time of the launch
  std::string stage;   // where it ended: objects, shapes, models, plans, or the cycle's phase
  std::string reason;  // in words
};

std::string to_string(PickResult::Outcome outcome);

/// Launches launch/demo.yaml with that platform in the scene, as fast as it can, and judges its
/// recording. `folder` gets the scene, the recording and the report.
/// @param arguments further ones of the launch file, as launch_arguments() checks them.
/// @param programs folder of `prehend`. @throws std::runtime_error when it cannot be started.
PickResult run_pick(const TableScene& scene, const std::string& platform,
                    const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::filesystem::path& programs);

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const PickResult& result);
PickResult read_pick(const std::string& text);

}  // namespace prehend::eval
