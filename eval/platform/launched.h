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

/// Words of `prehend launch launch/demo.yaml` for a platform in a scene's file, as fast as it can,
/// recording, with report, log and recording in `folder`; then `arguments`.
std::vector<std::string> demo_words(const std::filesystem::path& scene, const std::string& platform,
                                    const std::filesystem::path& folder,
                                    const std::vector<std::string>& arguments);

/// `words`, when each is NAME:=VALUE; whether launch/demo.yaml has them the launch says.
/// @throws geometry::InputError naming what is none, or what demo_words() gives itself.
std::vector<std::string> launch_arguments(const std::vector<std::string>& words);

}  // namespace prehend::eval
