#include "prehend/launch/launch_file.h"

#include <gmock/gmock.h>

#include "tests/launch/launch_file_fixture.h"

namespace prehend::launch {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

TEST_F(LaunchFileTest, ResolvesEverythingANodeMayHave) {
  write("node.yaml", "speed: 1\n");
  const LaunchGraph graph = load(R"(
arguments:
  scene: {default: demo, type: string, description: what stands there}
  seed: {default: 7, type: int}
clock: simulated
nodes:
  - node: simulation
    name: world
    parameters: {scene: $(root)/config/$(scene).yaml, seed: $(seed), camera: {rate: 5, on: true}}
    parameter_file: node.yaml
    remap: {/camera: /left/camera}
    environment: {OMP_NUM_THREADS: "1"}
    required: true
  - node: report
    clock: wall
    respawn: true
)",
                                 {"scene:=mugs"});
  ASSERT_EQ(graph.nodes.size(), 2u);
  const LaunchNode& world = graph.nodes[0];
  EXPECT_EQ(world.name, "world");
  EXPECT_EQ(world.executable, (folder_ / "bin/simulation").string());
  EXPECT_EQ(world.clock, "simulated");
  EXPECT_THAT(world.parameters, ElementsAre(Pair("camera.on", "true"), Pair("camera.rate", "5"),
                                            Pair("scene", (folder_ / "config/mugs.yaml").string()),
                                            Pair("seed", "7")));
  EXPECT_EQ(world.parameter_file, (folder_ / "launch/node.yaml").string());
  EXPECT_THAT(world.remaps, ElementsAre(Pair("/camera", "/left/camera")));
  EXPECT_THAT(world.environment, ElementsAre(Pair("OMP_NUM_THREADS", "1")));
  EXPECT_TRUE(world.required);
  EXPECT_EQ(graph.nodes[1].name, "report");
  EXPECT_EQ(graph.nodes[1].clock, "wall");
  EXPECT_TRUE(graph.nodes[1].respawn.wanted);
  EXPECT_THAT(node_options(graph.nodes[1], ""), ElementsAre("--name", "report", "--clock", "wall"));
}

// A list was "one value, not a list or mapping" wherever it stood.
TEST_F(LaunchFileTest, ListsAreParametersAndArguments) {
  write("part.yaml", R"(
arguments:
  generators: {type: list, default: [circles, "a, b"]}
  plain: {default: "[x]"}
nodes:
  - {node: grasp_planning, parameters: {generators: $(generators), plain: $(plain)}}
)");
  const std::string whole = R"(
arguments: {matrix: {type: double, default: 0.5}}
include: [{file: $(launch_dir)/part.yaml, arguments: {generators: [segments, boxes]}}]
nodes:
  - node: simulation
    parameters: {move: [0, $(matrix), -1e-3], names: [left, "a, b", ""], none: [], deep: {er: [1]}}
)";
  const LaunchGraph graph = load(whole);
  ASSERT_EQ(graph.nodes.size(), 2u);
  EXPECT_THAT(graph.nodes[0].parameters,
              ElementsAre(Pair("generators", "[segments, boxes]"), Pair("plain", "[x]")));
  EXPECT_THAT(graph.nodes[1].parameters,
              ElementsAre(Pair("deep.er", "[1]"), Pair("move", "[0, 0.5, -1e-3]"),
                          Pair("names", "[left, \"a, b\", \"\"]"), Pair("none", "[]")));
  const LaunchGraph part =
      load_launch_file((folder_ / "launch/part.yaml").string(), {}, (folder_ / "bin").string());
  EXPECT_EQ(part.nodes[0].parameters.at("generators"), "[circles, \"a, b\"]");
  EXPECT_THAT(error_of("arguments: {a: {type: list, default: b}}\nnodes: [{node: report}]"),
              HasSubstr("argument a must be a list, as in [a, b], is \"b\""));
  EXPECT_THAT(error_of("arguments: {a: {type: list}}\nnodes: [{node: report}]", {"a:=[1, 2"}),
              HasSubstr("argument a must be a list"));
}

TEST_F(LaunchFileTest, ItsDescriptionLoadsToTheSameGraph) {
  const LaunchGraph graph = load(R"(
hosts: {cell: {address: 127.0.0.1}, arm: {address: 127.0.0.2}}
registry_host: arm
log_directory: out/somewhere
warnings: [{text: "no: camera"}, {text: nothing, if: false}]
nodes:
  - node: simulation
    name: world
    parameters: {text: "a: b #c", n: -1}
    remap: {/a: /b, /c: //d, /e/*: /f/*}
    required: true
    namespace: /left/arm
    cpu_affinity: [0]
    nice: 5
  - {node: report, environment: {A: "x y"}, clock: wall, after: [left_arm_world], host: cell,
     respawn: {first_delay: 0.25, longest_delay: 3}}
  - {node: grasp_planning, compose: both}
  - {node: test_other, compose: both}
)");
  const LaunchGraph again = load(describe(graph));
  ASSERT_EQ(again.nodes.size(), 4u);
  EXPECT_EQ(again.registry_host, "arm");
  EXPECT_EQ(again.hosts.size(), 2u);
  EXPECT_EQ(again.log_directory, "out/somewhere");
  EXPECT_EQ(again.warnings, std::vector<std::string>{"no: camera"});
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    EXPECT_EQ(node_options(again.nodes[i], ""), node_options(graph.nodes[i], ""));
    EXPECT_EQ(again.nodes[i].environment, graph.nodes[i].environment);
    EXPECT_EQ(again.nodes[i].required, graph.nodes[i].required);
    EXPECT_EQ(again.nodes[i].respawn, graph.nodes[i].respawn);
    EXPECT_EQ(again.nodes[i].cpu_affinity, graph.nodes[i].cpu_affinity);
    EXPECT_EQ(again.nodes[i].nice, graph.nodes[i].nice);
    EXPECT_EQ(again.nodes[i].host, graph.nodes[i].host);
    EXPECT_EQ(again.nodes[i].process, graph.nodes[i].process);
    EXPECT_EQ(again.nodes[i].after, graph.nodes[i].after);
  }
}

TEST_F(LaunchFileTest, ConditionsChooseNodesAndIncludes) {
  write("b.yaml", "arguments: {who: {default: x}}\nnodes: [{node: report, name: $(who)}]\n");
  const std::string text = R"(
arguments: {mode: {default: fast}, viewer: {default: false, type: bool}}
include:
  - {file: b.yaml, if: $(viewer), arguments: {who: included}}
nodes:
  - {node: simulation, if: $(mode)==fast}
  - {node: simulation, name: slow, if: "$(mode) != 'fast'"}
)";
  const auto names = [](const LaunchGraph& graph) {
    std::vector<std::string> list;
    for (const LaunchNode& node : graph.nodes) list.push_back(node.name);
    return list;
  };
  EXPECT_THAT(names(load(text)), ElementsAre("simulation"));
  EXPECT_THAT(names(load(text, {"mode:=x", "viewer:=true"})), ElementsAre("included", "slow"));
  EXPECT_THAT(error_of("nodes: [{node: report, if: maybe}]"), HasSubstr("if must be true, false"));
}

TEST_F(LaunchFileTest, ArgumentsWithoutEffectAreRefusedWithWhatLeavesThemOut) {
  write("driver.yaml", R"(
arguments: {device: {default: sim}, line: {default: can0}, rate: {default: 5}}
nodes:
  - {node: report, if: $(device) == real, parameters: {title: $(line)}}
  - {node: simulation}
)");
  const std::string text = R"(
arguments:
  device: {default: sim}
  bus: {default: can0}
  line: {default: net_$(bus)}
  rate: {default: 5}
  viewer: {default: false, type: bool}
  colour: {default: red}
  idle: {default: 1}
include:
  - {file: driver.yaml, arguments: {device: $(device), line: $(line), rate: $(rate)}}
groups:
  - {if: $(viewer), nodes: [{node: test_other, name: $(colour)_view}]}
)";
  load(text, {"device:=real", "line:=can1"});
  load(text, {"device:=real", "bus:=vcan0"});  // by way of the default of line
  load(text, {"device:=sim"});
  load(text, {"viewer:=true", "colour:=blue"});
  for (const char* argument : {"line:=can1", "bus:=vcan0"}) {
    const std::string error = error_of(text, {argument});
    EXPECT_THAT(error, HasSubstr(std::string("command line: ") + argument + " has no effect"));
    EXPECT_THAT(error, HasSubstr("driver.yaml:4 (if: $(device) == real)"));
  }
  EXPECT_THAT(error_of(text, {"colour:=blue"}), HasSubstr("(if: $(viewer))"));
  EXPECT_THAT(error_of(text, {"idle:=2"}), HasSubstr("nothing in the launch file uses it"));
  EXPECT_THAT(error_of(text, {"rate:=2"}), HasSubstr("nothing in the launch file uses it"));
  // Given a value of its own, line does without its default.
  EXPECT_THAT(error_of(text, {"device:=real", "line:=can1", "bus:=vcan0"}),
              HasSubstr("bus:=vcan0 has no effect"));
}

TEST_F(LaunchFileTest, WarningsOfAllFilesAreCollected) {
  write("b.yaml", "warnings: [{text: beside}]\nnodes: [{node: report}]\n");
  const LaunchGraph graph = load(R"(
arguments: {mode: {default: fast}}
warnings:
  - {text: "$(mode) leaves much out", if: $(mode) == fast}
  - {text: "slow", if: $(mode) != fast}
include: [{file: b.yaml}]
)");
  EXPECT_THAT(graph.warnings, ElementsAre("fast leaves much out", "beside"));
  EXPECT_THAT(error_of("warnings: [{if: true}]\nnodes: [{node: report}]"),
              HasSubstr("a warning needs the key \"text\""));
  EXPECT_THAT(error_of("warnings: [{txt: a}]\nnodes: [{node: report}]"),
              HasSubstr("unknown key \"txt\""));
  EXPECT_THAT(error_of("warnings: no\nnodes: [{node: report}]"), HasSubstr("must be a list"));
}

TEST_F(LaunchFileTest, ValuesSayOnceWhatArgumentsAmountTo) {
  const std::string text = R"yaml(
arguments: {arm: {default: sim, choices: [sim, rsi]}, hand: {default: sim}}
values:
  time: {then: wall, if: $(arm) $(hand) == rsi sdh, otherwise: simulated}
  prefix: {then: "", if: $(arm) == sim, otherwise: /unused}
  told: {then: "$(time) $(arm)", if: $(time) == wall, otherwise: nothing}
clock: $(time)
nodes: [{node: simulation, parameters: {told: $(told)}, remap: {/arm/stop: $(prefix)/arm/stop}}]
)yaml";
  const LaunchGraph simulated = load(text);
  EXPECT_EQ(simulated.nodes[0].clock, "simulated");
  EXPECT_TRUE(simulated.nodes[0].remaps.empty());  // by an empty prefix nothing is renamed
  EXPECT_EQ(simulated.arguments.count("time"), 0u);
  EXPECT_EQ(load(describe(simulated)).nodes[0].parameters, simulated.nodes[0].parameters);
  const LaunchGraph real = load(text, {"arm:=rsi", "hand:=sdh"});
  EXPECT_EQ(real.nodes[0].clock, "wall");
  EXPECT_EQ(real.nodes[0].parameters.at("told"), "wall rsi");
  EXPECT_EQ(real.nodes[0].remaps.at("/arm/stop"), "/unused/arm/stop");
  const std::string all = R"yaml(
arguments: {prefix: {default: ""}}
nodes: [{node: simulation, remap: {/arm/*: $(prefix)/arm/*, /arm/stop: /arm/stop, /a: /a}}]
)yaml";
  EXPECT_TRUE(load(all).nodes[0].remaps.empty());
  EXPECT_THAT(load(all, {"prefix:=/world"}).nodes[0].remaps,
              ElementsAre(Pair("/arm/*", "/world/arm/*"), Pair("/arm/stop", "/arm/stop")));
  const std::string nodes = "\nnodes: [{node: report}]\n";
  EXPECT_THAT(error_of("values: {a: {then: 1, if: true}}" + nodes),
              HasSubstr("value a needs the key \"otherwise\""));
  EXPECT_THAT(error_of("values: {a: {then: 1, iff: true, otherwise: 2}}" + nodes),
              HasSubstr("did you mean \"if\"?"));
  EXPECT_THAT(error_of("values: {root: {then: 1, if: true, otherwise: 2}}" + nodes),
              HasSubstr("value root has a name that is already taken"));
  EXPECT_THAT(error_of("values: {a: {then: $(b), if: true, otherwise: 2}}" + nodes),
              HasSubstr("unknown argument $(b)"));
  EXPECT_THAT(error_of("values: [a]" + nodes), HasSubstr("values must be a mapping"));
  EXPECT_THAT(error_of(text, {"time:=wall"}), HasSubstr("has no argument \"time\""));
}

TEST_F(LaunchFileTest, AValueIsANamedFileOfAFolderOrOnesOwn) {
  const std::string text = R"yaml(
arguments: {scene: {default: demo}}
values: {file: {file: $(scene), of: /no/such/folder}}
nodes: [{node: simulation, parameters: {scene: $(file)}}]
)yaml";
  const auto file = [&](const std::string& scene) {
    return load(text, {"scene:=" + scene}).nodes[0].parameters.at("scene");
  };
  EXPECT_EQ(load(text).nodes[0].parameters.at("scene"), "/no/such/folder/demo.yaml");
  EXPECT_EQ(file("mine.yaml"), "mine.yaml");
  EXPECT_EQ(file("heaps/mine.yaml"), "heaps/mine.yaml");
  EXPECT_EQ(file("/heaps/mine.yaml"), "/heaps/mine.yaml");
  const std::string nodes = "\nnodes: [{node: report}]\n";
  EXPECT_THAT(error_of("values: {a: {file: b}}" + nodes), HasSubstr("needs the key \"of\""));
  EXPECT_THAT(error_of("values: {a: {file: b, of: c, if: true}}" + nodes),
              HasSubstr("unknown key \"if\""));
}

TEST_F(LaunchFileTest, WhatIsNotOfferedIsRefusedByName) {
  const std::string text = R"(
arguments: {arm: {default: sim, choices: [sim, rsi]}, platform: {default: stage}}
refusals: [{text: "arm:=$(arm) needs an arm, $(platform) has none", if: $(arm) $(platform) == rsi stage}]
nodes: [{node: report}]
)";
  EXPECT_EQ(load(text).nodes.size(), 1u);
  EXPECT_THAT(error_of(text, {"arm:=rsi"}),
              AllOf(HasSubstr("a.yaml:3"), HasSubstr("arm:=rsi needs an arm, stage has none")));
  EXPECT_THAT(error_of(text, {"arm:=rsj"}),
              HasSubstr("argument arm must be one of sim, rsi, is \"rsj\"; did you mean \"rsi\"?"));
  EXPECT_THAT(error_of("arguments: {a: {default: x, choices: [y]}}\nnodes: [{node: report}]"),
              HasSubstr("must be one of y"));
  EXPECT_THAT(error_of("refusals: [{text: no}]\nnodes: [{node: report}]"),
              HasSubstr("a refusal needs the keys"));
}

TEST_F(LaunchFileTest, TheClockIsInheritedByIncludes) {
  write("b.yaml", "nodes: [{node: report}]\n");
  write("c.yaml", "clock: wall\nnodes: [{node: simulation}]\n");
  const LaunchGraph graph = load("clock: simulated\ninclude: [{file: b.yaml}, {file: c.yaml}]\n");
  EXPECT_EQ(graph.nodes[0].clock, "simulated");
  EXPECT_EQ(graph.nodes[1].clock, "wall");
}

TEST_F(LaunchFileTest, MisspeltNamesAreNamedWithTheirLineAndTheNearestOne) {
  EXPECT_THAT(error_of("nodes:\n  - node: simulatoin\n"),
              testing::AllOf(HasSubstr("a.yaml:2: "), HasSubstr("did you mean \"simulation\"?")));
  EXPECT_THAT(error_of("nodes:\n  - node: report\n    paramters: {}\n"),
              testing::AllOf(HasSubstr("a.yaml:3: "), HasSubstr("\"parameters\"")));
  EXPECT_THAT(error_of("noeds: []\n"),
              testing::AllOf(HasSubstr("a.yaml:1"), HasSubstr("\"nodes\"")));
  EXPECT_THAT(error_of("arguments: {scene: {default: a}}\nnodes: [{node: report}]\n", {"scnee:=b"}),
              HasSubstr("\"scene\""));
  EXPECT_THAT(
      error_of("arguments: {scene: {default: a}}\nnodes:\n  - {node: report, name: $(scnee)}\n"),
      testing::AllOf(HasSubstr("a.yaml:3"), HasSubstr("\"scene\"")));
  EXPECT_THAT(error_of("arguments: {scene: {defualt: a}}\n"), HasSubstr("\"default\""));
  EXPECT_THAT(error_of("clock: simulatd\nnodes: [{node: report}]\n"), HasSubstr("\"simulated\""));
}

TEST_F(LaunchFileTest, WrongValuesAreNamed) {
  const std::string typed =
      "arguments: {n: {default: 1, type: int}, b: {default: true, type: bool}, "
      "x: {default: 1.5, type: double}}\n"
      "nodes: [{node: report, parameters: {n: $(n), b: $(b), x: $(x)}}]\n";
  EXPECT_THAT(error_of(typed, {"n:=1.5"}), HasSubstr("argument n must be an integer, is \"1.5\""));
  EXPECT_THAT(error_of(typed, {"b:=maybe"}), HasSubstr("must be true or false"));
  EXPECT_THAT(error_of(typed, {"x:=fast"}), HasSubstr("must be a number"));
  EXPECT_EQ(error_of(typed, {"x:=-1e-3", "n:=-2"}), "no error");
  EXPECT_THAT(error_of("arguments: {n: {default: x, type: int}}\nnodes: [{node: report}]"),
              HasSubstr("must be an integer"));
  EXPECT_THAT(error_of("arguments: {bag: {description: the file}}\nnodes: [{node: report}]"),
              HasSubstr("argument bag (the file) needs a value: bag:=..."));
  EXPECT_THAT(error_of("nodes: [{node: report, required: sometimes}]"),
              HasSubstr("required must be"));
  EXPECT_THAT(error_of("nodes: [{node: report, required: true, respawn: true}]"),
              HasSubstr("both"));
  EXPECT_THAT(error_of("nodes: [{node: report, parameters: {a: [[1], 2]}}]"),
              HasSubstr("each of parameters a must be one value"));
  EXPECT_THAT(error_of("nodes: [{node: report, environment: {A: [1, 2]}}]"),
              HasSubstr("one value"));
  EXPECT_THAT(error_of("nodes: [{node: report, remap: {camera: /a}}]"),
              HasSubstr("remap camera: /a: name 'camera': use '/'"));
  for (const char* remap : {"/a/*: /b", "/a: /b/*", "/a*: /b*", "/*/a: /*/b"}) {
    EXPECT_THAT(error_of("nodes: [{node: report, remap: {" + std::string(remap) + "}}]"),
                HasSubstr("remap " + std::string(remap)));
  }
  EXPECT_THAT(error_of("nodes: [{node: report, name: a-b}]"), HasSubstr("no node name"));
  EXPECT_THAT(error_of("nodes: [{node: ../bin/none}]"), HasSubstr("no node program"));
  EXPECT_THAT(error_of("nodes: [{node: ./a.yaml}]"), HasSubstr("is not executable"));
  EXPECT_THAT(error_of("nodes: [{node: report, name: $(root}]"), HasSubstr("closing parenthesis"));
  EXPECT_THAT(error_of("nodes: [{name: x}]"), HasSubstr("needs the key \"node\""));
  EXPECT_THAT(error_of("nodes: {node: report}"), HasSubstr("must be a list"));
  EXPECT_THAT(error_of("nodes: [report]"), HasSubstr("must be a mapping"));
  EXPECT_THAT(error_of("nodes: []"), HasSubstr("no nodes"));
  EXPECT_THAT(error_of(""), HasSubstr("is empty"));
  EXPECT_THAT(error_of("nodes: [\n  {"), HasSubstr("a.yaml:"));
  EXPECT_THAT(error_of("nodes: [{node: report}]", {"scene"}), HasSubstr("name:=value"));
}

TEST_F(LaunchFileTest, TwoNodesOfOneNameAreNamedWithBothPlaces) {
  EXPECT_THAT(error_of("nodes:\n  - node: report\n  - node: report\n"),
              testing::AllOf(HasSubstr("a.yaml:3"), HasSubstr("a.yaml:2")));
}

TEST_F(LaunchFileTest, CyclicIncludesShowTheChain) {
  write("b.yaml", "include: [{file: c.yaml}]\n");
  write("c.yaml", "include: [{file: a.yaml}]\n");
  const std::string error = error_of("include: [{file: b.yaml}]\n");
  EXPECT_THAT(error, HasSubstr("in a circle"));
  EXPECT_THAT(error, testing::ContainsRegex("a.yaml -> .*b.yaml -> .*c.yaml -> .*a.yaml"));
  EXPECT_THAT(error_of("include: [{file: a.yaml}]\n"), HasSubstr("in a circle"));
}

TEST_F(LaunchFileTest, MissingFilesAreNamed) {
  EXPECT_THAT(error_of("include:\n  - {file: none.yaml}\n"),
              testing::AllOf(HasSubstr("a.yaml:2"), HasSubstr("none.yaml does not exist")));
  EXPECT_THAT(error_of("nodes:\n  - node: report\n    parameter_file: none.yaml\n"),
              testing::AllOf(HasSubstr("a.yaml:3"), HasSubstr("none.yaml does not exist")));
  EXPECT_THROW(load_launch_file((folder_ / "none.yaml").string(), {}, "."), LaunchError);
  EXPECT_THROW(load_launch_file(folder_.string(), {}, "."), LaunchError);
}

TEST_F(LaunchFileTest, AnIncludeRefusesArgumentsItDoesNotHave) {
  write("b.yaml", "arguments: {speed: {default: 1}}\nnodes: [{node: report}]\n");
  EXPECT_THAT(error_of("include:\n  - {file: b.yaml, arguments: {sped: 2}}\n"),
              testing::AllOf(HasSubstr("a.yaml:2"), HasSubstr("\"speed\"")));
}

TEST_F(LaunchFileTest, DeclaredArgumentsAreListed) {
  const auto arguments = declared_arguments(
      write("a.yaml", "arguments: {a: {default: $(root)/x}, b: {type: int, description: d}}\n"));
  ASSERT_EQ(arguments.size(), 2u);
  EXPECT_EQ(arguments[0].default_value, (folder_ / "x").string());
  EXPECT_FALSE(arguments[1].default_value);
  EXPECT_EQ(arguments[1].description, "d");
}

TEST_F(LaunchFileTest, ProgramsOutsideTheTreeAreNamedByTheirPathOrFoundInTheNodePath) {
  const auto outside = folder_ / "other" / "bin";
  std::filesystem::create_directories(outside);
  for (const char* program : {"wave", "report"}) {
    std::ofstream(outside / program) << "#!/bin/sh\n";
    std::filesystem::permissions(outside / program, std::filesystem::perms::owner_all);
  }
  const LaunchGraph by_path = load("nodes: [{node: ../other/bin/wave}]");
  EXPECT_EQ(by_path.nodes.at(0).executable, (outside / "wave").string());
  EXPECT_EQ(by_path.nodes.at(0).name, "wave");
  EXPECT_EQ(by_path.nodes.at(0).program, "wave");
  // What --dry-run prints can be launched.
  EXPECT_EQ(load(describe(by_path)).nodes.at(0).executable, (outside / "wave").string());

  EXPECT_THAT(error_of("nodes: [{node: wave}]"),
              AllOf(HasSubstr("no node program \"wave\""), HasSubstr("PREHEND_NODE_PATH")));
  const std::string file = write("b.yaml", "nodes: [{node: wave}, {node: report}]");
  const LaunchGraph found =
      load_launch_file(file, {}, (folder_ / "bin").string() + ":" + outside.string());
  EXPECT_EQ(found.nodes.at(0).executable, (outside / "wave").string());
  EXPECT_EQ(found.nodes.at(1).executable, (folder_ / "bin" / "report").string()) << "the first";
}

}  // namespace
}  // namespace prehend::launch
