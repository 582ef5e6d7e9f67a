// What would grow while it is parsed is refused before; what is no JSON is left to its reader.

#include "prehend/text/json_size.h"

#include <string>

#include <gmock/gmock.h>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

using testing::HasSubstr;

std::string json_refusal_of(const std::string& text) {
  try {
    refuse_json_bomb(text, "a.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(JsonSize, CountsLevelsValuesAndKeys) {
  EXPECT_EQ(json_refusal_of(std::string(32, '[') + std::string(32, ']')), "");
  EXPECT_THAT(json_refusal_of(std::string(33, '[')), HasSubstr("a.json is nested deeper than 32"));
  EXPECT_THAT(json_refusal_of(R"({"a": 1, "b": {"a": 1}, "a": 2})"),
              HasSubstr("the key 'a' is there twice"));
  EXPECT_EQ(json_refusal_of(R"([{"a": 1}, {"a": 1}, "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["])"), "");
  std::string values = "[0", keys = "{\"k\": 0";
  for (int i = 0; i < 2000000; ++i) values += ",0";
  for (int i = 0; i < 10000; ++i) keys += ", \"" + std::to_string(i) + "\": 0";
  EXPECT_THAT(json_refusal_of(values + "]"), HasSubstr("more than two million values"));
  EXPECT_THAT(json_refusal_of(keys + "}"), HasSubstr("more than 10000 keys"));
  EXPECT_EQ(json_refusal_of("no JSON"), "");
  EXPECT_EQ(json_refusal_of(""), "");
}

}  // namespace
}  // namespace prehend::text
