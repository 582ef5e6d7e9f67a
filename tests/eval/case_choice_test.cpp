// The one way of choosing cases of the programs that evaluate bodies in views.

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/view_segmentation.h"
#include "prehend/geometry/errors.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kPrograms[] = {"eval_mesh_deviation", "eval_grasp", "eval_perception"};

class CaseChoiceOf : public ::testing::TestWithParam<const char*> {
 protected:
  // What the program prints; its exit code in code_.
  std::string run(const std::string& words) {
    const char* programs = std::getenv("PREHEND_BIN");
    if (programs == nullptr) return "PREHEND_BIN names the folder of the programs";
    const std::filesystem::path printed = folder_.path / "printed.txt";
    code_ = std::system(("PREHEND_SHARED_DATA= " + launcher_ + programs + "/" + GetParam() + " " +
                         words + " --out " + (folder_.path / "out").string() + " >" +
                         printed.string() + " 2>&1")
                            .c_str());
    std::ifstream stream(printed);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }
  testing::TemporaryFolder folder_;
  std::string launcher_;  // before the program
  int code_ = -1;
};

TEST_P(CaseChoiceOf, RefusesUnknownNamesWithTheList) {
  EXPECT_THAT(run("--groups hrad"),
              AllOf(HasSubstr("hrad"), HasSubstr("household"), HasSubstr("scanned"),
                    HasSubstr("hard"), HasSubstr("held")));
  EXPECT_NE(code_, 0);
  EXPECT_THAT(run("--groups hard --only vase bottle"),
              AllOf(HasSubstr("--only"), HasSubstr("'bottle'"), HasSubstr("'bottle_on_box'")));
  EXPECT_NE(code_, 0);
  EXPECT_THAT(run("--groups scanned --list"), HasSubstr("PREHEND_SHARED_DATA"));
  EXPECT_NE(code_, 0);
  EXPECT_THAT(run("--groups hard --meshes /"), HasSubstr("excludes"));
  EXPECT_NE(code_, 0);
}

TEST_P(CaseChoiceOf, ListsTheCasesOfGroups) {
  const std::string hard = run("--groups hard household --only vase can --quick --list");
  EXPECT_EQ(code_, 0) << hard;
  EXPECT_THAT(hard, AllOf(HasSubstr("hard-vase-000-seed1\nhard-vase-180-seed1\n"),
                          HasSubstr("household-can-000-seed1\n"), Not(HasSubstr("bowl"))));
  EXPECT_THAT(run("--groups held --quick --list"), HasSubstr("held-"));
  EXPECT_EQ(code_, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_.path / "out"));
}

TEST_P(CaseChoiceOf, HasEachCaseWithEachSeed) {
  EXPECT_EQ(run("--groups hard --only vase --quick --seed 7 2 --list"),
            "hard-vase-000-seed7\nhard-vase-180-seed7\nhard-vase-000-seed2\nhard-vase-180-seed2\n");
  EXPECT_EQ(code_, 0);
  EXPECT_THAT(run("--groups hard --seed 7 2 7 --list"), HasSubstr("--seed gives a seed twice"));
  EXPECT_NE(code_, 0);
}

class PlatformChoiceOf : public CaseChoiceOf {};

TEST_P(PlatformChoiceOf, HasEachPlatformOnce) {
  EXPECT_THAT(run("--groups household --platform stage_pg70 kr5_sdh stage_pg70 --list"),
              HasSubstr("--platform names 'stage_pg70' twice"));
  EXPECT_NE(code_, 0);
}

INSTANTIATE_TEST_SUITE_P(Programs, PlatformChoiceOf,
                         ::testing::Values("eval_grasp", "eval_platform", "eval_scene"));

class LaunchesOf : public CaseChoiceOf {};

// Regression: a launch that was never begun was a table that was not cleared.
TEST_P(LaunchesOf, ALaunchThatDoesNotBeginIsAFailedCase) {
  const std::string wide = GetParam() == std::string("eval_scene") ? " --widest 0.2" : "";
  EXPECT_THAT(run("--groups household --scenes 1 --launch-argument nothing_of_the_kind:=1" + wide),
              AllOf(HasSubstr("left no recording"), HasSubstr("nothing_of_the_kind")));
  EXPECT_NE(code_, 0);
}

INSTANTIATE_TEST_SUITE_P(Programs, LaunchesOf, ::testing::Values("eval_platform", "eval_scene"));

INSTANTIATE_TEST_SUITE_P(Programs, CaseChoiceOf, ::testing::ValuesIn(kPrograms),
                         [](const auto& one) { return std::string(one.param); });

class EvalPerception : public CaseChoiceOf {};

TEST_P(EvalPerception, SeesTheViewsOfAGroupAndGoesOnWhereItWas) {
  const std::string command = "--groups hard --only upper_of_two --quick --processes 1";
  const std::string first = run(command);
  ASSERT_EQ(code_, 0) << first;
  // Two bodies in each of two views.
  EXPECT_THAT(first, AllOf(HasSubstr("\"hard\",\"4\""), HasSubstr("\"hard: upper_of_two\",\"4\""),
                           HasSubstr("2 of 2 cases ran in"), Not(HasSubstr("four objects each"))));
  const std::string second = run(command);
  EXPECT_THAT(second,
              AllOf(HasSubstr("\"hard\",\"4\""), HasSubstr("2 of 2 cases are known already"),
                    Not(HasSubstr("cases ran"))));
  EXPECT_THAT(run(command + " --scenes 2"), HasSubstr("excludes"));
}

TEST_P(EvalPerception, RanksGiveTheSameResults) {
  const std::string command = "--groups hard --only upper_of_two --quick ";
  EXPECT_THAT(run(command + "--mpi"), HasSubstr("--mpi"));
  EXPECT_NE(code_, 0) << "no mpirun started it, or it was built without";
  const auto table = [&] {
    std::ifstream stream(folder_.path / "out" / "groups.csv");
    std::ostringstream text;
    for (std::string line; std::getline(stream, line);) text << line.substr(0, line.rfind(','));
    return text.str();
  };
  run(command + "--processes 1");
  ASSERT_EQ(code_, 0);
  const std::string alone = table();
  ASSERT_THAT(alone, HasSubstr("hard"));
#ifdef PREHEND_HAS_MPI
  if (std::system("command -v mpirun >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "mpirun is not installed (apt install openmpi-bin)";
  }
  launcher_ =
      "mpirun --oversubscribe -n 3 --mca btl self,vader,tcp --mca btl_tcp_if_include lo --mca "
      "oob_tcp_if_include lo ";
  if (geteuid() == 0) launcher_ += "--allow-run-as-root ";
  EXPECT_THAT(run(command + "--mpi --fresh"), HasSubstr("2 of 2 cases ran in"));
  EXPECT_EQ(code_, 0);
  EXPECT_EQ(table(), alone);
#endif
}

INSTANTIATE_TEST_SUITE_P(Program, EvalPerception, ::testing::Values("eval_perception"));

ViewSegmentation view_of(const std::string& group, const std::string& name, int found,
                         double depth_error) {
  ViewSegmentation view{name + "-000", group, name, {}};
  view.seen.errors = {2, found, 2 - found, 0, 0, 0.5 * found};
  view.seen.depth_error = depth_error;
  view.seen.depth_missing = 0.25;
  view.seen.seconds = 0.1;
  return view;
}

TEST(ViewSegmentation, IsReadAsItWasWritten) {
  const ViewSegmentation written = view_of("hard", "bowl", 1, 0.00123456789);
  const ViewSegmentation read = read_view(to_text(written));
  EXPECT_EQ(read.data_set, "bowl");
  EXPECT_EQ(read.seen.errors.missed, 1);
  EXPECT_EQ(read.seen.errors.iou, written.seen.errors.iou);
  EXPECT_EQ(read.seen.depth_error, written.seen.depth_error);
  EXPECT_THROW(read_view("[1, 2]\n"), geometry::InputError);
}

TEST(ViewSegmentation, AddsUpByGroupAndByObject) {
  const auto unknown = std::nan("");
  const std::vector<ViewSegmentation> views{
      view_of("hard", "bowl", 1, 0.002), view_of("hard", "bowl", 2, unknown),
      view_of("hard", "vase", 2, 0.004), view_of("household", "bowl", 2, unknown)};
  const auto groups = by_group(views);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].condition, "hard");
  EXPECT_EQ(groups[0].errors.truths, 6);
  EXPECT_EQ(groups[0].errors.found, 5);
  EXPECT_NEAR(groups[0].errors.iou, (0.5 + 1 + 1) / 3, 1e-12);
  EXPECT_NEAR(groups[0].depth_error, 0.003, 1e-12);
  EXPECT_NEAR(groups[0].depth_missing, 0.25, 1e-12);
  EXPECT_TRUE(std::isnan(groups[1].depth_error));
  const auto objects = by_data_set(views);
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[2].condition, "household: bowl");
}

}  // namespace
}  // namespace prehend::eval
