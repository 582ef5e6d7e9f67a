// prehend node, topic list and info, log, graph: what a graph is and says, for people and programs.

#include <gmock/gmock.h>

#include <signal.h>
#include <unistd.h>

#include <regex>
#include <sstream>

#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class Look : public Command {
 protected:
  // True once the node has reported its traffic: the first report may be of before the first
  // message.
  bool reported() {
    return eventually([&] {
      const auto nodes = parsed(run({"node", "list", "--json"}).output);
      const auto node = element(nodes, "name", "arm");
      const auto statistics = member(node, "statistics");
      const auto topics = statistics.struct_value().fields().find("topics");
      if (topics == statistics.struct_value().fields().end()) return false;
      for (const auto& topic : topics->second.list_value().values()) {
        if (text_of(topic, "topic") == "/camera/stereo" && text_of(topic, "messages") != "0") {
          return true;
        }
      }
      return false;
    });
  }
};

TEST_F(Look, NodeListSaysStatusAndIsJsonToo) {
  node_.report(graph::Health::kWarning, "no \"table\"");
  EXPECT_THAT(run({"node", "list"}).output, ContainsRegex("arm +arm +[0-9]+ +.* +warning: no"));
  const auto node = element(parsed(run({"node", "list", "--json"}).output), "name", "arm");
  EXPECT_EQ(text_of(node, "status"), "warning");
  EXPECT_EQ(text_of(node, "status_text"), "warning: no \"table\"");
  EXPECT_EQ(member(node, "pid").number_value(), ::getpid());
}

TEST_F(Look, StoppedNodeIsStale) {
  ChildProgram other("prehend", {"log", "--level", "error"}, scratch_.path("log.txt"),
                     registry_.endpoint());
  ASSERT_TRUE(eventually([&] {
    return run({"node", "list"}).output.find("log_") != std::string::npos;
  }));
  ::kill(other.pid(), SIGSTOP);
  const Result list = run({"node", "list"});
  EXPECT_THAT(list.output, ContainsRegex("log_[0-9]+ .*stale"));
  EXPECT_THAT(list.output, ContainsRegex("arm .*ok"));
  const Result doctor = run({"doctor"});
  EXPECT_THAT(doctor.output, ContainsRegex("error +node log_[0-9]+: stale"));
  ::kill(other.pid(), SIGCONT);
}

TEST_F(Look, NodeInfoHasTrafficAndOffers) {
  ASSERT_TRUE(reported());
  const Result info = run({"node", "info", "arm"});
  EXPECT_THAT(info.output, AllOf(HasSubstr("MB of memory"), HasSubstr("/count  prehend.msgs.Move"),
                                 HasSubstr("/add_one  prehend.msgs.Clock, prehend.msgs.Clock"),
                                 ContainsRegex("/camera/stereo +latched\\(1\\) +[0-9.]+/s")));
  const auto node = parsed(run({"node", "info", "arm", "--json"}).output);
  const auto camera =
      element(member(member(node, "statistics"), "topics"), "topic", "/camera/stereo");
  EXPECT_GT(std::stod(text_of(camera, "messages")), 0) << "64-bit numbers are text in protobuf";
  EXPECT_TRUE(member(camera, "is_publisher").bool_value());
}

TEST_F(Look, TopicInfoShowsBothEndsAndRates) {
  graph::Node other(node_options("viewer"));
  const auto subscription =
      other.subscribe<msgs::StereoPair>("/camera/stereo", graph::QoS::latest(), [](const auto&) {});
  other.spin_in_background();
  ASSERT_TRUE(eventually([&] {
    return std::regex_search(run({"topic", "info", "/camera/stereo"}).output,
                             std::regex("viewer +latest +[1-9][0-9.]*/s"));
  }));
  const auto topic = parsed(run({"topic", "info", "/camera/stereo", "--json"}).output);
  EXPECT_EQ(text_of(element(member(topic, "publishers"), "node", "arm"), "qos"), "latched(1)");
  const auto viewer = element(member(topic, "subscribers"), "node", "viewer");
  EXPECT_GT(member(member(viewer, "statistics"), "rate").number_value(), 0);
  const Result unknown = run({"topic", "info", "/camera/stero"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean \"/camera/stereo\"?"));
  const auto list = parsed(run({"topic", "list", "--json"}).output);
  EXPECT_EQ(
      member(element(list, "topic", "/gripper/command"), "publishers").list_value().values_size(),
      0);
}

TEST_F(Look, LogShowsKeptLinesInOrderAndFilters) {
  graph::Node other(node_options("other"));
  node_.log_info("first");
  other.log_warning("second");
  node_.log_error("third \"quoted\"");
  ASSERT_TRUE(eventually([&] {
    return run({"log", "--no-follow"}).output.find("third") != std::string::npos;
  }));
  const std::string all = run({"log", "--no-follow"}).output;
  EXPECT_LT(all.find("first"), all.find("second"));
  EXPECT_LT(all.find("second"), all.find("third"));
  const std::string warnings = run({"log", "--no-follow", "-l", "warning"}).output;
  EXPECT_THAT(warnings, AllOf(Not(HasSubstr("first")), HasSubstr("[warning] [other] second")));
  const std::string of_arm =
      run({"log", "--no-follow", "--node", "arm", "--json", "-n", "2"}).output;
  std::istringstream lines(of_arm);
  std::string line;
  std::vector<std::string> texts;
  while (std::getline(lines, line)) texts.push_back(text_of(parsed(line), "text"));
  EXPECT_EQ(texts, (std::vector<std::string>{"first", "third \"quoted\""}));
  EXPECT_THAT(run({"log", "--node", "amr"}).output, HasSubstr("did you mean \"arm\"?"));
}

TEST_F(Look, LogFollowsWhatComes) {
  ChildProgram log("prehend", {"log", "-n", "1"}, scratch_.path("log.txt"), registry_.endpoint());
  ASSERT_TRUE(eventually([&] {
    node_.log_info("it lives");
    return log.output().find("it lives") != std::string::npos;
  }));
  EXPECT_EQ(log.wait(std::chrono::seconds(5)), 0);
}

TEST_F(Look, GraphIsDotWithRatesAndStatus) {
  ASSERT_TRUE(reported());
  const std::string file = scratch_.path("graph.dot");
  EXPECT_EQ(run({"graph", "-o", file}).exit_code, 0);
  const std::string dot = text_of_file(file);
  EXPECT_THAT(
      dot, AllOf(::testing::StartsWith("digraph prehend {"), ::testing::EndsWith("}\n"),
                 HasSubstr("\"node arm\" [shape=box, label=\"arm\", fillcolor=white"),
                 ContainsRegex("\"node arm\" -> \"topic /camera/stereo\" "
                               "\\[label=\"[0-9.]+/s\""),
                 HasSubstr("\"topic /gripper/command\" -> \"node arm\""), Not(HasSubstr("/log"))));
  EXPECT_THAT(run({"graph", "--all"}).output, HasSubstr("\"topic /log\""));
  const auto json = parsed(run({"graph", "--json"}).output);
  element(member(json, "nodes"), "name", "arm");
  element(member(json, "topics"), "name", "/camera/stereo");
  EXPECT_EQ(run({"graph", "-o", "/none/graph.dot"}).exit_code, 1);
}

}  // namespace
}  // namespace prehend::testing
