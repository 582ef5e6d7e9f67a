// What a long command says of its stages.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "tools/grasp_plan/progress.h"

namespace prehend::tools {
namespace {

using namespace std::chrono_literals;

// A stream in memory, and what was written to it so far.
class Written {
 public:
  ~Written() {
    std::fclose(stream);
    std::free(text_);
  }
  std::string text() const {
    std::fflush(stream);
    return {text_, size_};
  }

 private:
  char* text_ = nullptr;
  std::size_t size_ = 0;

 public:
  std::FILE* const stream = open_memstream(&text_, &size_);
};

TEST(Progress, WithoutPatienceEachStageIsALine) {
  Written written;
  Progress progress(0ms, written.stream);
  progress.stage("reading");
  progress.stage("planning");
  EXPECT_EQ(written.text(), "reading ...\nplanning ...\n");
}

TEST(Progress, WhatIsSoonOverIsNotSaid) {
  Written written;
  {
    Progress progress(1h, written.stream);
    progress.stage("reading");
    progress.stage("planning");
    progress.over();
  }
  EXPECT_EQ(written.text(), "");
}

TEST(Progress, WhatLastsIsSaidOnce) {
  Written written;
  {
    Progress progress(1ms, written.stream);
    progress.stage("reading");
    // As long as it takes: the line comes from another thread.
    while (std::ftell(written.stream) == 0) std::this_thread::sleep_for(1ms);
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_EQ(written.text(), "reading ...\n");
}

TEST(Progress, NumbersAreReadable) {
  EXPECT_EQ(with_commas(0), "0");
  EXPECT_EQ(with_commas(999), "999");
  EXPECT_EQ(with_commas(1000), "1,000");
  EXPECT_EQ(with_commas(2000000), "2,000,000");
}

}  // namespace
}  // namespace prehend::tools
