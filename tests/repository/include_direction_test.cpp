#include "tests/repository/include_direction.h"

#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(IncludeDirection, WhatGoesUpOrAcrossIsFound) {
  const auto of = [](const std::string& file, const std::string& included) {
    return wrong_includes(file, "#pragma once\n#include \"" + included + "\"\n");
  };
  EXPECT_THAT(of("prehend/grasp/planner.cpp", "msgs/grasp.pb.h"),
              ElementsAre(HasSubstr("prehend/grasp/planner.cpp:2: includes msgs/grasp.pb.h")));
  EXPECT_THAT(of("prehend/grasp/planner.cpp", "prehend/graph/node.h"), ElementsAre(::testing::_));
  EXPECT_THAT(of("prehend/shape/vote.h", "prehend/surface/model.h"), ElementsAre(::testing::_));
  EXPECT_THAT(of("prehend/graph/node.h", "prehend/geometry/plane.h"), ElementsAre(::testing::_));
  EXPECT_THAT(of("prehend/recording/mcap_reader.h", "msgs/graph.pb.h"), ElementsAre(::testing::_));
  EXPECT_THAT(of("prehend/viewing/hub.h", "prehend/graph/node.h"), ElementsAre(::testing::_));
  EXPECT_THAT(of("prehend/newcomer/x.h", "prehend/geometry/plane.h"),
              ElementsAre(HasSubstr("kFloors")));
  EXPECT_THAT(of("prehend/shape/vote.h", "tests/shape/views.h"), ElementsAre(::testing::_));
  EXPECT_THAT(of("nodes/simulation/main.cpp", "nodes/recorder/run_facts.h"),
              ElementsAre(::testing::_));
  EXPECT_THAT(of("msgs/convert/grasp.h", "prehend/graph/node.h"), ElementsAre(::testing::_));

  EXPECT_THAT(of("prehend/surface/model.h", "prehend/shape/completed_shape.h"), IsEmpty());
  EXPECT_THAT(of("prehend/launch/supervisor.h", "prehend/graph/node.h"), IsEmpty());
  EXPECT_THAT(of("msgs/convert/grasp.h", "prehend/grasp/planner.h"), IsEmpty());
  EXPECT_THAT(of("nodes/simulation/main.cpp", "prehend/graph/node.h"), IsEmpty());
}

TEST(IncludeDirection, TheTreeKeepsIt) {
  int files = 0;
  for (const char* top : {"msgs", "prehend", "nodes", "drivers", "tools", "eval"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".h") continue;
      std::ifstream stream(entry.path());
      const std::string text{std::istreambuf_iterator<char>(stream), {}};
      ++files;
      for (const std::string& wrong : wrong_includes(entry.path(), text)) ADD_FAILURE() << wrong;
    }
  }
  EXPECT_GT(files, 500) << "run it from the source tree";
}

}  // namespace
}  // namespace prehend::testing
