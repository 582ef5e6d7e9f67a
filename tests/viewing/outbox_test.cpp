#include "prehend/viewing/outbox.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace prehend::viewing {
namespace {

using Kind = Outbox::Kind;
using namespace std::chrono_literals;

constexpr std::size_t kLimit = 10000;

Outbox::Frame frame(Kind kind, std::uint32_t subscription, std::size_t size,
                    const std::string& sender = "") {
  Outbox::Frame result;
  result.kind = kind;
  result.subscription = subscription;
  result.sender = sender;
  result.payload = std::make_shared<const std::string>(size, 'x');
  return result;
}

TEST(Outbox, OldStreamsGiveWayAndAreCounted) {
  Outbox outbox(kLimit);
  outbox.push(frame(Kind::kWord, 0, 10));
  for (int i = 0; i < 100; ++i) outbox.push(frame(Kind::kStream, 1, 1000));
  EXPECT_LE(outbox.bytes(), kLimit);
  EXPECT_EQ(outbox.pop({})->kind, Kind::kWord) << "words stay";
  std::size_t left = 0;
  while (outbox.pop({})) ++left;
  EXPECT_EQ(outbox.dropped() + left, 100u);
  EXPECT_EQ(outbox.bytes(), 0u);
}

TEST(Outbox, LatchedMessagesAreSupersededBySendersOwnOnly) {
  Outbox outbox(kLimit);
  for (int i = 0; i < 100; ++i) {
    outbox.push(frame(Kind::kLatched, 1, 1000 + static_cast<std::size_t>(i), "a"));
  }
  outbox.push(frame(Kind::kLatched, 1, 3000, "b"));
  EXPECT_EQ(outbox.dropped(), 0u);
  bool newest_of_a = false, b = false;
  while (const auto next = outbox.pop({})) {
    newest_of_a = newest_of_a || next->payload->size() == 1099;
    b = b || next->sender == "b";
  }
  EXPECT_TRUE(newest_of_a);
  EXPECT_TRUE(b);
}

// The plans of six objects were one another's successors: a viewer that asked for much saw two of
// them.
TEST(Outbox, AsManyLatchedMessagesStayAsTheirChannelKeeps) {
  Outbox outbox(kLimit);
  for (int i = 0; i < 20; ++i) {
    auto message = frame(Kind::kLatched, 1, 3000 + static_cast<std::size_t>(i), "a");
    message.latched = 6;
    outbox.push(message);
  }
  std::vector<std::size_t> sizes;
  while (const auto next = outbox.pop({})) sizes.push_back(next->payload->size());
  EXPECT_EQ(sizes, (std::vector<std::size_t>{3014, 3015, 3016, 3017, 3018, 3019}));
}

TEST(Outbox, OneMessageMayBeLargerThanAllThatMayWait) {
  Outbox outbox(kLimit);
  outbox.push(frame(Kind::kStream, 1, 3 * kLimit));
  EXPECT_EQ(outbox.pop({})->payload->size(), 3 * kLimit);
  outbox.push(frame(Kind::kWord, 0, 1));
  outbox.push(frame(Kind::kStream, 1, 3 * kLimit));
  EXPECT_EQ(outbox.dropped(), 1u);
}

TEST(Outbox, WordsWithoutEndOverflow) {
  Outbox outbox(kLimit);
  for (int i = 0; i < 30; ++i) outbox.push(frame(Kind::kWord, 0, 1000));
  EXPECT_FALSE(outbox.overflowed());
  for (int i = 0; i < 60; ++i) outbox.push(frame(Kind::kWord, 0, 1000));
  EXPECT_TRUE(outbox.overflowed());
}

TEST(Outbox, TheTimeIsToldFirstAndOnce) {
  Outbox outbox(kLimit);
  outbox.push(frame(Kind::kWord, 0, 1));
  outbox.set_time(1);
  outbox.set_time(2);
  const auto first = outbox.pop({});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->payload->at(0), 2);  // the opcode
  EXPECT_EQ(first->payload->at(1), 2);
  EXPECT_TRUE(outbox.pop({})->is_text);
  EXPECT_FALSE(outbox.pop({}));
}

TEST(Outbox, WhatIsStaleGivesWayToWhatIsNew) {
  Outbox outbox(kLimit);
  const Outbox::Time begin{};
  for (int i = 0; i < 3; ++i) {
    auto message = frame(Kind::kStream, 1, 10);
    message.since = begin + i * 10ms;
    outbox.push(message);
  }
  auto other = frame(Kind::kStream, 2, 20);
  other.since = begin;
  outbox.push(other);
  const auto late = begin + 10s;
  EXPECT_EQ(outbox.pop(late)->subscription, 1u) << "the newest of its channel comes, however old";
  EXPECT_EQ(outbox.pop(late)->subscription, 2u);
  EXPECT_FALSE(outbox.pop(late));
  EXPECT_EQ(outbox.dropped(), 2u);
}

TEST(Outbox, ForgetsAnEndedSubscription) {
  Outbox outbox(kLimit);
  outbox.push(frame(Kind::kStream, 1, 10));
  outbox.push(frame(Kind::kLatched, 1, 10));
  outbox.push(frame(Kind::kStream, 2, 10));
  outbox.forget(1);
  EXPECT_EQ(outbox.pop({})->subscription, 2u);
  EXPECT_TRUE(outbox.empty());
  EXPECT_EQ(outbox.bytes(), 0u);
}

TEST(Outbox, CountsEveryByteAndMessageWhateverComes) {
  std::mt19937 random(1);
  for (int run = 0; run < 200; ++run) {
    Outbox outbox(kLimit);
    std::uint64_t streams = 0, popped = 0;
    for (int i = 0; i < 200; ++i) {
      const auto kind = static_cast<Kind>(random() % 3);
      if (random() % 3 == 0) {
        if (const auto next = outbox.pop({})) popped += next->kind == Kind::kStream ? 1 : 0;
      } else if (kind == Kind::kWord && random() % 4 != 0) {
        outbox.set_time(random());
      } else {
        outbox.push(frame(kind, random() % 3, random() % 4000, std::string(1, 'a' + random() % 2)));
        streams += kind == Kind::kStream ? 1 : 0;
      }
    }
    while (const auto next = outbox.pop({})) popped += next->kind == Kind::kStream ? 1 : 0;
    EXPECT_EQ(streams, popped + outbox.dropped());
    EXPECT_EQ(outbox.bytes(), 0u);
    EXPECT_TRUE(outbox.empty());
  }
}

}  // namespace
}  // namespace prehend::viewing
