// The whole evaluation on tiny cases: rendered pair, matching, segmentation, mesh, page.

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/case_runner.h"
#include "eval/household_objects.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/sweep/results.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Measured, DistancesOfShiftedAndScaledBoxes) {
  const geometry::TriangleMesh truth = geometry::make_box({0.1, 0.1, 0.1});
  const MethodResult same = measured(truth, truth, 1);
  EXPECT_NEAR(same.mean, 0, 1e-7);
  EXPECT_NEAR(same.centroid_error, 0, 1e-12);
  EXPECT_NEAR(same.normal_error, 0, 1e-6);
  EXPECT_TRUE(same.watertight);

  // Every face of the larger box is 5 mm off; nearer than that only towards its edges.
  const MethodResult larger = measured(geometry::make_box({0.11, 0.11, 0.11}), truth, 1);
  EXPECT_NEAR(larger.mean, 0.005, 1e-6);
  EXPECT_NEAR(larger.variance, 0, 1e-10);
  EXPECT_GT(larger.back_max, 0.005 * 1.4);

  geometry::TriangleMesh shifted = truth;
  for (Eigen::Vector3d& v : shifted.vertices) v.x() += 0.02;
  EXPECT_NEAR(measured(shifted, truth, 1).centroid_error, 0.02 / (0.1 * std::sqrt(3.0)), 1e-9);

  const geometry::TriangleMesh turned = geometry::transformed(
      truth, geometry::make_transform(
                 Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 1, 1).normalized())),
                 Eigen::Vector3d::Zero()));
  // Each face's normal turns about an axis that is 54.7 degrees from it.
  EXPECT_NEAR(measured(turned, truth, 1).normal_error, 0.1 * std::sqrt(2. / 3), 2e-4);
}

TEST(RunCase, BallOnATableIsSeenAndMeasured) {
  const std::vector<EvaluationObject> objects = {
      {"ball",
       std::make_shared<geometry::TriangleMesh>(standing(geometry::make_sphere(0.04))),
       true,
       false,
       {}}};
  const std::vector<DataSet> sets = make_data_sets("test", objects);
  Method hull = methods_named({"Ext"}).front();
  Method failing{"None", "fails", [](const auto&, const auto&) -> Reconstruction {
                   throw std::runtime_error("no idea");
                 }};
  const CaseResult result = run_case(make_cases(sets, 1, 1).front(), {hull, failing});
  EXPECT_EQ(result.problem, "");
  EXPECT_GT(result.points, 2000);
  EXPECT_GT(result.mask_iou, 0.85);
  ASSERT_EQ(result.methods.size(), 2U);
  // The lower half of the ball is unseen: the hull reaches down to the table there.
  EXPECT_GT(result.methods[0].mean, 0.002);
  EXPECT_LT(result.methods[0].mean, 0.02);
  EXPECT_TRUE(result.methods[0].watertight);
  EXPECT_EQ(result.methods[1].problem, "no idea");
  EXPECT_TRUE(std::isnan(result.methods[1].mean));
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(EvalMeshDeviation, WritesItsPageAndGoesOnWhereItWas) {
  const char* programs = std::getenv("PREHEND_BIN");
  ASSERT_NE(programs, nullptr) << "PREHEND_BIN names the folder of the programs";
  const testing::TemporaryFolder folder;
  const std::string command =
      "PREHEND_SHARED_DATA= " + std::string(programs) +
      "/eval_mesh_deviation --quick --only can --methods Ext --processes 1 --out " +
      folder.path.string() + " --json " + (folder.path / "goals.json").string() + " >" +
      (folder.path / "printed.txt").string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << text_of(folder.path / "printed.txt");
  EXPECT_THAT(text_of(folder.path / "printed.txt"), HasSubstr("2 of 2 cases ran in"));
  EXPECT_THAT(text_of(folder.path / "index.html"), HasSubstr("<svg"));
  EXPECT_THAT(text_of(folder.path / "goals.json"), HasSubstr("\"name\": \"household\""));
  EXPECT_THAT(text_of(folder.path / "household_deviation_by_object.csv"), HasSubstr("\ncan,"));
  const std::string cases = text_of(folder.path / "cases.csv");
  EXPECT_THAT(cases, HasSubstr("household,can,0,"));
  EXPECT_THAT(cases, HasSubstr("household,can,180,"));

  // One case is lost; only that one is evaluated again, with the same result.
  std::vector<EvaluationObject> cans;
  for (const EvaluationObject& object : household_objects()) {
    if (object.name == "can") cans.push_back(object);
  }
  const std::vector<DataSet> sets = make_data_sets("household", cans);
  const std::string lost = Case{&sets.front(), 180, 1}.result_name();
  {
    sweep::ResultStore store(folder.path / "results.db");
    ASSERT_TRUE(store.has(lost));
    store.forget(lost);
  }
  ASSERT_EQ(std::system(command.c_str()), 0) << text_of(folder.path / "printed.txt");
  EXPECT_THAT(text_of(folder.path / "printed.txt"),
              AllOf(HasSubstr("1 of 2 cases are known already"), HasSubstr("1 of 1 cases ran in")));
  const auto without_times = [](const std::string& csv) {
    return csv.substr(0, csv.find(",Ext,"));
  };
  EXPECT_EQ(without_times(text_of(folder.path / "cases.csv")), without_times(cases));
}

// Runs the program; what it printed goes to `printed`. Returns its exit code.
int run_program(const std::filesystem::path& folder, const std::string& arguments,
                std::string* printed) {
  const char* programs = std::getenv("PREHEND_BIN");
  if (programs == nullptr) throw std::runtime_error("PREHEND_BIN names the folder of the programs");
  const std::filesystem::path log = folder / "printed.txt";
  const int status =
      std::system((std::string(programs) + "/eval_mesh_deviation " + arguments + " --out " +
                   (folder / "out").string() + " >" + log.string() + " 2>&1")
                      .c_str());
  *printed = text_of(log);
  return status;
}

TEST(EvalMeshDeviation, ComparesMethodsForOneViewOnAFolderOfMeshes) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path meshes = folder.path / "mine";
  std::filesystem::create_directory(meshes);
  geometry::write_mesh_file(meshes / "brick.ply", geometry::make_box({0.06, 0.09, 0.08}));
  std::string printed;
  ASSERT_EQ(run_program(folder.path,
                        "--compare single_view --quick --processes 1 --methods Ext Truth "
                        "--meshes " +
                            meshes.string(),
                        &printed),
            0)
      << printed;
  EXPECT_THAT(printed, HasSubstr("Jaccard [%]"));
  EXPECT_THAT(printed, HasSubstr("stands [%]"));
  EXPECT_THAT(printed, HasSubstr("mine (2 cases)"));
  // The control: the truth is itself, and stands.
  EXPECT_THAT(printed, ::testing::ContainsRegex(
                           "Truth +0.00 .. 0.00 +100.00 .. 0.00 +0.00 .. 0.00 +0.00 .. 0.00 +100"));
}

TEST(EvalMeshDeviation, SaysWhatIsWrongWithAFolderOfMeshes) {
  const testing::TemporaryFolder folder;
  std::string printed;
  const std::string compare = "--compare single_view --quick --meshes ";
  EXPECT_NE(run_program(folder.path, compare + (folder.path / "absent").string(), &printed), 0);
  EXPECT_THAT(printed, HasSubstr("absent' does not exist"));
  EXPECT_THAT(printed, HasSubstr("Name a folder with OBJ, PLY or STL files"));
  const std::filesystem::path empty = folder.path / "empty";
  std::filesystem::create_directory(empty);
  EXPECT_NE(run_program(folder.path, compare + empty.string(), &printed), 0);
  EXPECT_THAT(printed, HasSubstr("empty' has no mesh"));
}

}  // namespace
}  // namespace prehend::eval
