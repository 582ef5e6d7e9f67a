#include "prehend/grasp/known/grasp_database.h"

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::grasp {
namespace {

using geometry::InputError;
using ::testing::HasSubstr;

class Database : public ::testing::Test {
 protected:
  Database() {
    std::string pattern = (std::filesystem::temp_directory_path() / "grasps_XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~Database() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path file(const std::string& name = "grasps.db") const { return folder_ / name; }

  std::filesystem::path folder_;
};

StoredGrasp grasp_with(double score) {
  StoredGrasp grasp;
  grasp.X_OG = geometry::make_transform({0.5, 0.5, -0.5, 0.5}, {0.1, -0.2, score});
  grasp.joints = {0.03, -1.5};
  grasp.force = 12;
  grasp.quality = 0.2;
  grasp.score = score;
  return grasp;
}

TEST_F(Database, KeepsGraspsBestFirstByHandAndObject) {
  {
    GraspDatabase database(file());
    database.replace("pg70", "aa", "mug", {grasp_with(0.3), grasp_with(0.8)});
    database.add("pg70", "aa", "mug", {grasp_with(0.5)});
    database.replace("sdh2", "aa", "mug", {grasp_with(0.1)});
    database.replace("pg70", "bb", "can", {});
  }
  GraspDatabase database(file());
  const auto grasps = database.grasps("pg70", "aa");
  ASSERT_EQ(grasps.size(), 3u);
  EXPECT_EQ(grasps[0].score, 0.8);
  EXPECT_EQ(grasps[2].score, 0.3);
  EXPECT_TRUE(grasps[0].X_OG.isApprox(grasp_with(0.8).X_OG, 1e-15));
  EXPECT_EQ(grasps[0].joints, (std::vector<double>{0.03, -1.5}));
  EXPECT_EQ(grasps[0].force, 12);
  EXPECT_TRUE(database.grasps("pg70", "cc").empty());
  const auto objects = database.objects();
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[0].name, "can");
  EXPECT_EQ(objects[1].grasps, 3);
  database.replace("pg70", "aa", "blue mug", {grasp_with(0.9)});
  EXPECT_EQ(database.grasps("pg70", "aa").size(), 1u);
  EXPECT_EQ(database.grasps("sdh2", "aa").size(), 1u);
  EXPECT_TRUE(database.remove("sdh2", "aa"));
  EXPECT_FALSE(database.remove("sdh2", "aa"));
  EXPECT_TRUE(database.grasps("sdh2", "aa").empty());
}

TEST_F(Database, CountsExecutionsOfTheNearestGrasp) {
  GraspDatabase database(file());
  database.replace("pg70", "aa", "mug", {grasp_with(0.3), grasp_with(0.8)});
  geometry::RigidTransform near = grasp_with(0.3).X_OG;
  near.translation().x() += 0.01;
  EXPECT_TRUE(database.record_execution("pg70", "aa", near, true));
  EXPECT_TRUE(database.record_execution("pg70", "aa", near, false));
  EXPECT_FALSE(database.record_execution("pg70", "zz", near, true));
  const auto grasps = database.grasps("pg70", "aa");
  EXPECT_EQ(grasps[0].attempts, 0);
  EXPECT_EQ(grasps[1].attempts, 2);
  EXPECT_EQ(grasps[1].successes, 1);
}

TEST_F(Database, ExportsWhatItHas) {
  GraspDatabase database(file());
  database.replace("pg70", "aa", "a \"fine\" mug, blue", {grasp_with(0.5)});
  std::ostringstream out;
  database.write_csv(out);
  EXPECT_THAT(out.str(), HasSubstr("hand,hash,name,x_m"));
  EXPECT_THAT(out.str(), HasSubstr("\"pg70\",\"aa\",\"a \"\"fine\"\" mug, blue\",0.1,-0.2,0.5,"));
  EXPECT_THAT(out.str(), HasSubstr(",\"0.03 -1.5\",12,0.2,0.5,0,0\r\n"));
}

TEST_F(Database, TwoWritersLoseNothing) {
  { GraspDatabase database(file()); }
  const auto write = [this](const std::string& hand) {
    GraspDatabase database(file());
    for (int i = 0; i < 50; ++i) database.add(hand, "aa", "mug", {grasp_with(0.01 * i)});
  };
  std::thread first(write, "pg70"), second(write, "sdh2");
  first.join();
  second.join();
  const GraspDatabase database(file());
  EXPECT_EQ(database.grasps("pg70", "aa").size(), 50u);
  EXPECT_EQ(database.grasps("sdh2", "aa").size(), 50u);
}

TEST_F(Database, AWriterThatDiesLeavesWhatWasThere) {
  {
    GraspDatabase database(file());
    database.replace("pg70", "aa", "mug", {grasp_with(0.3)});
  }
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    // Half of a change, as a program that is killed leaves it.
    sqlite3* connection = nullptr;
    sqlite3_open(file().c_str(), &connection);
    sqlite3_exec(connection, "BEGIN IMMEDIATE; DELETE FROM grasp", nullptr, nullptr, nullptr);
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  GraspDatabase database(file());
  EXPECT_EQ(database.grasps("pg70", "aa").size(), 1u);
  database.add("pg70", "aa", "mug", {grasp_with(0.4)});  // and is not locked
  EXPECT_EQ(database.grasps("pg70", "aa").size(), 2u);
}

TEST_F(Database, SaysWhatCannotBeUsed) {
  const auto refusal = [](const std::filesystem::path& path) -> std::string {
    try {
      GraspDatabase database(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  std::ofstream(file("text.db")) << std::string(5000, 'x');
  EXPECT_THAT(refusal(file("text.db")), HasSubstr("text.db"));
  EXPECT_THAT(refusal(folder_ / "no" / "such.db"), HasSubstr("such.db"));
  sqlite3* other = nullptr;
  sqlite3_open(file("other.db").c_str(), &other);
  sqlite3_exec(other, "CREATE TABLE t(x)", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_THAT(refusal(file("other.db")), HasSubstr("another program's"));
  { GraspDatabase database(file("newer.db")); }
  sqlite3_open(file("newer.db").c_str(), &other);
  sqlite3_exec(other, "PRAGMA user_version=99", nullptr, nullptr, nullptr);
  sqlite3_close(other);
  EXPECT_THAT(refusal(file("newer.db")), HasSubstr("version 99"));
}

TEST_F(Database, RefusesNumbersThatAreNone) {
  GraspDatabase database(file());
  StoredGrasp bad = grasp_with(0.3);
  bad.force = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(database.add("pg70", "aa", "mug", {bad}), std::invalid_argument);
  EXPECT_THROW(database.add("", "aa", "mug", {}), std::invalid_argument);
  bad = grasp_with(0.3);
  bad.successes = 2;
  EXPECT_THROW(database.add("pg70", "aa", "mug", {bad}), std::invalid_argument);
  EXPECT_TRUE(database.objects().empty());
}

TEST(ContentHash, IsOfTheShapeToAMicrometre) {
  geometry::TriangleMesh box = geometry::make_box({0.05, 0.06, 0.07});
  const std::string hash = content_hash(box);
  EXPECT_EQ(hash.size(), 64u);
  geometry::TriangleMesh same = box;
  same.vertices[0].x() += 1e-10;
  EXPECT_EQ(content_hash(same), hash);
  same.vertices[0].x() += 1e-4;
  EXPECT_NE(content_hash(same), hash);
  same = box;
  std::swap(same.triangles[0], same.triangles[1]);
  EXPECT_NE(content_hash(same), hash);
  // SHA-256 of eight zero bytes: the number of vertices of nothing.
  EXPECT_EQ(content_hash({}), "af5570f5a1810b7af78caf4bc70a660f0df51e42baf91d4de5b2328de0e83dfc");
  same.vertices[0].x() = std::nan("");
  EXPECT_THROW(content_hash(same), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::grasp
