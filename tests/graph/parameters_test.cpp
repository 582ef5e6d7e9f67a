#include <cmath>
#include <limits>

#include "prehend/graph/introspection.h"
#include "prehend/graph/parameter_list.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

using Numbers = std::vector<double>;
using Texts = std::vector<std::string>;

std::string refusal_of(const std::function<void()>& throwing) {
  try {
    throwing();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(ParameterList, EveryListIsReadBack) {
  for (const Texts& items : {Texts{}, Texts{""}, Texts{"a"}, Texts{"left", "a, b", " x", "]", "\""},
                             Texts{"\\", "\\\"", "a b", "é"}}) {
    EXPECT_EQ(split_list(join_list(items)), items) << join_list(items);
  }
  EXPECT_EQ(join_list({"left", "a, b"}), "[left, \"a, b\"]");
  EXPECT_EQ(split_list(" [ 1 ,2.5,\t-3e2 ] "), (Texts{"1", "2.5", "-3e2"}));
}

TEST(ParameterList, OtherTextsAreRefused) {
  for (const char* bad : {"", " ", "1", "[", "]", "[1", "1]", "[1,]", "[,1]", "[,]", "[1 2] x",
                          "[[1]]", "[1]]", "[\"a]", "[\"a\"b]", "[\"\\", "[a\"b\"]", "[1][2]"}) {
    EXPECT_THROW(split_list(bad), std::invalid_argument) << bad;
  }
  EXPECT_THROW(split_list(std::string(1 << 20, '[')), std::invalid_argument);
}

class ParameterValues : public GraphTest {};

TEST_F(ParameterValues, ListsAreGivenReadAndSet) {
  NodeOptions given = options("node");
  given.parameters = {{"gains", "[1, 2.5]"}, {"joints", "[left, \"a, b\"]"}};
  Node node(given);
  EXPECT_EQ(node.declare_parameter<Numbers>({.name = "gains", .minimum = 0, .maximum = 10}),
            (Numbers{1, 2.5}));
  EXPECT_EQ(node.declare_parameter<Texts>({.name = "joints"}), (Texts{"left", "a, b"}));
  EXPECT_EQ(node.declare_parameter<Numbers>({.name = "none"}), Numbers{});
  node.declare_parameter<Texts>({.name = "sides", .choices = {"left", "right"}});
  node.set_parameter("gains", "[]");
  EXPECT_EQ(node.parameter<Numbers>("gains"), Numbers{});
  node.set_parameter("gains", "[0.1, 1e-300, 10]");
  EXPECT_EQ(refusal_of([&] { node.set_parameter("gains", "[1, -2]"); }),
            "parameter 'gains': '[1, -2]' must be at least 0 (item 2)");
  EXPECT_EQ(refusal_of([&] { node.set_parameter("gains", "[1, x]"); }),
            "parameter 'gains': '[1, x]' must be a list of numbers (item 2 is none)");
  EXPECT_EQ(refusal_of([&] { node.set_parameter("gains", "1"); }),
            "parameter 'gains': '1' must be a list between brackets, as in [1, 2]");
  EXPECT_EQ(refusal_of([&] { node.set_parameter("sides", "[left, up]"); }),
            "parameter 'sides': '[left, up]' must be one of: left, right (item 2)");
  for (const char* bad : {"[nan]", "[inf]", "[1e999]", "[0x1]", "[1,,2]", "[]]"}) {
    EXPECT_THROW(node.set_parameter("gains", bad), std::invalid_argument) << bad;
  }
  EXPECT_EQ(node.parameter<Numbers>("gains"), (Numbers{0.1, 1e-300, 10}));
  Introspection look(endpoint);
  EXPECT_EQ(to_text(look.set_parameter("node", "gains", "[3,4]").value()), "[3, 4]");
  EXPECT_EQ(to_text(look.parameter("node", "joints").value()), "[left, \"a, b\"]");
  EXPECT_EQ(to_text(look.parameter("node", "none").value()), "[]");
}

TEST_F(ParameterValues, HostileTextsAreRefused) {
  Node node(options("node"));
  node.declare_parameter<int>({.name = "narrow"});
  node.declare_parameter<std::int64_t>({.name = "wide"});
  node.declare_parameter<double>({.name = "number"});
  node.declare_parameter<bool>({.name = "flag"});
  node.declare_parameter<std::string>({.name = "text"});
  EXPECT_EQ(refusal_of([&] { node.set_parameter("narrow", "2147483648"); }),
            "parameter 'narrow': '2147483648' must be from -2147483648 to 2147483647");
  node.set_parameter("narrow", "-2147483648");
  EXPECT_EQ(node.parameter<int>("narrow"), std::numeric_limits<int>::min());
  node.set_parameter("wide", "9223372036854775807");
  EXPECT_THROW(node.set_parameter("wide", "9223372036854775808"), std::invalid_argument);
  const std::string with_zero("1\0", 2);
  for (const std::string& bad :
       {std::string(), std::string(" "), std::string("1 "), with_zero, std::string("nan"),
        std::string("-inf"), std::string("1e400"), std::string("1,5"), std::string("0x10"),
        std::string("--1"), std::string("\xff"), std::string(1 << 20, '9')}) {
    for (const char* name : {"narrow", "wide", "number", "flag"}) {
      EXPECT_THROW(node.set_parameter(name, bad), std::invalid_argument) << name << " " << bad;
    }
  }
  // A text that is no UTF-8 could not be sent to those who ask for it.
  for (const char* bad :
       {"\xff", "\xc3", "\xc0\x80", "\xed\xa0\x80", "\xf5\x80\x80\x80", "a\x80"}) {
    EXPECT_THROW(node.set_parameter("text", bad), std::invalid_argument);
  }
  const std::string good = "é € 😀 \n";
  node.set_parameter("text", good);
  EXPECT_EQ(node.parameter<std::string>("text"), good);
  EXPECT_LT(refusal_of([&] { node.set_parameter("number", std::string(5000, 'x')); }).size(), 300u);
}

TEST_F(ParameterValues, ValidationRefusesWithItsReason) {
  const auto is_odd = [](const int& n) { return std::string(n % 2 ? "" : "it must be odd"); };
  NodeOptions given = options("given");
  given.parameters = {{"odd", "4"}};
  given.parameter_sources = {{"odd", "robot.yaml:7"}};
  Node of_file(given);
  EXPECT_EQ(
      refusal_of([&] {
        of_file.declare_parameter<int>({.name = "odd", .default_value = 1, .validate = is_odd});
      }),
      "robot.yaml:7: parameter 'odd': '4' is refused: it must be odd");
  Node node(options("node"));
  std::atomic<int> changes = 0;
  node.declare_parameter<int>(
      {.name = "size", .default_value = 3, .validate = is_odd, .on_change = [&](const int&) {
         ++changes;
       }});
  node.declare_parameter<int>({.name = "thrower", .validate = [&](const int& n) -> std::string {
                                 if (n == 1) throw std::runtime_error("not one");
                                 if (n == 2) throw 2;
                                 // No lock is held: the others can be read here.
                                 return node.parameter<int>("size") > 0 ? "" : "never";
                               }});
  EXPECT_EQ(refusal_of([&] { node.set_parameter("thrower", "1"); }),
            "parameter 'thrower': '1' is refused: not one");
  EXPECT_THROW(node.set_parameter("thrower", "2"), std::invalid_argument);
  node.set_parameter("thrower", "3");
  Introspection look(endpoint, 500ms);
  // Validation is user code, and nobody runs the callbacks yet.
  EXPECT_NE(refusal_of([&] { look.set_parameter("node", "size", "5"); }).find("does not answer"),
            std::string::npos);
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return changes == 1; }));
  Introspection patient(endpoint, 10s);
  EXPECT_EQ(refusal_of([&] { patient.set_parameter("node", "size", "6"); }),
            "node 'node': parameter 'size': '6' is refused: it must be odd");
  EXPECT_EQ(to_text(patient.set_parameter("node", "size", "7").value()), "7");
  EXPECT_TRUE(eventually([&] { return changes == 2; }));
}

TEST_F(ParameterValues, SeveralAreSetAllOrNone) {
  Node node(options("node")), watcher(options("watcher"));
  std::mutex mutex;
  std::vector<std::string> events;
  auto subscription = watcher.subscribe<msgs::graph::ParameterEvent>(
      "/parameter_events", QoS::queue(100), [&](const auto& event) {
        std::string text = event->node() + ":";
        for (const auto& changed : event->changed()) {
          text += " " + changed.name() + "=" + to_text(changed.value());
        }
        const std::lock_guard lock(mutex);
        events.push_back(text);
      });
  watcher.spin_in_background();
  node.declare_parameter<double>({.name = "low", .default_value = 1, .maximum = 5});
  node.declare_parameter<double>({.name = "high", .default_value = 2, .maximum = 5});
  node.set_parameters({{"low", "3"}, {"high", "4"}});
  EXPECT_EQ(refusal_of([&] {
              node.set_parameters({{"high", "4.5"}, {"low", "6"}});
            }),
            "parameter 'low': '6' must be at most 5");
  EXPECT_EQ(refusal_of([&] {
              node.set_parameters({{"high", "4.5"}, {"lwo", "3"}});
            }),
            "no parameter 'lwo'; did you mean \"low\"?");
  EXPECT_EQ(node.parameter<double>("high"), 4);
  node.set_parameters({});
  Introspection look(endpoint);
  EXPECT_EQ(look.set_parameters("node", {{"low", "0.5"}, {"high", "1.5"}}).size(), 2u);
  EXPECT_THROW(look.set_parameters("node", {{"low", "0"}, {"high", "9"}}), std::runtime_error);
  EXPECT_EQ(node.parameter<double>("low"), 0.5);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return events.size() == 2;
  }));
  EXPECT_EQ(events[0], "node: high=4 low=3");
  EXPECT_EQ(events[1], "node: high=1.5 low=0.5");
}

TEST_F(ParameterValues, ReadOnlyOnesAreSetAtTheStartOnly) {
  NodeOptions given = options("node");
  given.parameters = {{"port", "5"}};
  Node node(given);
  EXPECT_EQ(node.declare_parameter<int>({.name = "port", .default_value = 1, .read_only = true}),
            5);
  EXPECT_NE(refusal_of([&] { node.set_parameter("port", "6"); }).find("'port' is read-only"),
            std::string::npos);
  Introspection look(endpoint);
  EXPECT_TRUE(look.parameter("node", "port").read_only());
  EXPECT_THROW(look.set_parameter("node", "port", "6"), std::runtime_error);
  EXPECT_EQ(node.parameter<int>("port"), 5);
}

TEST_F(ParameterValues, UnknownOnesOfAFileAreNamedWithTheirLine) {
  NodeOptions given = options("node");
  given.parameters = {{"orientatoins", "3"}};
  given.parameter_sources = {{"orientatoins", "robot.yaml:12"}};
  Node node(given);
  node.declare_parameter<int>({.name = "orientations", .default_value = 5});
  EXPECT_EQ(refusal_of([&] { node.spin(); }),
            "robot.yaml:12: unknown parameter 'orientatoins'; did you mean \"orientations\"?");
}

}  // namespace
}  // namespace prehend::graph
