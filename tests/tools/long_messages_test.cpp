// `prehend topic echo` of messages that nobody reads in full: as text and as JSON.

#include <gmock/gmock.h>

#include "msgs/objects.pb.h"
#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// 20 million elements took 2.4 GB, and 180 MB of JSON were printed.
TEST_F(Command, EchoCutsLongListsAndSaysTheirSizes) {
  constexpr int kElements = 3'000'000;
  const auto touch = node_.advertise<msgs::TactileFrame>("/touch", graph::QoS::latched(1));
  msgs::TactileFrame frame;
  frame.set_rows(14);
  frame.set_sum(2.5);
  for (int i = 0; i < kElements; ++i) frame.add_intensity(1000 + static_cast<std::uint32_t>(i));
  touch.publish(frame);

  const Result text = run({"topic", "echo", "/touch", "-n", "1"});
  EXPECT_EQ(text.exit_code, 0) << text.output;
  EXPECT_THAT(text.output, AllOf(HasSubstr("1014, 1015, ... 3000000 in all]"),
                                 HasSubstr("sum: 2.5"), Not(HasSubstr("1016"))));

  const Result json = run({"topic", "echo", "/touch", "-n", "1", "--json"});
  EXPECT_LT(json.output.size(), 20'000u);
  const auto value = parsed(json.output);
  const auto message = member(value, "message");
  EXPECT_EQ(member(message, "intensity").list_value().values_size(), 1000);
  EXPECT_EQ(member(message, "sum").number_value(), 2.5);
  EXPECT_EQ(member(member(value, "shortened"), "intensity").number_value(), kElements);
}

TEST_F(Command, EchoCutsListsOfMessagesAndNestedOnes) {
  const auto topic = node_.advertise<msgs::ObjectHypotheses>("/objects", graph::QoS::latched(1));
  msgs::ObjectHypotheses objects;
  for (int i = 0; i < 40; ++i) {
    objects.add_objects()->mutable_cloud()->set_data(std::string(i == 3 ? 70'000 : 100, 'x'));
  }
  topic.publish(objects);
  const Result text = run({"topic", "echo", "/objects", "-n", "1"});
  EXPECT_THAT(text.output,
              AllOf(HasSubstr("# objects: the first 16 of 40"), HasSubstr("data: <70000 bytes>")));
  const auto json = parsed(run({"topic", "echo", "/objects", "-n", "1", "--json"}).output);
  EXPECT_EQ(member(member(json, "message"), "objects").list_value().values_size(), 40);
  EXPECT_EQ(member(member(json, "shortened"), "objects[3].cloud.data").number_value(), 70'000);
  const std::string full = run({"topic", "echo", "/objects", "-n", "1", "--json", "--full"}).output;
  EXPECT_THAT(full, Not(HasSubstr("shortened")));
  EXPECT_GT(full.size(), 90'000u);
}

// Lists as long as those that are cut, but whole, beside one that is cut.
TEST_F(Command, EchoTellsWhichListWasCut) {
  const auto touch = node_.advertise<msgs::TactileFrame>("/touch", graph::QoS::latched(1));
  for (const int count : {16, 17}) {
    msgs::TactileFrame frame;
    for (int i = 0; i < count; ++i) frame.add_intensity(static_cast<std::uint32_t>(i));
    touch.publish(frame);
    const std::string text = run({"topic", "echo", "/touch", "-n", "1"}).output;
    EXPECT_THAT(text, HasSubstr(count == 16 ? "14, 15]" : "14, 15, ... 17 in all]"));
  }
}

}  // namespace
}  // namespace prehend::testing
