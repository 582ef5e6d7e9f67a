#include "prehend/geometry/whole_file.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>
#include <iterator>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

class WholeFile : public ::testing::Test {
 protected:
  WholeFile() {
    std::string name = (std::filesystem::temp_directory_path() / "whole_file_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the test");
    folder_ = name;
  }
  ~WholeFile() override { std::filesystem::remove_all(folder_); }

  static std::string content_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::size_t files() const {
    const std::filesystem::directory_iterator all(folder_);
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
  }

  std::filesystem::path folder_;
};

TEST_F(WholeFile, TakesThePlaceOfTheOldOne) {
  const auto file = folder_ / "a.yaml";
  write_whole_file(file, "old and longer", "The thing");
  write_whole_file(file, "new", "The thing");
  EXPECT_EQ(content_of(file), "new\n");
  EXPECT_EQ(files(), 1u);
}

TEST_F(WholeFile, WhatCannotBeWrittenIsNamedAndLeavesNothing) {
  for (const auto& file : {folder_ / "missing" / "a.yaml", folder_ / "taken"}) {
    std::filesystem::create_directories(folder_ / "taken" / "by a folder");
    try {
      write_whole_file(file, "text", "The thing");
      ADD_FAILURE() << file;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find("The thing '" + file.string()), 0u) << error.what();
    }
  }
  EXPECT_EQ(files(), 1u);
}

}  // namespace
}  // namespace prehend::geometry
