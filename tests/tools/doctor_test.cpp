// prehend doctor: what is wrong, and the mend.

#include <gmock/gmock.h>

#include <cstdlib>

#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class Doctor : public Command {
 protected:
  // Its page once it holds `text`.
  std::string page_with(const std::string& text) {
    std::string page;
    EXPECT_TRUE(eventually([&] {
      page = run({"doctor"}).output;
      return page.find(text) != std::string::npos;
    })) << text
        << "\n"
        << page;
    return page;
  }
};

TEST_F(Doctor, FindsNothingWrongInAGoodGraph) {
  command_ = {};  // else nobody publishes what it takes
  ASSERT_TRUE(eventually([&] { return run({"doctor"}).exit_code == 0; }));
  const Result doctor = run({"doctor"});
  EXPECT_THAT(doctor.output, AllOf(HasSubstr("1 nodes"), HasSubstr("ok       registry: answers"),
                                   HasSubstr("ok       shared memory"), Not(HasSubstr("topic "))));
  const auto json = parsed(run({"doctor", "--json"}).output);
  EXPECT_TRUE(member(json, "reachable").bool_value());
  EXPECT_EQ(member(json, "errors").number_value(), 0);
  EXPECT_EQ(text_of(element(member(json, "findings"), "subject", "registry"), "level"), "ok");
}

TEST_F(Doctor, NamesTheTopicThatWasMeant) {
  graph::Node viewer(node_options("viewer"));
  const auto wrong = viewer.subscribe<msgs::StereoPair>("/camera/sterio", graph::QoS::queue(1),
                                                        [](const auto&) {});
  viewer.spin_in_background();
  EXPECT_THAT(page_with("/camera/sterio"),
              AllOf(HasSubstr("nobody publishes it; taken by viewer"),
                    HasSubstr("did you mean \"/camera/stereo\"? "
                              "--remap /camera/sterio:=/camera/stereo")));
}

TEST_F(Doctor, SeesTypesQosLossesAndHealth) {
  graph::Node viewer(node_options("viewer"));
  const auto other_type =
      viewer.subscribe<msgs::Clock>("/camera/stereo", graph::QoS::queue(1), [](const auto&) {});
  const auto slow =
      viewer.subscribe<msgs::Clock>("/ticks", graph::QoS::latched(2), [](const auto&) {});
  const auto ticks = node_.advertise<msgs::Clock>("/ticks", graph::QoS::queue(100));
  for (int i = 0; i < 40; ++i) ticks.publish(msgs::Clock());  // the viewer does not spin
  const std::string page = page_with("dropped 38 of 40 messages");
  EXPECT_THAT(page, ContainsRegex("error +topic /camera/stereo: different message types: "
                                  "prehend.msgs.Clock .* at viewer; prehend.msgs.StereoPair"));
  EXPECT_THAT(page, HasSubstr("viewer wants kept messages, but arm publishes queue(100)"));
  EXPECT_THAT(page, ContainsRegex("error +node viewer: is in error: topic /camera/stereo"));
  EXPECT_THAT(page, ContainsRegex("warning +node viewer: is not ready"));
  EXPECT_EQ(run({"doctor"}).exit_code, 1);
}

TEST_F(Doctor, SeesAClockThatNobodyDrivesAndNamesServedTwice) {
  graph::NodeOptions options = node_options("sleeper");
  options.clock = graph::ClockMode::kSimulated;
  graph::Node sleeper(options);
  const auto service =
      sleeper.serve<msgs::Clock, msgs::Clock>("/add_one", [](const msgs::Clock& c) { return c; });
  sleeper.spin_in_background();
  const std::string page = page_with("served by");
  EXPECT_THAT(page, HasSubstr("time stands still for sleeper"));
  EXPECT_THAT(page, HasSubstr("service /add_one: served by arm and sleeper"));
}

TEST_F(Doctor, SaysThatNoRegistryAnswersAndWhy) {
  const Result none = run({"doctor", "--registry", "tcp://127.0.0.1:9"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.output, AllOf(ContainsRegex("error +registry: .*tcp://127.0.0.1:9"),
                                 HasSubstr("ok       open files")));
  const auto json = parsed(run({"doctor", "--registry", "nonsense", "--json"}).output);
  EXPECT_FALSE(member(json, "reachable").bool_value());
  EXPECT_EQ(member(json, "errors").number_value(), 1);
  ::setenv("PREHEND_REGISTRY", "tcp://127.0.0.1:9", 1);
  ChildProgram program("prehend", {"doctor"}, scratch_.path("doctor.txt"));
  EXPECT_EQ(program.wait(std::chrono::seconds(10)), 1);
  ::unsetenv("PREHEND_REGISTRY");
  EXPECT_THAT(program.output(), HasSubstr("(from PREHEND_REGISTRY)"));
}

TEST_F(Doctor, SeesARuntimeFolderOfNoUse) {
  const char* before = std::getenv("XDG_RUNTIME_DIR");
  const std::string kept = before ? before : "";
  ::setenv("XDG_RUNTIME_DIR", "/none/such", 1);
  EXPECT_THAT(run({"doctor"}).output,
              HasSubstr("warning  XDG_RUNTIME_DIR: /none/such is no folder"));
  if (before) {
    ::setenv("XDG_RUNTIME_DIR", kept.c_str(), 1);
  } else {
    ::unsetenv("XDG_RUNTIME_DIR");
  }
}

}  // namespace
}  // namespace prehend::testing
