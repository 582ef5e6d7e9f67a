#include "prehend/viewing/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace prehend::viewing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Access, OnThisMachineTheOwnPageAndProgramsMayLook) {
  const AccessRules rules;
  EXPECT_THAT(objection(rules, {"127.0.0.1:8765", {}, "/"}), IsEmpty());
  EXPECT_THAT(objection(rules, {"localhost:8765", "http://localhost:8765", "/"}), IsEmpty());
  EXPECT_THAT(objection(rules, {"[::1]:8765", "http://[::1]:8765", "/"}), IsEmpty());
}

TEST(Access, PagesOfOthersMayNot) {
  AccessRules rules;
  EXPECT_THAT(objection(rules, {"127.0.0.1:8765", "https://evil.example", "/"}),
              HasSubstr("allowed_origins:=[https://evil.example]"));
  EXPECT_THAT(objection(rules, {"127.0.0.1:8765", "null", "/"}), HasSubstr("'null'"));
  EXPECT_THAT(objection(rules, {"127.0.0.1:8765", "http://127.0.0.1:9999", "/"}),
              HasSubstr("9999"));
  // A name of the attacker's that leads to this machine: then both headers agree.
  EXPECT_THAT(objection(rules, {"evil.example:8765", "http://evil.example:8765", "/"}),
              HasSubstr("no name of it"));
  EXPECT_THAT(objection(rules, {"127.0.0.1.evil.example", {}, "/"}), HasSubstr("no name of it"));
  rules.allowed_origins = {"https://app.foxglove.dev"};
  EXPECT_THAT(objection(rules, {"127.0.0.1:8765", "https://app.foxglove.dev", "/"}), IsEmpty());
  EXPECT_THAT(objection(rules, {"127.0.0.1:8765", "https://app.foxglove.dev.x", "/"}),
              HasSubstr("may not"));
}

TEST(Access, BeyondThisMachineTheTokenIsNeeded) {
  AccessRules rules{false, "secret+1", {}};
  const std::string host = "robot.lan:8765", origin = "http://robot.lan:8765";
  EXPECT_THAT(objection(rules, {host, origin, "/"}), HasSubstr("token"));
  EXPECT_THAT(objection(rules, {host, origin, "/?token=secret"}), HasSubstr("token"));
  EXPECT_THAT(objection(rules, {host, origin, "/?token=secret%2b1"}), IsEmpty());
  EXPECT_THAT(objection(rules, {host, origin, "/?a=b&token=secret+1"}), IsEmpty());
  EXPECT_THAT(objection(rules, {host, "https://evil.example", "/?token=secret+1"}),
              HasSubstr("may not"));
}

TEST(Access, DamagedPercentsAreNoText) {
  EXPECT_EQ(percent_decoded("a%20b"), "a b");
  EXPECT_FALSE(percent_decoded("%"));
  EXPECT_FALSE(percent_decoded("%4"));
  EXPECT_FALSE(percent_decoded("%zz"));
  EXPECT_FALSE(percent_decoded("a%00"));
}

}  // namespace
}  // namespace prehend::viewing
