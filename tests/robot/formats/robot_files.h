#pragma once

#include <unistd.h>

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/robot_format.h"

namespace prehend::robot::formats {

/// Tests of robots' files, in a folder that goes with them.
class RobotFiles : public testing::Test {
 protected:
  RobotFiles() { std::filesystem::create_directories(folder_); }
  ~RobotFiles() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  RobotDescription read(const std::string& name, const std::string& text) {
    loss_ = {};
    return read_robot(file(name, text), loss_);
  }
  std::string error_of(const std::string& name, const std::string& text) {
    try {
      read(name, text);
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return {};
  }
  /// What the format writes of it, read again.
  RobotDescription written_and_read(const RobotDescription& robot,
                                    const std::string& format) const {
    LossReport unused;
    const std::filesystem::path path = folder_ / ("again" + format_named(format).ending());
    std::ofstream(path) << format_named(format).write(robot, unused);
    return read_robot(path, unused);
  }
  /// A file of the models that are not of this repository; empty: they are not there.
  static std::filesystem::path shared_model(const std::string& name) {
    const char* shared = std::getenv("PREHEND_SHARED_DATA");
    const std::filesystem::path path =
        shared ? std::filesystem::path(shared) / "models" / name : std::filesystem::path();
    return std::filesystem::exists(path) ? path : std::filesystem::path();
  }
  static std::vector<std::string> written_formats() {
    std::vector<std::string> names;
    for (const auto& format : robot_formats()) {
      if (format->can_write()) names.push_back(format->name());
    }
    return names;
  }
  using ForRobot = std::function<void(const std::filesystem::path&, const RobotDescription&)>;
  /// Calls with each robot of those folders' files that is read; parts, worlds, and faults that are
  /// wanted are not. @returns how many
  static int for_each_shared_robot(const ForRobot& call) {
    int count = 0;
    for (const char* folder : {"models", "robots"}) {
      const std::filesystem::path below = shared_model("").parent_path().parent_path() / folder;
      for (const auto& entry : std::filesystem::recursive_directory_iterator(below)) {
        std::string ending = entry.path().extension().string();
        for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (ending != ".urdf" && ending != ".sdf" && ending != ".xml" && ending != ".dae" &&
            ending != ".zae") {
          continue;
        }
        RobotDescription robot;
        LossReport unused;
        try {
          robot = read_robot(entry.path(), unused);
        } catch (const geometry::InputError&) {
          continue;
        }
        ++count;
        call(entry.path(), robot);
      }
    }
    return count;
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("prehend_files_" + std::to_string(::getpid()));
  LossReport loss_;
};

}  // namespace prehend::robot::formats
