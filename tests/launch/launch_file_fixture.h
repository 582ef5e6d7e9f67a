#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "prehend/launch/launch_file.h"

namespace prehend::launch {

/// Launch files in a folder of their own, with empty programs to name.
class LaunchFileTest : public testing::Test {
 protected:
  LaunchFileTest() {
    std::string name = (std::filesystem::temp_directory_path() / "prehend_launch_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    std::filesystem::create_directories(folder_ / "launch");
    std::filesystem::create_directories(folder_ / "bin");
    for (const char* program : {"simulation", "grasp_planning", "report", "test_other"}) {
      std::ofstream(folder_ / "bin" / program) << "#!/bin/sh\n";
      std::filesystem::permissions(folder_ / "bin" / program, std::filesystem::perms::owner_all);
    }
  }
  ~LaunchFileTest() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = folder_ / "launch" / name;
    std::ofstream(path) << text;
    return path.string();
  }
  LaunchGraph load(const std::string& text, const std::vector<std::string>& arguments = {}) {
    return load_launch_file(write("a.yaml", text), parse_arguments(arguments),
                            (folder_ / "bin").string());
  }
  std::string error_of(const std::string& text, const std::vector<std::string>& arguments = {}) {
    try {
      load(text, arguments);
    } catch (const LaunchError& error) {
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

}  // namespace prehend::launch
