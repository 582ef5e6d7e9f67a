#include "prehend/simulation/engines/registry.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace prehend::simulation::engines {
namespace {

TEST(EngineRegistry, NamesWhatIsThereAndWhatCannotBeUsed) {
  EXPECT_TRUE(EngineRegistry().has("native"));
  const auto folder = std::filesystem::path(::testing::TempDir()) / "engines";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "broken.so") << "no library";
  const EngineRegistry registry({folder, "/nowhere"});
  EXPECT_EQ(registry.names(), std::vector<std::string>{"native"});
  ASSERT_EQ(registry.problems().size(), 1u);
  EXPECT_EQ(registry.problems()[0].file.filename(), "broken.so");
  try {
    registry.create("mujoko");
    FAIL();
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("mujoko"), std::string::npos);
    EXPECT_NE(what.find("native"), std::string::npos);
    EXPECT_NE(what.find("broken.so"), std::string::npos);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace prehend::simulation::engines
