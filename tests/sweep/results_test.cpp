// The results' file, and the table made of it.

#include "prehend/sweep/results.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/sweep/table.h"
#include "prehend/text/input_error.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using namespace sweep;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Results : public ::testing::Test {
 protected:
  Results() {
    description_.file = "sweep.yaml";
    description_.grid = {{"x", Values::list({"1", "2", "3", "4"})}};
    description_.fixed = {{"program", "a"}, {"arguments", "[\"{x}\"]"}};
  }
  std::string table(const ResultStore& store) {
    const Cases cases(description_);
    const std::string file = folder_.path("table.csv");
    write_csv(
        ResultTable(description_, cases, [&](const std::string& name) { return store.find(name); }),
        file);
    return text_of_file(file);
  }

  ScratchDirectory folder_;
  Description description_;
};

TEST_F(Results, AreKept) {
  const CaseResult good{"x=1", "", "", {{"a", "b"}, {{"1", "q\"\n,"}, {"2", ""}}}, 1.5, "host:1"};
  const CaseResult bad{"x=2", "exit status 3", "last words\n", {}, 0.5, "host:2"};
  {
    ResultStore store(folder_.path("r.db"));
    store.add({good, bad});
  }
  const ResultStore store(folder_.path("r.db"), text::DatabaseUse::kRead);
  EXPECT_TRUE(store.has("x=1"));
  EXPECT_FALSE(store.has("x=3"));
  EXPECT_EQ(store.find("x=1")->rows.names, good.rows.names);
  EXPECT_EQ(store.find("x=1")->rows.rows, good.rows.rows);
  EXPECT_EQ(store.find("x=2")->problem, "exit status 3");
  EXPECT_EQ(store.find("x=2")->output, "last words\n");
  EXPECT_EQ(store.seconds("x=1"), 1.5);
  EXPECT_THAT(store.failed(), ElementsAre("x=2"));
  EXPECT_EQ(store.counts().done, 1);
  EXPECT_EQ(store.counts().failed, 1);
}

TEST_F(Results, AreForgottenButNotTheirCost) {
  ResultStore store(folder_.path("r.db"));
  store.add({{"x=1", "", "", {}, 2, "w"}});
  store.forget("x=1");
  EXPECT_FALSE(store.has("x=1"));
  EXPECT_EQ(store.seconds("x=1"), 2);
}

TEST_F(Results, OfOtherArgumentsAreRefused) {
  ResultStore store(folder_.path("r.db"));
  store.bind_to(description_);
  store.bind_to(description_);
  description_.fixed["arguments"] = "[\"{x}\",\"--quick\"]";
  try {
    store.bind_to(description_);
    FAIL() << "was taken";
  } catch (const text::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("other arguments"));
    EXPECT_THAT(error.what(), HasSubstr("--quick"));
  }
}

TEST_F(Results, BeginAnewWithTheirCosts) {
  ResultStore store(folder_.path("anew.db"));
  const std::map<std::string, std::string> first{{"build", "1"}, {"setting", ""}};
  EXPECT_FALSE(store.agrees_with(first)) << "nothing is noted";
  store.begin_anew(first);
  EXPECT_TRUE(store.agrees_with(first));
  CaseResult one;
  one.name = "a";
  one.seconds = 3;
  store.add({one});
  const std::map<std::string, std::string> second{{"build", "2"}, {"setting", ""}};
  EXPECT_FALSE(store.agrees_with(second));
  store.begin_anew(second);
  EXPECT_TRUE(store.agrees_with(second));
  EXPECT_FALSE(store.agrees_with(first));
  EXPECT_FALSE(store.has("a"));
  EXPECT_EQ(store.seconds("a"), 3);
}

TEST_F(Results, OfAnotherProgramAreRefused) {
  folder_.write("r.db", std::string(4096, 'x'));
  EXPECT_THROW(ResultStore(folder_.path("r.db")), text::InputError);
  EXPECT_THROW(ResultStore(folder_.path("none.db"), text::DatabaseUse::kRead), text::InputError);
}

TEST_F(Results, AreMerged) {
  ResultStore whole(folder_.path("r.db")), part(folder_.path("p.db"));
  part.add({{"x=3", "", "", {{"a"}, {{"7"}}}, 2, "w"}});
  whole.take_from(part);
  whole.take_from(part);
  EXPECT_THAT(whole.find("x=3")->rows.rows, ElementsAre(ElementsAre("7")));
  EXPECT_EQ(whole.seconds("x=3"), 2);
  EXPECT_EQ(whole.counts().done, 1);
}

TEST_F(Results, OfAFileThatCannotBeWrittenNothingStays) {
  namespace fs = std::filesystem;
  const fs::path folder = folder_.path("taken");
  fs::create_directories(folder / "table.csv" / "in_the_way");
  const auto empty = [](std::ostream& out) { out << "a"; };
  EXPECT_THROW(write_text(folder / "table.csv", empty), text::InputError);
  EXPECT_THROW(write_whole(folder / "other.csv",
                           [](const fs::path& part) {
                             std::ofstream(part) << "half";
                             throw text::InputError("no space", "make some");
                           }),
               text::InputError);
  int entries = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder)) ++entries;
  EXPECT_EQ(entries, 1);
}

TEST_F(Results, MakeOneTable) {
  ResultStore store(folder_.path("r.db"));
  store.add({{"x=4", "", "", {{"b"}, {{"1"}}}, 2, "w"}});
  store.add({{"x=2", "It failed", "words", {}, 3, "w"}});
  store.add({{"x=1", "", "", {{"a", "x"}, {{"p,q", "9"}, {"say \"so\"", "8"}}}, 1, "w"}});
  EXPECT_EQ(table(store),
            "case,x,state,problem,a,result.x,b\r\n"
            "x=1,1,done,,\"p,q\",9,\r\n"
            "x=1,1,done,,\"say \"\"so\"\"\",8,\r\n"
            "x=2,2,failed,It failed,,,\r\n"
            "x=4,4,done,,,,1\r\n");
  const Cases cases(description_);
  const ResultTable made(description_, cases,
                         [&](const std::string& name) { return store.find(name); });
  EXPECT_EQ(made.rows(), 4);
  EXPECT_EQ(made.failed(), 1);
  EXPECT_EQ(made.missing(), 1);
  ASSERT_EQ(made.columns().size(), 7u);
  EXPECT_EQ(made.columns()[1].kind, ColumnKind::kWhole);
  EXPECT_EQ(made.columns()[2].kind, ColumnKind::kText);
  EXPECT_EQ(made.columns()[5].kind, ColumnKind::kNumber) << "whole numbers, but not everywhere";

  ResultStore one(folder_.path("one.db"));
  one.add({{"x=1", "", "", {{"none", "a"}, {{"", "2"}}}, 1, "w"}});
  const ResultTable empty(description_, cases,
                          [&](const std::string& name) { return one.find(name); });
  EXPECT_EQ(empty.columns()[3].kind, ColumnKind::kText) << "no problem stands in it";
  EXPECT_EQ(empty.columns()[4].kind, ColumnKind::kText) << "nothing stands in it";
  EXPECT_EQ(empty.columns()[5].kind, ColumnKind::kWhole);
}

}  // namespace
}  // namespace prehend::testing
