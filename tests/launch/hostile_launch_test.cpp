// Launch files that nobody means well with: each ends with one line that names file and line.

#include <gmock/gmock.h>

#include <chrono>

#include "prehend/graph/parameter_file.h"
#include "tests/launch/launch_file_fixture.h"

namespace prehend::launch {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class HostileLaunch : public LaunchFileTest {
 protected:
  // One clear line, in a time that shows that nothing was expanded or recursed into.
  void expect_refused(const std::string& text, int line, const std::string& word) {
    const auto start = std::chrono::steady_clock::now();
    const std::string error = error_of(text);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
    EXPECT_THAT(error, AllOf(HasSubstr(word), HasSubstr("a.yaml:" + std::to_string(line) + ":"),
                             Not(HasSubstr("\n"))));
    EXPECT_LT(error.size(), 500u);
  }
};

TEST_F(HostileLaunch, NestingBeyondAllMeasure) {
  for (const char bracket : {'[', '{'}) {
    expect_refused("nodes: " + std::string(500000, bracket), 1, "nested too deep");
  }
  std::string indented;
  for (int i = 0; i < 500; ++i) indented += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  expect_refused(indented, 33, "nested more than 32 deep");
  expect_refused(std::string(100000, '-') + " x\n", 1, "");
  std::string dashes;
  for (int i = 0; i < 100000; ++i) dashes += "- ";
  EXPECT_THAT(error_of(dashes), HasSubstr("a.yaml:1"));
  std::string questions;
  for (int i = 0; i < 100000; ++i) questions += "? ";
  EXPECT_THAT(error_of(questions), HasSubstr("a.yaml:1"));
}

TEST_F(HostileLaunch, AliasesThatGrowExponentially) {
  std::string text = "arguments:\n  a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    text += "  a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last;
    for (int k = 1; k < 10; ++k) text += ", " + last;
    text += "]\n";
  }
  expect_refused(text + "nodes: []\n", 6, "more than 20000 values");
}

TEST_F(HostileLaunch, AnAliasInsideItself) {
  expect_refused("nodes: &a\n  - *a\n", 2, "inside what it is an alias of");
  expect_refused("nodes: [*nobody]\n", 1, "");
}

TEST_F(HostileLaunch, ArgumentsThatGrowExponentially) {
  std::string text = "arguments:\n  a0: {default: xxxxxxxxxxxxxxxx}\n";
  for (int i = 1; i < 40; ++i) {
    const std::string last = "$(a" + std::to_string(i - 1) + ")";
    text += "  a" + std::to_string(i) + ": {default: " + last + last + "}\n";
  }
  expect_refused(text + "nodes: [{node: report}]\n", 15, "64 KiB");
}

TEST_F(HostileLaunch, IncludesThatGrowExponentially) {
  for (char name = 'b'; name < 'z'; ++name) {
    const std::string next = "{file: " + std::string(1, static_cast<char>(name + 1)) + ".yaml}";
    write(std::string(1, name) + ".yaml", "include: [" + next + ", " + next + "]\n");
  }
  write("z.yaml", "arguments: {}\n");
  EXPECT_THAT(error_of("include: [{file: b.yaml}]\n"), HasSubstr("more than 1000 includes"));
}

TEST_F(HostileLaunch, HugeFiles) {
  expect_refused("nodes: [] #" + std::string(std::size_t{1} << 21, 'x'), 1, "larger than 1024 KiB");
  expect_refused("nodes: \"" + std::string(1000000, 'x') + "\"", 1, "must be a list");
  std::string many = "nodes:\n";
  for (int i = 0; i < 6000; ++i) many += "  - {node: report, name: n" + std::to_string(i) + "}\n";
  EXPECT_THAT(error_of(many), ContainsRegex("a.yaml:[0-9]+: more than (1000 nodes|20000 values)"));
}

TEST_F(HostileLaunch, KeysGivenTwice) {
  expect_refused("nodes: []\nclock: wall\nnodes: []\n", 3, "\"nodes\" is already in line 1");
  expect_refused("nodes:\n  - node: report\n    parameters:\n      a: 1\n      a: 2\n", 5,
                 "\"a\" is already in line 4");
  expect_refused("nodes:\n  - {node: report, parameters: {a.b: 1, a: {b: 2}}}\n", 2, "twice");
}

TEST_F(HostileLaunch, BytesThatAreNoText) {
  using std::string_literals::operator""s;
  expect_refused("nodes:\n  - node: report\0\n"s, 2, "control character 0x00");
  expect_refused("nodes:\n  - node: \"a\\0b\"\n", 2, "NUL");
  expect_refused("nodes:\n\t- node: report\n", 2, "a tab indents");
  expect_refused("nodes:\n  - node: \xff\xfe\n", 2, "0xff is not UTF-8");
  expect_refused("nodes: [{node: report}] # \xc3\n", 1, "not UTF-8");
  expect_refused("a: \xed\xa0\x80\n", 1, "not UTF-8");  // a surrogate
  expect_refused(
      "\x7f"
      "ELF\x02\x01",
      1, "control character 0x7f");
  expect_refused("\xef\xbf", 1, "not UTF-8");  // cut short
  EXPECT_EQ(error_of("# größer ≥ 𝄞\nnodes: [{node: report}]\n"), "no error");
}

TEST_F(HostileLaunch, WrongTypesEverywhere) {
  const std::string node = "nodes:\n  - node: report\n    ";
  for (const char* key : {"name", "clock", "namespace", "host", "compose", "required", "if",
                          "parameter_file", "nice"}) {
    EXPECT_THAT(error_of(node + key + ": [1, 2]\n"), HasSubstr("a.yaml:3: ")) << key;
  }
  for (const char* key : {"parameters", "remap", "environment"}) {
    EXPECT_THAT(error_of(node + key + ": [1, 2]\n"), HasSubstr("a.yaml:3: ")) << key;
    EXPECT_THAT(error_of(node + key + ": {/a: [[1]]}\n"), HasSubstr("a.yaml:3: ")) << key;
    EXPECT_THAT(error_of(node + key + ": {[a]: 1}\n"), HasSubstr("a key must be plain text"));
  }
  for (const char* key : {"respawn", "after", "cpu_affinity"}) {
    EXPECT_THAT(error_of(node + key + ": {x: 1}\n"), HasSubstr("a.yaml:3: ")) << key;
    EXPECT_THAT(error_of(node + key + ": [[1]]\n"), HasSubstr("a.yaml:3: ")) << key;
  }
  for (const char* key : {"arguments", "hosts"}) {
    EXPECT_THAT(error_of(std::string(key) + ": [1]\n"), HasSubstr("a.yaml:1: ")) << key;
    EXPECT_THAT(error_of(std::string(key) + ": {a: [1]}\n"), HasSubstr("a.yaml:1: ")) << key;
  }
  for (const char* key : {"include", "groups", "nodes"}) {
    EXPECT_THAT(error_of(std::string(key) + ": {a: 1}\n"), HasSubstr("a.yaml:1: ")) << key;
    EXPECT_THAT(error_of(std::string(key) + ": [[]]\n"), HasSubstr("a.yaml:1: ")) << key;
    EXPECT_THAT(error_of(std::string(key) + ": [~]\n"), HasSubstr("a.yaml:1: ")) << key;
  }
  for (const char* text : {"[]", "x", "1", "~: 1", "!!binary x", "arguments: {a: {type: [int]}}",
                           "arguments: {a: {description: {}}}", "--- {}\n--- {}\n", "%YAML 9\n",
                           "include: [{file: [a]}]", "clock: {}", "log_directory: [a]"}) {
    EXPECT_THAT(error_of(text), AllOf(HasSubstr("a.yaml"), Not(HasSubstr("yaml-cpp")))) << text;
  }
}

TEST_F(HostileLaunch, ParameterFilesAreReadAsStrictly) {
  const auto refusal = [this](const std::string& text) -> std::string {
    try {
      graph::read_parameter_file(write("p.yaml", text));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(refusal("a: {b: 1}\n# end\n"), "no error");
  EXPECT_THAT(refusal("a: 1\na: 2\n"), HasSubstr("p.yaml:2: "));
  EXPECT_EQ(refusal("a:\n  b: [1]\n"), "no error");
  EXPECT_THAT(refusal("a:\n  b: [[1]]\n"), HasSubstr("p.yaml:2: parameter 'a.b' must be"));
  EXPECT_THAT(refusal("a:\n  b: [{c: 1}]\n"), HasSubstr("p.yaml:2: parameter 'a.b' must be"));
  EXPECT_THAT(refusal("a: {b: 1}\na.b: 2\n"),
              HasSubstr("p.yaml:2: parameter 'a.b' is given twice"));
  EXPECT_THAT(refusal("[1]\n"), HasSubstr("p.yaml: must be a mapping"));
}

}  // namespace
}  // namespace prehend::launch
