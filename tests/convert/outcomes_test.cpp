// Enums of messages: there and back, and what the library does not know is refused.

#include "msgs/convert/outcomes.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

// All values of a message's enum from `first` to `last`, by the words of the library, and those
// beside them. Descriptors name the message's.
template <class Message, class Words>
void expect_same(int first, int last, const google::protobuf::EnumDescriptor& names, Words words) {
  for (int i = first; i <= last; ++i) {
    const auto value = from_message(static_cast<Message>(i));
    EXPECT_EQ(to_message(value), i);
    std::string name = names.FindValueByNumber(i)->name();
    for (char& c : name) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
    EXPECT_EQ(words(value), name);
  }
  for (const int i :
       {first - 1, last + 1, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()}) {
    EXPECT_THAT([&] { from_message(static_cast<Message>(i)); },
                ThrowsMessage<geometry::InputError>(
                    AllOf(HasSubstr("that is unknown (" + std::to_string(i) + ")"),
                          HasSubstr("Mend or update the node that published it"))));
  }
}

TEST(MessageEnums, AreTheLibrarysByNameAndValue) {
  const auto words = [](auto value) { return std::string(to_string(value)); };
  expect_same<msgs::ArmSegment::Kind>(1, 6, *msgs::ArmSegment::Kind_descriptor(), words);
  expect_same<msgs::CycleState::Phase>(1, 10, *msgs::CycleState::Phase_descriptor(), words);
  expect_same<msgs::Task::Action>(1, 15, *msgs::Task::Action_descriptor(), words);
}

TEST(MessageEnums, KindsOfSurprisesAndOutcomesThatAreUnknownAreRefused) {
  EXPECT_EQ(from_message(msgs::Surprise::MOTION), control::SurpriseKind::kMotion);
  EXPECT_EQ(from_message(msgs::Surprise::SLIP), control::SurpriseKind::kSlip);
  EXPECT_THROW(from_message(static_cast<msgs::Surprise::Kind>(msgs::Surprise::Kind_MAX + 1)),
               geometry::InputError);
  EXPECT_THROW(from_message(static_cast<msgs::Surprise::Kind>(-1)), geometry::InputError);
  EXPECT_EQ(from_message(msgs::CycleResult::UNGRASPABLE), control::CycleOutcome::kUngraspable);
  EXPECT_EQ(from_message(msgs::CycleResult().outcome()), control::CycleOutcome::kFailed);
  EXPECT_THROW(from_message(static_cast<msgs::CycleResult::Outcome>(3)), geometry::InputError);
  EXPECT_THROW(from_message(static_cast<msgs::CycleResult::Outcome>(-1)), geometry::InputError);
}

TEST(MessageEnums, APlanIsGraspableByItsGrasps) {
  msgs::GraspPlan plan;
  EXPECT_EQ(outcome_of(plan), grasp::PlanOutcome::kFailed) << "nobody said anything";
  plan.set_outcome(to_message(grasp::PlanOutcome::kUngraspable));
  EXPECT_EQ(outcome_of(plan), grasp::PlanOutcome::kUngraspable);
  plan.add_grasps();
  EXPECT_THROW(outcome_of(plan), geometry::InputError);
  plan.set_outcome(to_message(grasp::PlanOutcome::kGraspable));
  EXPECT_EQ(outcome_of(plan), grasp::PlanOutcome::kGraspable);
  plan.clear_grasps();
  EXPECT_THROW(outcome_of(plan), geometry::InputError);
  plan.set_outcome(static_cast<msgs::GraspPlan::Outcome>(3));
  EXPECT_THAT([&] { outcome_of(plan); },
              ThrowsMessage<geometry::InputError>(HasSubstr("an outcome that is unknown (3)")));
}

// An enum on the wire may have any number.
TEST(MessageEnums, UnknownValuesComeThroughTheWire) {
  msgs::CycleState state;
  state.set_phase(static_cast<msgs::CycleState::Phase>(42));
  msgs::CycleState received;
  ASSERT_TRUE(received.ParseFromString(state.SerializeAsString()));
  EXPECT_THROW(from_message(received.phase()), geometry::InputError);
}

}  // namespace
}  // namespace prehend::convert
