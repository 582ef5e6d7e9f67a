// What programs leave, as figures.

#include "prehend/sweep/collect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/text/input_error.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using namespace sweep;
using Kind = ResultSource::Kind;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Collecting : public ::testing::Test {
 protected:
  Rows from(const ResultSource& source) {
    return collect(source, folder_.path(), folder_.path("output.txt"));
  }
  std::string refusal(const ResultSource& source) {
    try {
      from(source);
    } catch (const text::InputError& error) {
      return error.problem();
    }
    return "";
  }
  ScratchDirectory folder_;
};

TEST_F(Collecting, ReadsCsv) {
  folder_.write("cases.csv", "name,force\n\"a, b\",3.5\nc,\n");
  const Rows rows = from({Kind::kCsv, "cases.csv", {}});
  EXPECT_THAT(rows.names, ElementsAre("name", "force"));
  EXPECT_THAT(rows.rows, ElementsAre(ElementsAre("a, b", "3.5"), ElementsAre("c", "")));
  folder_.write("twice.csv", "a,a\n1,2\n");
  EXPECT_THAT(refusal({Kind::kCsv, "twice.csv", {}}), HasSubstr("twice"));
  EXPECT_THAT(refusal({Kind::kCsv, "none.csv", {}}), HasSubstr("wrote no none.csv"));
}

TEST_F(Collecting, ReadsJson) {
  folder_.write(
      "r.json",
      R"({"score": 0.1, "hand": {"name": "sdh", "held": true}, "at": [1, 2], "no": null})");
  const Rows rows = from({Kind::kJson, "r.json", {}});
  EXPECT_THAT(rows.names, ElementsAre("at", "hand.held", "hand.name", "no", "score"));
  EXPECT_THAT(rows.rows, ElementsAre(ElementsAre("[1,2]", "true", "sdh", "", "0.1")));
  folder_.write("r.json", "[1, 2");
  EXPECT_THAT(refusal({Kind::kJson, "r.json", {}}), HasSubstr("no JSON object"));
}

TEST_F(Collecting, ReadsTextAsItIs) {
  const std::string text("a: 1\n\n\"b, c\"\r\n");
  folder_.write("r.yaml", text);
  const Rows rows = from({Kind::kText, "r.yaml", {}});
  EXPECT_THAT(rows.names, ElementsAre("text"));
  EXPECT_THAT(rows.rows, ElementsAre(ElementsAre(text)));
  EXPECT_THAT(refusal({Kind::kText, "none.yaml", {}}), HasSubstr("wrote no none.yaml"));
}

TEST_F(Collecting, ReadsWhatIsPrinted) {
  const ResultSource source{Kind::kOutput, "", {{"force", "force (\\S+) N"}}};
  folder_.write("output.txt", "force 1 N\nforce 2.5 N\nend\n");
  EXPECT_THAT(from(source).rows, ElementsAre(ElementsAre("2.5"))) << "the last one counts";
  folder_.write("output.txt", "end\n");
  EXPECT_THAT(refusal(source), HasSubstr("printed no force"));
  folder_.write("output.txt", "");
  EXPECT_THAT(refusal(source), HasSubstr("printed nothing"));
  folder_.write("output.txt", std::string(1 << 20, 'x') + "\nforce 3 N\n");
  EXPECT_THAT(from(source).rows, ElementsAre(ElementsAre("3"))) << "after a very long line";
}

TEST_F(Collecting, KeepsTheLastLines) {
  std::string text;
  for (int i = 1; i <= 100; ++i) text += "line " + std::to_string(i) + "\n";
  const std::string last = last_lines(folder_.write("output.txt", text));
  EXPECT_EQ(last.substr(0, 8), "line 81\n");
  EXPECT_EQ(last.substr(last.size() - 9), "line 100\n");
  EXPECT_LE(last_lines(folder_.write("output.txt", std::string(1 << 20, 'x'))).size(), 5000u);
  EXPECT_EQ(last_lines(folder_.path("none")), "");
}

}  // namespace
}  // namespace prehend::testing
