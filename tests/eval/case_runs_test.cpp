#include "eval/case_runs.h"

#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/text_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/sweep/results.h"
#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> names_of(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back("case_" + std::to_string(i));
  return names;
}

bool any(const std::string&) { return true; }

std::vector<std::string> texts_of(const std::vector<CaseOutcome<std::string>>& outcomes) {
  std::vector<std::string> texts;
  for (const auto& one : outcomes) texts.push_back(one.result.value_or("none: " + one.problem));
  return texts;
}

class CaseRuns : public ::testing::Test {
 protected:
  // How often a case began, over all runs.
  void begin(int i) const {
    std::ofstream(folder_.path / ("began_" + std::to_string(i)), std::ios::app) << ".";
  }
  int begun(int i) const {
    std::error_code none;
    const auto size =
        std::filesystem::file_size(folder_.path / ("began_" + std::to_string(i)), none);
    return none ? 0 : static_cast<int>(size);
  }

  testing::TemporaryFolder folder_;
  CaseRunOptions options_{.out = folder_.path / "out", .processes = 3};
};

TEST_F(CaseRuns, AreTheSameByAnyNumberOfProcesses) {
  const auto run = [](int i) { return "result of " + std::to_string(i); };
  const auto three = texts_of(run_text_cases(options_, names_of(20), any, run));
  EXPECT_EQ(three[7], "result of 7");
  options_ = {.out = folder_.path / "alone", .processes = 1};
  EXPECT_EQ(texts_of(run_text_cases(options_, names_of(20), any, run)), three);
  EXPECT_FALSE(std::filesystem::exists(folder_.path / "out" / "cases")) << "all went well";
}

TEST_F(CaseRuns, WhatFailsIsSaidAndTriedAgainAlone) {
  bool is_well = false;
  const auto run = [&](int i) -> std::string {
    begin(i);
    if (i == 1 && !is_well) throw std::runtime_error("no such luck");
    if (i == 2 && !is_well) std::raise(SIGSEGV);
    return "fine";
  };
  ::testing::internal::CaptureStderr();
  EXPECT_THAT(texts_of(run_text_cases(options_, names_of(4), any, run)),
              ElementsAre("fine", "none: exit status 70", HasSubstr("none: signal 11"), "fine"));
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              HasSubstr("case_1: exit status 70\n    no such luck\n"));
  is_well = true;
  EXPECT_THAT(texts_of(run_text_cases(options_, names_of(4), any, run)),
              ElementsAre("fine", "fine", "fine", "fine"));
  EXPECT_EQ(begun(0), 1);
  EXPECT_EQ(begun(1), 2);
}

// As where memory ends.
TEST_F(CaseRuns, WhatIsKilledIsGivenOutAgain) {
  EXPECT_THAT(texts_of(run_text_cases(options_, names_of(3), any,
                                      [&](int i) -> std::string {
                                        begin(i);
                                        if (i == 1 && begun(1) < 3) kill(getpid(), SIGKILL);
                                        return "fine";
                                      })),
              ElementsAre("fine", "fine", "fine"));
  EXPECT_EQ(begun(1), 3);
}

TEST_F(CaseRuns, WhatHangsIsEnded) {
  options_.timeout = 0.3;
  EXPECT_THAT(texts_of(run_text_cases(options_, names_of(1), any,
                                      [](int) -> std::string {
                                        sleep(60);
                                        return "late";
                                      })),
              ElementsAre(HasSubstr("It took longer than 0.3 s")));
}

// Runs with other launch arguments would be taken for those that are asked for.
TEST_F(CaseRuns, OfAnotherSettingAreForgottenAndTheirCostsAreNot) {
  const auto runs = [&] {
    const int before = begun(0);
    run_text_cases(options_, names_of(1), any, [&](int i) -> std::string {
      begin(i);
      return "fine";
    });
    return begun(0) - before;
  };
  EXPECT_EQ(runs(), 1);
  EXPECT_EQ(runs(), 0);
  options_.setting = "minimum_stability:=0.1\n";
  EXPECT_EQ(runs(), 1);
  EXPECT_EQ(runs(), 0);
  options_.setting.clear();
  EXPECT_EQ(runs(), 1);
  options_.fresh = true;
  EXPECT_EQ(runs(), 1);
  const sweep::ResultStore store(options_.out / "results.db", text::DatabaseUse::kRead);
  EXPECT_TRUE(store.seconds("case_0"));
}

TEST_F(CaseRuns, WhatIsNoResultIsRunAgain) {
  const auto run = [&](int i) -> std::string {
    begin(i);
    return "12";
  };
  run_text_cases(options_, names_of(1), any, run);
  const auto is_longer = [](const std::string& text) {
    if (text.size() == 2) throw geometry::InputError("It is too short", "Run it again");
    return true;
  };
  run_text_cases(options_, names_of(1), is_longer, run);
  EXPECT_EQ(begun(0), 2);
}

TEST_F(CaseRuns, AFolderThatCannotBeMadeIsNamed) {
  write_text(options_.out / "file", "");
  options_.out /= "file/folder";
  const auto run = [](int) -> std::string { return "fine"; };
  EXPECT_THAT([&] { run_text_cases(options_, names_of(1), any, run); },
              ::testing::ThrowsMessage<geometry::InputError>(
                  HasSubstr("file/folder' cannot be made: Not a directory")));
}

TEST_F(CaseRuns, FoldersOfOthersAreRefused) {
  std::filesystem::create_directories(options_.out);
  write_text(options_.out / "results.db", "no database");
  const auto run = [](int) -> std::string { return "fine"; };
  EXPECT_THROW(run_text_cases(options_, names_of(1), any, run), geometry::InputError);
  options_.out = folder_.path / "inner";
  EXPECT_THAT(texts_of(run_text_cases(options_, names_of(1), any,
                                      [&](int) -> std::string {
                                        try {
                                          run_text_cases(options_, names_of(1), any, run);
                                        } catch (const geometry::InputError& error) {
                                          return error.what();
                                        }
                                        return "twice";
                                      })),
              ElementsAre(HasSubstr("is in use by another run")));
}

}  // namespace
}  // namespace prehend::eval
