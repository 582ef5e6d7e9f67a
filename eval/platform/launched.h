#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace prehend::eval {

/// Runs `prehend WORDS` of the folder `programs`, its output in `log`. @return the exit code, -1
/// when it took longer than `timeout` and was stopped as by ctrl-C.
/// @throws std::runtime_error when it cannot be started.
int run_prehend(const std::filesystem::path& programs, const std::vector<std::string>& words,
                const std::filesystem::path& log, std::chrono::seconds timeout);

/// `prehend launch launch/demo.yaml` for a platform in a scene's file, as fast as it can, with
/// report, log, its output (output.txt) and its recording (recording.mcap) in `folder`.
/// @return as run_prehend(). @throws as that, and geometry::InputError with the last line that it
/// said when it left no recording: it was not begun.
int run_demo(const std::filesystem::path& programs, const std::filesystem::path& scene,
             const std::string& platform, const std::filesystem::path& folder,
             const std::vector<std::string>& arguments, std::chrono::seconds timeout);

/// `words`, when each is NAME:=VALUE; whether launch/demo.yaml has them the launch says.
/// @throws geometry::InputError naming what is none, or what run_demo() gives itself.
std::vector<std::string> launch_arguments(const std::vector<std::string>& words);

}  // namespace prehend::eval
