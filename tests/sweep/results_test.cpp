#include "prehend/sweep/results.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/sweep/cases.h"
#include "prehend/sweep/collect.h"
#include "prehend/sweep/table.h"
#include "prehend/text/input_error.h"
#include "tests/launch/child_program.h"

namespace prehend::sweep {
namespace {

using ::testing::HasSubstr;

Description three_seeds() {
  Description made;
  made.program = "p";
  made.arguments = {"{seed}"};
  made.grid = {{"seed", Values::steps("1", "3", "1")}};
  made.fixed["program"] = "p";
  return made;
}

CaseResult result_of(const std::string& name, const std::string& figure, double seconds) {
  CaseResult result;
  result.name = name;
  result.rows = {{"figure"}, {{figure}}};
  result.seconds = seconds;
  result.worker = "host:1";
  return result;
}

class SweepResults : public ::testing::Test {
 protected:
  std::string csv_of(const ResultStore& store) {
    const Description description = three_seeds();
    const Cases cases(description);
    const ResultTable table(description, cases,
                            [&](const std::string& name) { return store.find(name); });
    write_csv(table, folder_.path("t.csv"));
    return testing::text_of_file(folder_.path("t.csv"));
  }
  testing::ScratchDirectory folder_;
};

TEST_F(SweepResults, AreKeptAndSayNothingOfWhoRanThem) {
  const auto file = folder_.path("a.db"), other = folder_.path("b.db");
  ResultStore first(file), second(other);
  first.add({result_of("seed=1", "0.5", 1), result_of("seed=2", "a, \"b\"", 2)});
  CaseResult failed = result_of("seed=3", "", 1);
  failed.rows = {};
  failed.problem = "exit status 3";
  first.add({failed});
  // The other way round, elsewhere, and slower.
  second.add({failed});
  second.add({result_of("seed=2", "a, \"b\"", 50), result_of("seed=1", "0.5", 40)});
  EXPECT_EQ(csv_of(first), csv_of(second));
  EXPECT_THAT(csv_of(first), HasSubstr("\"a, \"\"b\"\"\""));
  EXPECT_EQ(first.counts().done, 2);
  EXPECT_EQ(first.counts().failed, 1);
  EXPECT_EQ(first.failed(), std::vector<std::string>{"seed=3"});
  first.forget("seed=2");
  EXPECT_FALSE(first.has("seed=2"));
  EXPECT_EQ(first.seconds("seed=2"), 2) << "what it cost is remembered";
  first.take_from(second);
  EXPECT_EQ(csv_of(first), csv_of(second));
}

TEST_F(SweepResults, OfOtherArgumentsAreNotMixed) {
  Description description = three_seeds();
  ResultStore store(folder_.path("a.db"));
  store.bind_to(description);
  store.bind_to(description);
  description.fixed["program"] = "q";
  EXPECT_THROW(store.check(description), text::InputError);
  EXPECT_THROW(store.bind_to(description), text::InputError);
}

TEST_F(SweepResults, WhatIsNoSuchFileIsRefused) {
  const std::string text =
      folder_.write("text.db", "no data base, but long enough to be looked at");
  EXPECT_THROW(ResultStore{text}, text::InputError);
  EXPECT_THROW(ResultStore(folder_.path("none.db"), text::DatabaseUse::kRead), text::InputError);
  std::filesystem::create_directory(folder_.path("folder.db"));
  EXPECT_THROW(ResultStore{folder_.path("folder.db")}, text::InputError);
}

TEST_F(SweepResults, AreCollectedFromWhatAProgramLeft) {
  const auto collected = [&](const ResultSource& source) {
    return collect(source, folder_.path(), folder_.path("output.txt"));
  };
  folder_.write("output.txt", "error 3 mm\nerror 2.5 mm\n");
  folder_.write("r.csv", "n,\"the, name\"\r\n1,\"a \"\"b\"\"\"\r\n2,\r\n");
  folder_.write("r.json", "{\"lifted\": true, \"slip\": 1.5}");
  const Rows by_pattern =
      collected({ResultSource::Kind::kOutput, "", {{"error", "error ([0-9.]+) mm"}}});
  EXPECT_EQ(by_pattern.rows, (std::vector<std::vector<std::string>>{{"2.5"}})) << "the last one";
  const Rows by_csv = collected({ResultSource::Kind::kCsv, "r.csv", {}});
  EXPECT_EQ(by_csv.names, (std::vector<std::string>{"n", "the, name"}));
  EXPECT_EQ(by_csv.rows, (std::vector<std::vector<std::string>>{{"1", "a \"b\""}, {"2", ""}}));
  const Rows by_json = collected({ResultSource::Kind::kJson, "r.json", {}});
  ASSERT_EQ(by_json.rows.size(), 1U);
  EXPECT_THAT(by_json.rows[0], ::testing::UnorderedElementsAre("true", "1.5"));
  EXPECT_THROW(collected({ResultSource::Kind::kCsv, "none.csv", {}}), text::InputError);
  EXPECT_THROW(collected({ResultSource::Kind::kOutput, "", {{"x", "x=(.)"}}}), text::InputError);
  folder_.write("bad.json", "[1, 2");
  EXPECT_THROW(collected({ResultSource::Kind::kJson, "bad.json", {}}), text::InputError);
  folder_.write("bad.csv", "a,b\n1\n");
  EXPECT_THROW(collected({ResultSource::Kind::kCsv, "bad.csv", {}}), text::InputError);
}

}  // namespace
}  // namespace prehend::sweep
