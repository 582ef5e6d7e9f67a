#include "prehend/text/plug_ins.h"

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

namespace fs = std::filesystem;

struct Tool {
  std::string name() const { return "hammer"; }
};
Tool* create_tool() { return std::make_unique<Tool>().release(); }

TEST(PlugInFolders, AreOfTheEnvironmentOrBesideTheProgram) {
  ASSERT_EQ(setenv("PREHEND_TOOLS", "/one::/two", 1), 0);
  EXPECT_EQ(plug_in_folders("tool"), (std::vector<fs::path>{"/one", "/two"}));
  ASSERT_EQ(setenv("PREHEND_TOOLS", "", 1), 0);
  EXPECT_TRUE(plug_in_folders("tool").empty());
  unsetenv("PREHEND_TOOLS");
  const auto beside = plug_in_folders("tool");
  ASSERT_EQ(beside.size(), 1u);
  EXPECT_TRUE(beside[0].string().ends_with("lib/prehend/tools")) << beside[0];
}

TEST(NamedPlugIns, NamesTheNearestAllAndWhatCannotBeUsed) {
  const fs::path folder = fs::path(::testing::TempDir()) / "prehend_tools";
  fs::create_directories(folder);
  std::ofstream(folder / "broken.so") << "no library";
  std::ofstream(folder / "read.me") << "not looked at";
  const NamedPlugIns<Tool> tools("tool", 1, {folder, "/nowhere"},
                                 {{"saw", create_tool}, {"hammer", create_tool}});
  EXPECT_EQ(tools.names(), (std::vector<std::string>{"hammer", "saw"}));
  EXPECT_TRUE(tools.has("saw"));
  EXPECT_EQ(tools.find("hammer"), create_tool);
  ASSERT_EQ(tools.problems().size(), 1u);
  EXPECT_EQ(tools.problems()[0].file.filename(), "broken.so");
  try {
    tools.find("hamer");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what())
                  .find("there is no tool 'hamer'; the nearest is 'hammer'; "
                        "there are hammer, saw; broken.so cannot be used: "),
              0u)
        << error.what();
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace prehend::text
