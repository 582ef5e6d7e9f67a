// Groups, namespaces, hosts, processes and start order of launch files.

#include <gmock/gmock.h>

#include "prehend/launch/process_plan.h"
#include "tests/launch/launch_file_fixture.h"

namespace prehend::launch {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

using LaunchGroups = LaunchFileTest;

TEST_F(LaunchGroups, NamespacesNestAndPrefixNamesAndRemaps) {
  write("camera.yaml",
        "nodes:\n  - {node: report, name: camera}\n"
        "  - {node: simulation, remap: {/a: /b, /c: //d, /e: /clock}, after: [camera]}\n");
  const LaunchGraph graph = load(R"(
groups:
  - namespace: /left
    include: [{file: camera.yaml, namespace: /wrist}]
    nodes: [{node: report, name: filter, after: [wrist_camera]}]
nodes: [{node: report, name: camera}]
)");
  ASSERT_EQ(graph.nodes.size(), 4u);
  EXPECT_EQ(graph.nodes[0].name, "left_wrist_camera");
  EXPECT_EQ(graph.nodes[0].name_space, "/left/wrist");
  EXPECT_THAT(graph.nodes[1].remaps,
              ElementsAre(Pair("/a", "/left/wrist/b"), Pair("/c", "/d"), Pair("/e", "/clock")));
  EXPECT_THAT(graph.nodes[1].after, ElementsAre("left_wrist_camera"));  // the innermost one
  EXPECT_THAT(graph.nodes[2].after, ElementsAre("left_wrist_camera"));
  EXPECT_EQ(graph.nodes[3].name, "camera");
  EXPECT_THAT(node_options(graph.nodes[0], ""),
              ElementsAre("--name", "left_wrist_camera", "--namespace", "/left/wrist"));
  EXPECT_THAT(error_of("nodes:\n  - {node: report, namespace: left}"),
              AllOf(HasSubstr("a.yaml:2"), HasSubstr("begin with '/'")));
  EXPECT_THAT(error_of("nodes: [{node: report, namespace: /a//b}]"), HasSubstr("/a//b"));
}

TEST_F(LaunchGroups, GroupsHandDownTheirSettingsUnlessSwitchedOff) {
  const LaunchGraph graph = load(R"(
arguments: {off: {default: false, type: bool}}
environment: {A: "1", B: "1"}
groups:
  - environment: {B: "2"}
    clock: simulated
    cpu_affinity: 0
    nice: 4
    nodes: [{node: report}, {node: simulation, environment: {B: "3"}, cpu_affinity: [], nice: 0}]
  - {if: $(off), nodes: [{node: test_other}]}
)");
  ASSERT_EQ(graph.nodes.size(), 2u);
  EXPECT_THAT(graph.nodes[0].environment, ElementsAre(Pair("A", "1"), Pair("B", "2")));
  EXPECT_THAT(graph.nodes[0].cpu_affinity, ElementsAre(0));
  EXPECT_EQ(graph.nodes[0].clock, "simulated");
  EXPECT_EQ(graph.nodes[0].nice, 4);
  EXPECT_EQ(graph.nodes[1].nice, 0);
  EXPECT_THAT(graph.nodes[1].environment, ElementsAre(Pair("A", "1"), Pair("B", "3")));
  EXPECT_THAT(graph.nodes[1].cpu_affinity, ElementsAre());
  EXPECT_THAT(error_of("groups:\n  - {nmespace: /a}\n"),
              AllOf(HasSubstr("a.yaml:2"), HasSubstr("\"namespace\"")));
}

TEST_F(LaunchGroups, ComposedNodesShareAProcess) {
  const std::string text = R"(
arguments: {composed: {default: true, type: bool}}
groups:
  - compose: {name: prediction, if: $(composed)}
    nodes:
      - {node: simulation, respawn: true, parameters: {x: "1"}}
      - {node: grasp_planning, respawn: true, after: [report]}
nodes: [{node: report}]
)";
  const LaunchGraph graph = load(text);
  const auto processes = processes_of(graph, "");
  ASSERT_EQ(processes.size(), 2u);
  EXPECT_EQ(processes[0].name, "prediction");
  EXPECT_TRUE(processes[0].respawn.wanted);
  EXPECT_THAT(processes[0].after, ElementsAre("report"));
  EXPECT_THAT(
      processes[0].command,
      ElementsAre((folder_ / "bin/container").string(), "--", "simulation", "--name", "simulation",
                  "--param", "x:=1", "--", "grasp_planning", "--name", "grasp_planning"));
  const LaunchGraph apart = load(text, {"composed:=false"});
  EXPECT_EQ(processes_of(apart, "").size(), 3u);
}

TEST_F(LaunchGroups, ContradictionsWithinAProcessAreNamedWithBothPlaces) {
  const std::string first = "nodes:\n  - {node: simulation, compose: p}\n";
  for (const char* more :
       {"required: true", "respawn: true", "environment: {A: b}", "cpu_affinity: [0]", "nice: 3"}) {
    const std::string key = std::string(more).substr(0, std::string(more).find(':'));
    EXPECT_THAT(error_of(first + "  - {node: report, compose: p, " + more + "}\n"),
                AllOf(HasSubstr("a.yaml:3"), HasSubstr("a.yaml:2"), HasSubstr("\"" + key + "\"")));
  }
  EXPECT_THAT(error_of("nodes: [{node: report, compose: report}]"), HasSubstr("another name"));
  EXPECT_THAT(error_of("nodes: [{node: report, compose: {nam: p}}]"), HasSubstr("\"name\""));
}

TEST_F(LaunchGroups, StartOrdersInACircleAreNamed) {
  EXPECT_THAT(error_of("nodes:\n  - {node: report, name: a, after: [b]}\n"
                       "  - {node: report, name: b, after: [c]}\n"
                       "  - {node: report, name: c, after: [a]}\n"),
              AllOf(HasSubstr("a.yaml:4"), HasSubstr("a after b after c after a")));
  EXPECT_THAT(error_of("nodes: [{node: report, after: [report]}]"), HasSubstr("after itself"));
  EXPECT_THAT(error_of("nodes: [{node: report, after: [repotr]}]"), HasSubstr("\"report\""));
  EXPECT_THAT(error_of("nodes: [{node: report, compose: p, after: [simulation]}, "
                       "{node: simulation, compose: p}]"),
              HasSubstr("both are in the process"));
  // What is switched off is not waited for.
  EXPECT_THAT(load("nodes: [{node: report, after: [simulation]}, {node: simulation, if: false}]")
                  .nodes[0]
                  .after,
              ElementsAre());
}

TEST_F(LaunchGroups, HostsShareOutTheNodes) {
  const LaunchGraph graph = load(R"(
hosts: {cell: {address: 127.0.0.1}, arm: {address: 127.0.0.2}}
registry_host: arm
groups: [{host: cell, nodes: [{node: report}]}]
nodes: [{node: simulation}]
)");
  EXPECT_EQ(graph.nodes[1].host, "arm");  // that of the registry, when nothing is said
  const auto processes = processes_of(graph, "cell");
  ASSERT_EQ(processes.size(), 1u);
  EXPECT_THAT(processes[0].command, ElementsAre((folder_ / "bin/report").string(), "--name",
                                                "report", "--bind", "127.0.0.1"));
  EXPECT_THAT(error_of("hosts: {a: {address: 1.2.3.4}}\nnodes:\n  - {node: report, host: b}\n"),
              AllOf(HasSubstr("a.yaml:3"), HasSubstr("unknown host \"b\"")));
  EXPECT_THAT(error_of("nodes: [{node: report, host: b}]"), HasSubstr("has no hosts"));
  EXPECT_THAT(error_of("hosts: {a: {adress: 1.2.3.4}}\nnodes: [{node: report}]"),
              HasSubstr("\"address\""));
  EXPECT_THAT(error_of("hosts: {a: {address: 'tcp://1.2.3.4'}}\nnodes: [{node: report}]"),
              HasSubstr("without tcp://"));
  EXPECT_THAT(error_of("hosts: {a: {address: h}}\nregistry_host: b\nnodes: [{node: report}]"),
              HasSubstr("registry_host b is not among the hosts"));
  write("b.yaml", "hosts: {a: {address: h}}\nnodes: [{node: report}]\n");
  EXPECT_THAT(error_of("include: [{file: b.yaml}]"), HasSubstr("for the launched file"));
}

TEST_F(LaunchGroups, CpusAndDelaysAreChecked) {
  EXPECT_THAT(error_of("nodes:\n  - node: report\n    cpu_affinity: [x]\n"),
              AllOf(HasSubstr("a.yaml:3"), HasSubstr("CPU numbers like [0, 1]")));
  for (const char* bad : {"-1", "20", "2.5", "x", "nan"}) {
    EXPECT_THAT(error_of(std::string("nodes:\n  - node: report\n    nice: ") + bad + "\n"),
                AllOf(HasSubstr("a.yaml:3"), HasSubstr("nice")));
  }
  const LaunchGraph graph = load("nodes: [{node: report, cpu_affinity: [1023]}]");
  EXPECT_THROW(processes_of(graph, ""), LaunchError);
  const auto respawn = [this](const std::string& text) {
    return error_of("nodes: [{node: report, respawn: " + text + "}]");
  };
  EXPECT_EQ(respawn("{first_delay: 0.1, longest_delay: 2}"), "no error");
  EXPECT_THAT(respawn("{first_delay: -1}"), HasSubstr("first_delay [s] must be a number from 0"));
  EXPECT_THAT(respawn("{first_delay: soon}"), HasSubstr("\"soon\""));
  EXPECT_THAT(respawn("{first_delay: 0}"), HasSubstr("at least 0.05 s"));
  EXPECT_THAT(respawn("{first_delay: 5, longest_delay: 2}"), HasSubstr("shorter"));
  EXPECT_THAT(respawn("{frist_delay: 5}"), HasSubstr("\"first_delay\""));
}

TEST_F(LaunchGroups, MissingArgumentsMayStayOpenForAChecker) {
  const std::string path = write("a.yaml",
                                 "arguments: {bag: {description: a file}, n: {type: int}}\n"
                                 "nodes: [{node: report, parameters: {file: $(bag), n: $(n)}}]\n");
  const LaunchGraph graph =
      load_launch_file(path, {}, (folder_ / "bin").string(), Missing::kLeaveOpen);
  EXPECT_THAT(graph.missing_arguments, ElementsAre("bag", "n"));
  EXPECT_TRUE(is_open(graph.nodes[0].parameters.at("file")));
  EXPECT_EQ(graph.nodes[0].parameter_places.at("n").substr(
                graph.nodes[0].parameter_places.at("n").size() - 8),
            "a.yaml:2");
}

}  // namespace
}  // namespace prehend::launch
