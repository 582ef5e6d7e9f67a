#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace prehend::eval {

/// How the task clear_table went in one scene, by the simulation's truth.
struct ClearResult {
  std::string scene, platform, kind;
  int bodies = 0;
  int cleared = 0;                     // that stand where the task puts things
  std::vector<std::string> graspable;  // of the bodies, see graspable_bodies()
  int found = 0;                       // objects of the first look
  int attempts = 0;                    // to lift something
  int pushes = 0;                      // of what could not be grasped as it stood
  int neighbours = 0;                  // times that an attempt moved another body by more than 2 cm
  double simulated = 0;                // s, from the first approach to the end
  double seconds = 0;                  // wall time of the launch
  bool ended = false;                  // by a result of the cycle; else it was stopped, or died
  std::string reason;                  // in words, how it ended
  std::vector<std::string> left;       // bodies that were not cleared
  std::map<std::string, int> failures;  // failed attempts by cause, see cause_of()
  std::map<std::string, int> said;      // the same in the cycle's words

  /// Of the graspable ones. What was never simulated was not cleared.
  int graspable_cleared() const;
  double picks_an_hour() const { return simulated > 0 ? 3600 * cleared / simulated : 0; }
};

/// What made an attempt fail, by the cycle's words: motion (an arm's path, something hit), shape
/// (the fingers closed on nothing), slip (lost while it was lifted, carried or put down), touch
/// (what the pads foretold), other.
std::string cause_of(const std::string& words);

/// Launches launch/demo.yaml with the task clear_table in the scene of `file`, as fast as it can,
/// and judges its recording. `folder` gets recording, report and log.
/// @param programs folder of `prehend`. @throws std::runtime_error when it cannot be started.
ClearResult run_clear(const std::filesystem::path& file, const std::string& platform,
                      const std::vector<std::string>& arguments,
                      const std::filesystem::path& folder, const std::filesystem::path& programs);

/// As YAML, and back. @throws geometry::InputError for a text that is no result.
std::string to_text(const ClearResult& result);
ClearResult read_clear(const std::string& text);

}  // namespace prehend::eval
