#include "prehend/text/json.h"

#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::text {
namespace {

TEST(Json, KeepsTheOrderOfMembers) {
  const Json json = Json::object().set("b", 1).set("a", Json::array().add(true).add("x"));
  EXPECT_EQ(json.text(), R"({"b":1,"a":[true,"x"]})");
  EXPECT_EQ(json.pretty(), "{\n \"b\": 1,\n \"a\": [\n  true,\n  \"x\"\n ]\n}\n");
}

TEST(Json, SaysWhatTextAndNumbersCannot) {
  EXPECT_EQ(Json("a\"\\\n\x01").text(), R"("a\"\\\n\u0001")");
  EXPECT_EQ(Json("\xff\xc3").text(), "\"\xef\xbf\xbd\xef\xbf\xbd\"");
  EXPECT_EQ(Json(std::numeric_limits<double>::quiet_NaN()).text(), "null");
  EXPECT_EQ(Json(std::numeric_limits<double>::infinity()).text(), "null");
  EXPECT_EQ(Json(0.1).text(), "0.1");
  EXPECT_EQ(Json(std::numeric_limits<std::int64_t>::max()).text(), "9223372036854775807");
}

TEST(Json, MembersBelongToObjects) {
  EXPECT_THROW(Json::array().set("a", 1), std::logic_error);
  EXPECT_THROW(Json::object().add(1), std::logic_error);
  EXPECT_THROW(Json(1).add(1), std::logic_error);
}

}  // namespace
}  // namespace prehend::text
