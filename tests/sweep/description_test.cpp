#include "prehend/sweep/description.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/text/input_error.h"
#include "tests/launch/child_program.h"

namespace prehend::sweep {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SweepDescription : public ::testing::Test {
 protected:
  Description read(const std::string& text) {
    return read_description(
        folder_.write("s.yaml", text), [](const std::vector<std::string>& words) {
          return std::vector<std::string>{words.back() + "1", words.back() + "2"};
        });
  }
  std::string error_of(const std::string& text) {
    try {
      read(text);
    } catch (const text::InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("s.yaml"));
      return error.what();
    }
    return "";
  }
  testing::ScratchDirectory folder_;
};

const std::string kHead = "program: eval_grasp\narguments: ['--seed={seed}', --out, '{folder}']\n";

TEST_F(SweepDescription, SaysWhatIsRun) {
  const Description read_in = read(kHead +
                                   "grid: {seed: {from: 1, to: 3}}\nresults: {csv: cases.csv}\n"
                                   "timeout: 2 min\n");
  ASSERT_EQ(read_in.grid.size(), 1U);
  EXPECT_EQ(read_in.grid[0].values.size(), 3);
  EXPECT_EQ(read_in.results.kind, ResultSource::Kind::kCsv);
  EXPECT_EQ(read_in.timeout, 120);
  const Description listed = read(kHead + "grid: {seed: {lines_of: [ls, x]}}\nresults: none\n");
  EXPECT_EQ(listed.grid[0].values.at(1), "x2");
}

TEST_F(SweepDescription, RefusesWhatIsNoSweep) {
  const std::string grid = "grid: {seed: [1, 2]}\n", results = "results: none\n";
  EXPECT_EQ(error_of(kHead + grid + results), "");
  EXPECT_THAT(error_of(kHead + grid), HasSubstr("results"));
  EXPECT_THAT(error_of("program: p\narguments: [x]\n" + results), HasSubstr("grid"));
  EXPECT_THAT(error_of(kHead + grid + results + "tiemout: 3\n"),
              AllOf(HasSubstr("tiemout"), HasSubstr("timeout")));
  EXPECT_THAT(error_of(kHead + "grid: {seed: [1], extra: [2]}\n" + results), HasSubstr("extra"));
  EXPECT_THAT(error_of(kHead + "grid: {sede: [1]}\n" + results), HasSubstr("sede"));
  EXPECT_THAT(error_of(kHead + "grid: {}\n" + results), HasSubstr("grid"));
  EXPECT_THAT(error_of(kHead + "grid: {seed: [1, 1]}\n" + results), HasSubstr("seed"));
  EXPECT_THAT(error_of(kHead + "grid: {seed: {from: 1, to: 20000000}}\n" + results),
              HasSubstr("10000000"));
  EXPECT_THAT(error_of(kHead + "sample: {count: 3, seed_: {uniform: [0, 1]}}\n" + results),
              HasSubstr("seed_"));
  EXPECT_THAT(error_of(kHead + grid + "results: {csv: ../x.csv}\n"), HasSubstr("outside"));
  EXPECT_THAT(error_of(kHead + grid + "results: {output: {v: 'no group'}}\n"), HasSubstr("group"));
  EXPECT_THAT(error_of(kHead + grid + "results: {output: {v: '('}}\n"),
              HasSubstr("regular expression"));
  EXPECT_THAT(error_of("arguments: ['{seed}']\n" + grid + results), HasSubstr("program"));
  EXPECT_THAT(error_of("program: p\narguments: ['{seed']\n" + grid + results), HasSubstr("{seed"));
  EXPECT_THAT(error_of("[1, 2"), HasSubstr("s.yaml"));
}

}  // namespace
}  // namespace prehend::sweep
