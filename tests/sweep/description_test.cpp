// Reading descriptions, and what is refused in words.

#include "prehend/sweep/description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/sweep/cases.h"
#include "prehend/text/input_error.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using namespace sweep;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Descriptions : public ::testing::Test {
 protected:
  Description read(const std::string& text) {
    return read_description(folder_.write("sweep.yaml", text),
                            [](const std::vector<std::string>& words) { return words; });
  }
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const text::InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << "was taken: " << text;
    return "";
  }

  ScratchDirectory folder_;
};

TEST_F(Descriptions, SayAll) {
  const Description made = read(
      "program: eval_grasp\n"
      "arguments: [--only, '{object}', '--seed={seed}', '{mass}', '{folder}']\n"
      "grid:\n"
      "  object: [mug, cup]\n"
      "  seed: {from: 1, to: 10}\n"
      "sample: {count: 20, seed: 3, mass: {log_uniform: [0.001, 10]}}\n"
      "results: {csv: cases.csv}\n"
      "timeout: 2min\n"
      "keep: failed\n");
  EXPECT_EQ(made.program, "eval_grasp");
  EXPECT_EQ(Cases(made).size(), 2 * 10 * 20);
  EXPECT_EQ(made.sample_seed, 3u);
  EXPECT_EQ(made.results.kind, ResultSource::Kind::kCsv);
  EXPECT_EQ(made.timeout, 120);
  EXPECT_FALSE(made.keep);
  EXPECT_EQ(made.fixed.at("arguments"),
            R"(["--only","{object}","--seed={seed}","{mass}","{folder}"])");
}

TEST_F(Descriptions, TakeValuesThatAProgramPrints) {
  const Description made = read(
      "{program: a, arguments: ['{x}'], grid: {x: {lines_of: [eval_a, --list]}}, results: none}");
  EXPECT_EQ(made.grid[0].values.at(0), "eval_a");
  EXPECT_EQ(made.grid[0].values.at(1), "--list");
}

TEST_F(Descriptions, TakePatterns) {
  const Description made = read(
      "{program: a, arguments: ['{x}'], grid: {x: 1}, timeout: 1.5,"
      " results: {output: {force: 'F (.*) N', score: '(\\d+)'}}}");
  EXPECT_THAT(made.results.patterns,
              ElementsAre(std::pair<std::string, std::string>{"force", "F (.*) N"},
                          std::pair<std::string, std::string>{"score", "(\\d+)"}));
  EXPECT_EQ(made.timeout, 1.5);
}

TEST_F(Descriptions, RefuseWhatIsWrong) {
  const auto with = [](const std::string& grid, const std::string& arguments = "'{x}'",
                       const std::string& rest = "results: none") {
    return "program: a\narguments: [" + arguments + "]\n" + grid + "\n" + rest + "\n";
  };
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "results: none\ntimout: 3")),
              AllOf(HasSubstr("sweep.yaml:5"), HasSubstr("timout"), HasSubstr("timeout")));
  EXPECT_THAT(refusal("arguments: ['{x}']\ngrid: {x: 1}\nresults: none"), HasSubstr("program"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{y}', '{x}'")),
              AllOf(HasSubstr(":2"), HasSubstr("{y}"), HasSubstr("no parameter")));
  EXPECT_THAT(refusal(with("grid: {x: 1, y: 2}")), HasSubstr("'y' nowhere"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x'")), HasSubstr("without its }"));
  EXPECT_THAT(refusal(with("grid: {}", "b")), HasSubstr("empty"));
  EXPECT_THAT(refusal(with("grid: {x: []}")), HasSubstr("no values"));
  EXPECT_THAT(refusal(with("grid: {x: [1, 1]}")), HasSubstr("twice"));
  EXPECT_THAT(refusal(with("", "b")), HasSubstr("Describe the cases"));
  EXPECT_THAT(refusal(with("grid: {x: {from: 1, to: 10000001}}")), HasSubstr("10000000 cases"));
  // The product must not wrap around: 10^18 * 100 does.
  EXPECT_THAT(refusal(with("grid: {x: {from: 1, to: 1e9}, y: {from: 1, to: 1e9}, z: {from: 1, to: "
                           "100}}",
                           "'{x}{y}{z}'")),
              HasSubstr("10000000 cases"));
  EXPECT_THAT(refusal(with("grid: {x: {from: 1, too: 3}}")), HasSubstr("from and to"));
  EXPECT_THAT(refusal(with("grid: {x: {from: 1, to: 3, stp: 3}}")), HasSubstr("stp"));
  EXPECT_THAT(refusal(with("grid: {x: {from: 3, to: 1}}")), HasSubstr("step"));
  EXPECT_THAT(refusal(with("grid: {x: {from: 0, to: 1, count: 3, spacing: log}}")),
              HasSubstr("above 0"));
  EXPECT_THAT(refusal(with("grid: {folder: [1]}", "'{folder}'")), HasSubstr("'folder'"));
  EXPECT_THAT(refusal(with("grid: {'a b': [1]}", "'{a b}'")), HasSubstr("a b"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "")), HasSubstr("results is missing"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "results: {csv: ../a.csv}")),
              HasSubstr("outside"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "results: {csv: a, json: b}")),
              HasSubstr("one of"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "results: {output: {a: 'b'}}")),
              HasSubstr("group"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "results: {output: {a: '(b'}}")),
              HasSubstr("regular expression"));
  EXPECT_THAT(refusal(with("grid: {x: 1}", "'{x}'", "results: none\ntimeout: soon")),
              HasSubstr("timeout"));
  const std::string sample = "sample: {count: 2, x: ";
  EXPECT_THAT(refusal(with("sample: {count: 0, x: {uniform: [1, 2]}}")), HasSubstr("count"));
  EXPECT_THAT(refusal(with("sample: {count: 2}", "b")), HasSubstr("draws nothing"));
  EXPECT_THAT(refusal(with(sample + "{uniform: [2, 1]}}")), HasSubstr("too small"));
  EXPECT_THAT(refusal(with(sample + "{log_uniform: [0, 1]}}")), HasSubstr("above 0"));
  EXPECT_THAT(refusal(with(sample + "{integer: [0.5, 1]}}")), HasSubstr("whole"));
  EXPECT_THAT(refusal(with(sample + "{gaussian: [0, 1]}}")), HasSubstr("distribution"));
  EXPECT_THAT(refusal(with("grid: {x: 1}\n" + sample + "{uniform: [0, 1]}}")),
              HasSubstr("that grid has"));
}

}  // namespace
}  // namespace prehend::testing
