#include "drivers/wire/stream/reopening.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace prehend::drivers {
namespace {

struct NamedLine {
  static std::string name() { return "a line"; }
};

class ReopenedLine : public ::testing::Test {
 protected:
  bool attempt(Reopening& reopening) {
    return reopening.attempt(
               [&]() -> std::unique_ptr<NamedLine> {
                 if (!is_there) throw std::runtime_error("cannot open a line");
                 return std::make_unique<NamedLine>();
               },
               Time{}) != nullptr;
  }
  Reopening::Note note() {
    return [this](bool is_problem, const std::string& words) {
      (is_problem ? problems : notes).push_back(words);
    };
  }
  bool is_there = false;
  std::vector<std::string> problems, notes;
};

TEST_F(ReopenedLine, PeerThatIsStartingIsNoProblem) {
  Reopening reopening(0, note(), 3600);
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(attempt(reopening));
  EXPECT_TRUE(problems.empty());
  EXPECT_EQ(reopening.problem(), "");
  is_there = true;
  EXPECT_TRUE(attempt(reopening));
  EXPECT_EQ(notes, std::vector<std::string>{"connected by a line"});
  is_there = false;  // it was there: what is wrong now is told at once, and once
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(attempt(reopening));
  EXPECT_EQ(problems, std::vector<std::string>{"cannot open a line"});
  EXPECT_EQ(reopening.problem(), "cannot open a line");
}

TEST_F(ReopenedLine, MissingLineIsToldAfterTheGrace) {
  Reopening reopening(0, note(), 0);
  EXPECT_FALSE(attempt(reopening));
  EXPECT_EQ(problems.size(), 1u);
}

}  // namespace
}  // namespace prehend::drivers
