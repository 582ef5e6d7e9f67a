#include "prehend/text/tree_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace prehend::text {
namespace {

namespace fs = std::filesystem;

class TreeFile : public testing::Test {
 protected:
  TreeFile() {
    std::string name = (fs::temp_directory_path() / "prehend_tree_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    fs::current_path(folder_);
    ::unsetenv("PREHEND_ROOT");
  }
  ~TreeFile() override {
    fs::current_path(before_);
    ::unsetenv("PREHEND_ROOT");
    fs::remove_all(folder_);
  }
  void put(const std::string& name) {
    fs::create_directories(fs::path(name).parent_path());
    std::ofstream(name) << "x";
  }

  const fs::path before_ = fs::current_path();
  fs::path folder_;
};

TEST_F(TreeFile, IsFoundHereThenInTheRootThenAboveTheProgram) {
  const std::string name = "config/tree_file_test/a.yaml";
  EXPECT_EQ(tree_file(name), name) << "nobody has it: who reads it will say so";
  // Above this program: beside its own folder.
  const fs::path top = fs::read_symlink("/proc/self/exe").parent_path().parent_path();
  put((top / name).string());
  EXPECT_EQ(tree_file(name), (top / name).string());
  put("other/" + name);
  ::setenv("PREHEND_ROOT", (folder_ / "other").c_str(), 1);
  EXPECT_EQ(tree_file(name), (folder_ / "other" / name).string());
  put(name);
  EXPECT_EQ(tree_file(name), name);
  fs::remove_all(top / "config" / "tree_file_test");
  std::error_code not_empty;
  fs::remove(top / "config", not_empty);
}

TEST_F(TreeFile, FindsTheDefaultsOfTheTreeFromAnywhere) {
  EXPECT_TRUE(fs::exists(tree_file("config/robots/pg70_dsa.yaml")));
}

}  // namespace
}  // namespace prehend::text
