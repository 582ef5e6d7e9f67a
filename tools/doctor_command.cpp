// `prehend doctor`: one page on what is wrong here, and the mend.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>

#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"
#include "prehend/text/command_line.h"
#include "tools/commands.h"
#include "tools/doctor_devices.h"
#include "tools/doctor_graph.h"
#include "tools/doctor_host.h"
#include "tools/json.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

using Level = Finding::Level;

struct DoctorChoices {
  std::string registry;
  bool json = false;
  DeviceChoices devices;
};

constexpr const char* kFindingLevels[] = {"ok", "warning", "error"};

bool answers(const std::string& endpoint) {
  try {
    graph::Introspection(endpoint, std::chrono::milliseconds(500)).nodes();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

// Why no registry answers at `endpoint`, and where one does.
Finding missing_registry(const std::string& endpoint, const std::string& error, bool by_option) {
  const char* variable = std::getenv("PREHEND_REGISTRY");
  const bool by_variable = !by_option && variable && *variable;
  Finding finding{Level::kError, "registry", error, "start a graph: prehend launch FILE"};
  if (by_variable) finding.what += " (from PREHEND_REGISTRY)";
  if (endpoint != graph::kDefaultRegistryEndpoint && answers(graph::kDefaultRegistryEndpoint)) {
    finding.mend = fmt::format("one answers at {}: {}", graph::kDefaultRegistryEndpoint,
                               by_variable ? "unset PREHEND_REGISTRY" : "leave --registry out");
    return finding;
  }
  const auto others = living_registries();
  if (!others.empty()) {
    finding.mend = "export PREHEND_REGISTRY=ENDPOINT; running here: " + joined(others);
  }
  return finding;
}

void print_findings(const std::string& registry, const std::optional<GraphView>& graph,
                    const Findings& findings, int errors, int warnings) {
  const bool colours = ::isatty(STDOUT_FILENO) == 1;
  static constexpr const char* kColours[] = {"\x1b[32m", "\x1b[33m", "\x1b[31m"};
  std::printf("prehend doctor: registry %s%s\n\n", registry.c_str(),
              graph ? fmt::format(", {} nodes", graph->nodes.size()).c_str() : "");
  for (const Finding& finding : findings) {
    const int level = static_cast<int>(finding.level);
    std::printf("%s%-8s%s %s: %s\n", colours ? kColours[level] : "", kFindingLevels[level],
                colours ? "\x1b[0m" : "", finding.subject.c_str(), finding.what.c_str());
    if (!finding.mend.empty()) std::printf("         -> %s\n", finding.mend.c_str());
  }
  if (errors + warnings == 0) {
    std::printf("\nnothing is wrong\n");
  } else {
    std::printf("\n%d errors, %d warnings\n", errors, warnings);
  }
}

void print_findings_json(const std::string& registry, const std::optional<GraphView>& graph,
                         const Findings& findings, int errors, int warnings) {
  Json list = Json::array();
  for (const Finding& finding : findings) {
    list.add(Json::object()
                 .set("level", kFindingLevels[static_cast<int>(finding.level)])
                 .set("subject", finding.subject)
                 .set("what", finding.what)
                 .set("mend", finding.mend));
  }
  tools::print(Json::object()
                   .set("registry", registry)
                   .set("reachable", graph.has_value())
                   .set("nodes", graph ? graph->node_names() : std::vector<std::string>())
                   .set("errors", errors)
                   .set("warnings", warnings)
                   .set("findings", list));
}

int examine(const DoctorChoices& choices) {
  Findings findings = examine_host();
  std::optional<GraphView> graph;
  std::string registry = choices.registry;
  try {
    registry = graph::Introspection(choices.registry).registry();
    graph = look_at_graph(choices.registry);
    findings.push_back({Level::kOk, "registry", "answers", ""});
    if (graph->nodes.empty()) {
      findings.push_back({Level::kWarning, "registry", "knows no node",
                          "start nodes with --registry " + registry + " or PREHEND_REGISTRY set"});
    }
    const Findings more = examine_graph(*graph);
    findings.insert(findings.end(), more.begin(), more.end());
  } catch (const std::exception& error) {
    findings.push_back(missing_registry(registry, error.what(), !choices.registry.empty()));
    // Devices are asked before a graph is started, too.
    if (choices.devices.any()) findings.back().level = Level::kWarning;
  }
  const Findings of_devices = examine_devices(choices.devices);
  findings.insert(findings.end(), of_devices.begin(), of_devices.end());
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.level < b.level; });
  const auto count = [&](Level level) {
    return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                          [&](const Finding& f) { return f.level == level; }));
  };
  const int errors = count(Level::kError), warnings = count(Level::kWarning);
  (choices.json ? print_findings_json : print_findings)(registry, graph, findings, errors,
                                                        warnings);
  return errors > 0 ? 1 : 0;
}

void add_device_options(CLI::App& command, DeviceChoices& devices) {
  command.add_option("--can", devices.can,
                     "Line of a PG70: can0, slcan:/dev/ttyACM0, serial:/dev/ttyUSB2");
  command.add_option("--module", devices.module_id, "Its module id")
      ->check(text::in_range(1, 255))
      ->capture_default_str();
  command.add_option("--bit-rate", devices.bit_rate, "Of its line, as the driver's bit_rate")
      ->check(text::above_zero(true));
  command
      .add_flag("--scan", devices.scan,
                "Ask all module ids: sends 255 messages, unless others talk on the line")
      ->needs("--can");
  command.add_flag("--shared-bus", devices.shared, "With --scan: ask although others talk there")
      ->needs("--scan");
  command.add_option("--dsa", devices.dsa, "Line of a tactile controller, or tcp://HOST:PORT");
  command.add_option("--ft300", devices.ft300, "Line of an FT 300, or tcp://HOST:PORT");
  command.add_option("--sdh", devices.sdh,
                     "Line of an SDH-2, or tcp://HOST:PORT, whose port is 23");
  command.add_option(
      "--barrett", devices.barrett,
      "Bus of a BarrettHand BH8-280 (can0, slcan:/dev/ttyACM0), or line of a BH8-262 "
      "(/dev/ttyUSB2, tcp://HOST:PORT)");
  command
      .add_option("--rsi", devices.rsi_port,
                  "UDP port that a KUKA's controller sends to: listens there, answers nothing")
      ->check(text::in_range(1, 65535));
  command.add_option("--rsi-host", devices.rsi_host, "Address of this machine of the same")
      ->default_val("0.0.0.0")
      ->needs("--rsi");
  command.add_option("--unit", devices.unit, "Its Modbus address")
      ->check(text::in_range(1, 247))
      ->capture_default_str();
  command.add_flag("--cameras", devices.cameras,
                   "List V4L2 cameras, and depth cameras that OpenNI2 knows");
  command.add_option("--camera", devices.camera, "V4L2 camera: /dev/video0; may be repeated");
  command.add_option("--depth-camera", devices.depth_camera,
                     "Depth camera: URI of OpenNI2, recording .oni, prehend://HOST:PORT; takes an "
                     "image; may be repeated");
}

}  // namespace

void add_doctor_command(CLI::App& app, Outcome& outcome) {
  auto choices = std::make_shared<DoctorChoices>();
  CLI::App* command = app.add_subcommand(
      "doctor",
      "Say what is wrong with this machine, the running graph and the devices named, and the mend");
  add_registry_option(*command, choices->registry);
  add_json_option(*command, choices->json);
  add_device_options(*command, choices->devices);
  command->footer(
      "Exit code 1 when there are errors. Devices are asked who they are, and never moved.\n\n"
      "Examples:\n  prehend doctor\n"
      "  prehend doctor --can can0 --module 12 --dsa /dev/ttyUSB0 --ft300 /dev/ttyUSB1\n"
      "  prehend doctor --cameras --camera /dev/video0");
  command->callback([choices, &outcome] { outcome.exit_code = examine(*choices); });
}

}  // namespace prehend::tools
