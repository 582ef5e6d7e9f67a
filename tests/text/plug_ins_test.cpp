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

// Those of the environment once took the place of those that ship.
TEST(PlugInFolders, AreOfTheEnvironmentAndBesideTheProgram) {
  unsetenv("PREHEND_TOOLS");
  const auto shipped = plug_in_folders("tool");
  ASSERT_EQ(shipped.size(), 1u);
  EXPECT_TRUE(shipped[0].string().ends_with("lib/prehend/tools")) << shipped[0];
  ASSERT_EQ(setenv("PREHEND_TOOLS", "", 1), 0);
  EXPECT_EQ(plug_in_folders("tool"), shipped);
  ASSERT_EQ(setenv("PREHEND_TOOLS", "/one::/two", 1), 0);
  EXPECT_EQ(plug_in_folders("tool"), (std::vector<fs::path>{"/one", "/two", shipped[0]}));
  // Named once more by another path it counts once.
  fs::create_directories(shipped[0]);
  const fs::path roundabout = shipped[0] / ".." / shipped[0].filename();
  ASSERT_EQ(setenv("PREHEND_TOOLS", roundabout.c_str(), 1), 0);
  EXPECT_EQ(plug_in_folders("tool"), std::vector<fs::path>{roundabout});
  fs::remove(shipped[0]);
  unsetenv("PREHEND_TOOLS");
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
