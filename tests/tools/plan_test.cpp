// prehend plan.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "prehend/geometry/mesh_files.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Plan : public ::testing::Test {
 protected:
  // The command's output and errors; its exit code in exit_code_.
  std::string run(std::vector<std::string> words) {
    words.insert(words.begin(), "plan");
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }
  std::string box(const Eigen::Vector3d& size) {
    const std::string file = folder_.path("box.ply");
    geometry::write_mesh_file(file, geometry::make_box(size));
    return file;
  }

  ScratchDirectory folder_;
  int exit_code_ = -1;
};

TEST_F(Plan, PrintsGraspsLedgerAndStages) {
  const std::string output = run({box({0.04, 0.05, 0.1}), "--approach", "down"});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("RANK"), HasSubstr("circles"), HasSubstr("FELL AT"),
                            HasSubstr("approach direction out of the robot's reach"),
                            HasSubstr("NEAREST MISS"), HasSubstr("STAGE"), HasSubstr("grasps")));
}

TEST_F(Plan, SaysWhatWouldHelp) {
  const std::string wide = box({0.0795, 0.09, 0.1});
  const std::vector<std::string> words{
      wide, "--approach", "down", "--remedy-budget", "50", "--out", folder_.path("page")};
  const std::string output = run(words);
  EXPECT_EQ(exit_code_, 3) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("WHAT WOULD HELP"),
                            HasSubstr("with 14 mm more opening (83 mm): "), HasSubstr("remedies")));
  std::ifstream file(folder_.path("page") + "/index.html");
  const std::string html{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(html, HasSubstr("with 14 mm more opening (83 mm): "));
  const std::string json = run({wide, "--approach", "down", "--remedy-budget", "50", "--json"});
  EXPECT_THAT(json, AllOf(HasSubstr("\"remedies\""), HasSubstr("\"change\":\"opening\"")));
  EXPECT_THAT(run({wide, "--approach", "down", "--remedy-budget", "0"}),
              ::testing::Not(HasSubstr("WHAT WOULD HELP")));
}

TEST_F(Plan, TakesAPlatformOfOnesOwnByItsFile) {
  const std::filesystem::path own = folder_.path("robots");
  std::filesystem::copy("config/robots", own);
  std::filesystem::rename(own / "kr5_pg70.yaml", own / "mine.yaml");
  std::string output = run({box({0.04, 0.05, 0.12}), "--platform", own / "mine.yaml"});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("SEGMENT"), HasSubstr("approach")));
  output = run({box({0.04, 0.05, 0.12}), "--platform", own / "yours.yaml"});
  EXPECT_EQ(exit_code_, 1) << output;
  EXPECT_THAT(output, HasSubstr("yours.yaml' of a platform"));
  output = run({box({0.04, 0.05, 0.12}), "--platform", own / "sdh2.yaml"});
  EXPECT_EQ(exit_code_, 1) << output;
  EXPECT_THAT(output, HasSubstr("sdh2.yaml is a hand, and no platform"));
}

// "config/robots/pg70_dsa.yaml does not exist", anywhere but in the source tree.
TEST_F(Plan, TakesAHandThatWasLearnedFromAFile) {
  const auto learn = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"hand", "learn"});
    ChildProgram program("prehend", words, folder_.path("learned"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  };
  const std::string hand = folder_.path("mine.yaml");
  std::string output = learn(
      {"config/robots/barrett_bh8.urdf", "--out", hand, "--on", "config/robots/pa10_barrett.yaml"});
  ASSERT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("palm"), HasSubstr("preshapes:"), HasSubstr("3 fingers")));
  output = run({box({0.05, 0.06, 0.1}), "--hand", hand});
  EXPECT_EQ(exit_code_, 0) << output;
  output = run({box({0.05, 0.06, 0.1}), "--platform", folder_.path("mine_on_pa10_barrett.yaml")});
  EXPECT_EQ(exit_code_, 0) << output;

  // What a person may have corrected is not written over.
  EXPECT_THAT(learn({"config/robots/barrett_bh8.urdf", "--out", hand}), HasSubstr("--overwrite"));
  EXPECT_EQ(exit_code_, 1);
  learn({"config/robots/barrett_bh8.urdf", "--out", hand, "--overwrite"});
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(learn({"config/robots/barrett_bh8.urdf", "--out", folder_.path("mine.txt")}),
              HasSubstr("NAME.yaml"));
  EXPECT_THAT(learn({"config/robots/barrett_bh8.urdf", "--oot", hand}),
              HasSubstr("prehend hand learn has no option \"--oot\"; did you mean \"--out\"?"));
  EXPECT_EQ(exit_code_, 2);
}

TEST_F(Plan, WorksFromAnyFolder) {
  const std::string file = box({0.04, 0.05, 0.1});
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  const std::string output = run({file, "--approach", "down"});
  std::filesystem::current_path(before);
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, HasSubstr("RANK"));
}

TEST_F(Plan, WithAnArmSaysTheSegmentsAndDrawsThem) {
  const std::string page = folder_.path("page");
  const std::string output = run({box({0.04, 0.05, 0.12}), "--platform", "kr5_pg70", "--approach",
                                  "down", "--move", "0,-0.1,0", "--out", page});
  EXPECT_EQ(exit_code_, 0) << output;
  for (const char* segment : {"reach", "approach", "lift", "carry", "place", "retreat"}) {
    EXPECT_THAT(output, HasSubstr(segment));
  }
  EXPECT_THAT(output, AllOf(HasSubstr("The arm takes grasp"), HasSubstr("(score "),
                            HasSubstr("the best that it can execute")));
  std::ifstream file(page + "/index.html");
  const std::string html{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(html, AllOf(HasSubstr("The arm at the grasp"), HasSubstr("image/png")));
}

TEST_F(Plan, TakesPlannerAndCheckerByName) {
  const std::vector<std::string> arm{box({0.04, 0.05, 0.12}), "--platform", "kr5_pg70",
                                     "--approach", "down"};
  const auto with = [&arm](std::vector<std::string> words) {
    words.insert(words.begin(), arm.begin(), arm.end());
    return words;
  };
  EXPECT_THAT(run(with({"--path-planner", "ompl_bitrrt", "--collision-checker", "fcl"})),
              AllOf(HasSubstr("found by ompl_bitrrt"), HasSubstr("tested by fcl"),
                    HasSubstr("The arm takes grasp")));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run(with({"--path-planner", "ompl_bitrt"})),
              AllOf(HasSubstr("nearest is 'ompl_bitrrt'"), HasSubstr("ompl_kpiece")));
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(run(with({"--collision-checker", "ball"})),
              AllOf(HasSubstr("nearest is 'balls'"), HasSubstr("bullet")));
  EXPECT_NE(exit_code_, 0);
  EXPECT_THAT(run({arm.front(), "--path-planner", "ompl_bitrrt"}), HasSubstr("--platform"));
  EXPECT_NE(exit_code_, 0);
}

TEST_F(Plan, TakesEachNumberOfThePlanner) {
  const std::string body = box({0.04, 0.05, 0.12});
  EXPECT_THAT(run({body, "--largest-count", "1"}), HasSubstr("1 grasps\n"));
  EXPECT_EQ(exit_code_, 0);
  run({box({0.04, 0.05, 0.05}), "--table-margin", "0.1"});
  EXPECT_EQ(exit_code_, 3) << "nothing of it is as high over the table";
  const auto refused = [&](const std::vector<std::string>& words, const std::string& why) {
    EXPECT_THAT(run(words), HasSubstr(why));
    EXPECT_NE(exit_code_, 0);
    EXPECT_NE(exit_code_, 3);
  };
  refused({body, "--safety-factor", "0.3"}, "--safety-factor");
  refused({body, "--hand", "sdh2", "--friction", "0.5"}, "--friction does not apply with the hand");
  refused({body, "--least-fingers", "3"}, "--least-fingers does not apply with the hand pg70");
  refused({body, "--arm-margin", "0.01"}, "--arm-margin does not apply with a hand without an arm");
  refused({body, "--budget", "0.1", "--robustness-samples", "4"}, "beside --budget");
}

TEST_F(Plan, SaysWhyThereIsNoGrasp) {
  const std::string output = run({box({0.12, 0.1, 0.1}), "--approach", "down"});
  EXPECT_EQ(exit_code_, 3) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("100.0 mm > 66.0 mm"),
                            HasSubstr("narrowest width 100 mm exceeds the gripper's 69 mm")));
}

TEST_F(Plan, PrintsJsonForPrograms) {
  const std::string output = run({box({0.04, 0.05, 0.1}), "--approach", "down", "--json"});
  EXPECT_EQ(exit_code_, 0) << output;
  google::protobuf::Struct parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output, &parsed).ok()) << output;
  const auto& grasps = parsed.fields().at("grasps").list_value();
  ASSERT_GT(grasps.values_size(), 0);
  EXPECT_EQ(grasps.values(0).struct_value().fields().at("position_m").list_value().values_size(),
            3);
  EXPECT_GT(parsed.fields().at("ledger").list_value().values_size(), 0);
  EXPECT_GT(parsed.fields().at("seconds").struct_value().fields().at("grasps").number_value(), 0);
}

TEST_F(Plan, RemembersGraspsOfAMeshAndListsThem) {
  const std::string mesh = box({0.04, 0.05, 0.1}), database = folder_.path("grasps.db");
  EXPECT_THAT(run({mesh, "--approach", "down", "--database", database}), HasSubstr("added to"));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run({mesh, "--approach", "down", "--database", database}),
              AllOf(HasSubstr("grasps from"), HasSubstr("given")));
  const auto grasps = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"grasps", database});
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  };
  EXPECT_THAT(grasps({}), AllOf(HasSubstr("box"), HasSubstr("pg70_dsa"), HasSubstr("EXECUTED")));
  EXPECT_THAT(grasps({"--csv"}), AllOf(HasSubstr("successes"), HasSubstr("pg70_dsa")));
  EXPECT_THAT(grasps({"--forget", "bottle"}), HasSubstr("no object 'bottle'"));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(grasps({"--forget", "box"}), HasSubstr("forgot 1"));
  EXPECT_THAT(grasps({"--json"}), ::testing::Not(HasSubstr("pg70_dsa")));
  EXPECT_EQ(exit_code_, 0);
}

TEST_F(Plan, AMeshOfManyTrianglesIsReducedAndItsErrorSaid) {
  const std::string file = folder_.path("fine.stl");
  geometry::write_mesh_file(file, geometry::make_sphere(20, 400));  // mm
  const std::string output = run({file, "--approach", "down"});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("taken for the millimetre"),
                            ::testing::ContainsRegex("of the mesh's 15[0-9],[0-9]{3} triangles "
                                                     "(49|50),[0-9]{3} are worked on, off by at "
                                                     "most 0.0[0-9]+ mm at 50,000 points"),
                            ::testing::Not(HasSubstr("not closed")), HasSubstr("RANK")));
}

TEST_F(Plan, AMeshInMillimetresIsRecognised) {
  EXPECT_THAT(run({box({40, 50, 100}), "--approach", "down"}),
              AllOf(HasSubstr("taken for the millimetre"), HasSubstr("50 x 40 x 100 mm")));
  EXPECT_EQ(exit_code_, 0);
  EXPECT_THAT(run({box({4, 5, 10}), "--approach", "down"}),
              AllOf(HasSubstr("0.1 m in centimetres"), HasSubstr("--scale")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({box({4, 5, 10}), "--approach", "down", "--scale", "0.01"}),
              HasSubstr("50 x 40 x 100 mm"));
  EXPECT_EQ(exit_code_, 0);
}

TEST_F(Plan, SavesTheMeshAndThePlan) {
  const std::string saved = folder_.path("saved/here");
  const std::string output = run({box({0.04, 0.05, 0.1}), "--approach", "down", "--save", saved});
  EXPECT_EQ(exit_code_, 0) << output;
  for (const char* name : {"/object.ply", "/object.obj", "/object.stl"}) {
    const Eigen::AlignedBox3d bounds = geometry::bounds(geometry::read_mesh_file(saved + name));
    EXPECT_LT((bounds.sizes() - Eigen::Vector3d(0.04, 0.05, 0.1)).norm(), 1e-6) << name;
  }
  std::ifstream file(saved + "/plan.json");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  google::protobuf::Struct parsed;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(text, &parsed).ok()) << text;
  EXPECT_GT(parsed.fields().at("grasps").list_value().values_size(), 0);
  EXPECT_NEAR(parsed.fields().at("size_m").list_value().values(0).number_value(), 0.05, 1e-6);
  EXPECT_THAT(run({box({0.04, 0.05, 0.1}), "--save", folder_.write("file", "")}),
              HasSubstr("file"));
  EXPECT_EQ(exit_code_, 1);
}

// They were taken and meant nothing.
TEST_F(Plan, OptionsThatDoNotApplyAreRefused) {
  const std::string mesh = box({0.04, 0.05, 0.1});
  for (const auto& option : std::vector<std::vector<std::string>>{{"--table", "none"},
                                                                  {"--up", "0 0 1"},
                                                                  {"--split", "touching"},
                                                                  {"--object", "1"},
                                                                  {"--alternatives", "1"},
                                                                  {"--tolerance", "0.003"}}) {
    std::vector<std::string> words{mesh};
    words.insert(words.end(), option.begin(), option.end());
    EXPECT_THAT(run(words), AllOf(HasSubstr(option[0]), HasSubstr("for clouds")));
    EXPECT_EQ(exit_code_, 1);
  }
}

// All stages of a cloud at once, by the front of whole chains.
TEST_F(Plan, ABudgetOrToleranceOfACloudChoosesAllStages) {
  std::string box_seen;
  int count = 0;
  for (int i = 0; i <= 40; ++i) {
    for (int k = 0; k <= 40; ++k) {
      box_seen += fmt::format("{} {} 0.8\n{} 0 {}\n", i * 1e-3, k * 1e-3, i * 1e-3, 0.8 + k * 1e-3);
      count += 2;
    }
  }
  const std::string cloud = folder_.write(
      "box.pcd",
      fmt::format("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
                  "WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA ascii\n{1}",
                  count, box_seen));
  EXPECT_THAT(run({cloud, "--budget", "100"}),
              AllOf(HasSubstr("chosen: segmentation."), HasSubstr("by the budget: ")));
  EXPECT_THAT(run({cloud, "--budget", "100000ms"}), HasSubstr("by the budget: "));
  EXPECT_THAT(run({cloud, "--tolerance", "0.5"}), HasSubstr("chosen: segmentation."));
  EXPECT_THAT(run({cloud, "--tolerance", "500mm"}), HasSubstr("chosen: segmentation."));
  EXPECT_THAT(run({cloud, "--budget", "1 hour"}), HasSubstr("is no duration"));
  EXPECT_EQ(exit_code_, 2);
  EXPECT_THAT(run({cloud}), Not(HasSubstr("chosen: ")));
  EXPECT_THAT(run({cloud, "--budget", "1e-6"}), HasSubstr("Allow as much as the fastest one"));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({cloud, "--budget", "1", "--tolerance", "0.5"}), HasSubstr("both given"));
  EXPECT_THAT(run({cloud, "--budget", "1", "--alternatives", "1"}), HasSubstr("--alternatives"));
  EXPECT_THAT(run({cloud, "--budget", "1", "--first-share", "2"}),
              HasSubstr("--first-share is chosen for a cloud"));
  EXPECT_EQ(exit_code_, 1);
}

// prehend/grasp/example: a generator, and a method of closing that a hand's file names.
TEST_F(Plan, UsesAnotherProjectsPlugIns) {
  const std::filesystem::path own = folder_.path("robots");
  std::filesystem::copy("config/robots", own);
  std::ifstream shipped(own / "sdh2.yaml");
  std::string text((std::istreambuf_iterator<char>(shipped)), {});
  text.replace(text.find("closing: fingers"), 16, "closing: fingertips");
  std::ofstream(own / "mine.yaml") << text;
  const std::vector<std::string> words{box({0.05, 0.06, 0.12}), "--generators", "from_the_top",
                                       "--hand", own / "mine.yaml"};
  EXPECT_THAT(run(words), HasSubstr("there is no closing 'fingertips'; the nearest is 'fingers'"));
  EXPECT_EQ(exit_code_, 1);
  setenv("PREHEND_CLOSINGS", PREHEND_GRASP_EXAMPLE, 1);
  EXPECT_THAT(run(words), HasSubstr("there is no generator 'from_the_top'"));
  EXPECT_EQ(exit_code_, 1);
  setenv("PREHEND_GENERATORS", PREHEND_GRASP_EXAMPLE, 1);
  EXPECT_THAT(run(words), AllOf(HasSubstr("FELL AT"), HasSubstr("from_the_top")));
  unsetenv("PREHEND_CLOSINGS");
  unsetenv("PREHEND_GENERATORS");
}

TEST_F(Plan, NamesWhatIsWrong) {
  EXPECT_THAT(run({"no_such.ply"}), HasSubstr("no_such.ply"));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({box({0.04, 0.05, 0.1}), "--platform", "kr5_sdhh"}),
              AllOf(HasSubstr("no platform"), HasSubstr("nearest is 'kr5_sdh'")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({box({0.04, 0.05, 0.1}), "--hand", "gripper"}),
              AllOf(HasSubstr("no hand"), HasSubstr("bh8, franka_hand, pg70, robotiq_2f85, sdh2")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({box({0.04, 0.05, 0.1}), "--generators", "antipodel"}), HasSubstr("antipodal"));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({box({0.04, 0.05, 0.1}), "--database", folder_.path("no/where.db")}),
              HasSubstr("where.db"));
  EXPECT_EQ(exit_code_, 1);
  const std::string text = folder_.write("text.ply", "no mesh\n");
  EXPECT_THAT(run({text}), HasSubstr("text.ply"));
  EXPECT_EQ(exit_code_, 1);
}

}  // namespace
}  // namespace prehend::testing
