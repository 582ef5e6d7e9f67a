#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot {

/// A copy of a shipped robot's file beside copies of all others, with one piece of text replaced.
class RobotFile : public testing::Test {
 protected:
  RobotFile()
      : folder_(std::filesystem::temp_directory_path() /
                ("prehend_robots_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::copy("config/robots", folder_);
  }
  ~RobotFile() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path changed(const std::string& file, const std::string& from,
                                const std::string& to) const {
    std::ifstream in("config/robots/" + file);
    std::stringstream text;
    text << in.rdbuf();
    std::string all = text.str();
    const std::size_t place = all.find(from);
    EXPECT_NE(place, std::string::npos) << file << " has no '" << from << "'";
    if (place != std::string::npos) all.replace(place, from.size(), to);
    std::ofstream(folder_ / file) << all;
    return folder_ / file;
  }

  /// What `read` complains of; "" when it does not.
  template <class Read>
  static std::string error_of(Read read) {
    try {
      read();
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

}  // namespace prehend::robot
