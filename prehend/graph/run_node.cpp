#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "prehend/graph/node_impl.h"

namespace prehend::graph {
namespace {

int signal_pipe[2] = {-1, -1};

void write_signal(int) {
  const int kept = errno;
  [[maybe_unused]] const auto written = ::write(signal_pipe[1], "s", 1);
  errno = kept;
}

// Shuts the node down on the first SIGINT or SIGTERM; the second one has its default effect.
class SignalWatch {
 public:
  explicit SignalWatch(Node& node) {
    if (::pipe2(signal_pipe, O_CLOEXEC) != 0) {
      throw std::system_error(errno, std::generic_category(), "pipe");
    }
    thread_ = std::thread([&node] {
      char byte = 0;
      ssize_t got = 0;
      do {
        got = ::read(signal_pipe[0], &byte, 1);
      } while (got < 0 && errno == EINTR);
      if (got == 1 && byte == 's') node.shutdown();
    });
    struct sigaction action = {};
    action.sa_handler = write_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
  }

  // A signal that comes during the clean end must not kill, so it is ignored from here on.
  ~SignalWatch() {
    ::signal(SIGINT, SIG_IGN);
    ::signal(SIGTERM, SIG_IGN);
    [[maybe_unused]] const auto written = ::write(signal_pipe[1], "e", 1);
    thread_.join();
    ::close(signal_pipe[0]);
    ::close(signal_pipe[1]);
  }

 private:
  std::thread thread_;
};

std::pair<std::string, std::string> split(const std::string& text, const std::string& option) {
  const std::size_t at = text.find(":=");
  if (at == std::string::npos || at == 0) {
    throw std::invalid_argument(option + " '" + text + "': write KEY:=VALUE");
  }
  return {text.substr(0, at), text.substr(at + 2)};
}

void flatten(const YAML::Node& yaml, const std::string& prefix, const std::string& file,
             std::map<std::string, std::string>& out) {
  for (const auto& item : yaml) {
    const std::string name = prefix + item.first.as<std::string>();
    if (item.second.IsMap()) {
      flatten(item.second, name + ".", file, out);
    } else if (item.second.IsScalar()) {
      out[name] = item.second.as<std::string>();
    } else {
      throw std::invalid_argument(fmt::format("{}:{}: parameter '{}' must be a single value", file,
                                              item.second.Mark().line + 1, name));
    }
  }
}

void read_parameter_file(const std::string& file, std::map<std::string, std::string>& out) {
  try {
    const YAML::Node yaml = YAML::LoadFile(file);
    if (yaml.IsNull()) return;
    if (!yaml.IsMap()) throw std::invalid_argument(file + ": must be a mapping of names to values");
    flatten(yaml, "", file, out);
  } catch (const YAML::BadFile&) {
    throw std::invalid_argument("parameter file '" + file + "' cannot be read");
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(fmt::format("{}:{}: {}", file, error.mark.line + 1, error.msg));
  }
}

struct CommandLine {
  NodeOptions options;
  bool wants_help = false;
  std::string help;
};

CommandLine read_command_line(int argc, char** argv, const NodeDescription& description) {
  CommandLine result;
  NodeOptions& options = result.options;
  options.name = description.name;
  options.program = description.name;
  std::vector<std::string> parameters, files, remaps;
  std::string clock = "wall", level = "info";
  CLI::App app(description.summary);
  app.set_help_flag("");
  app.add_flag("-h,--help", result.wants_help, "Print this and the parameters");
  app.add_option("--name", options.name, "Name in the graph")->capture_default_str();
  app.add_option("--registry", options.registry,
                 std::string("Endpoint of the registry; default: PREHEND_REGISTRY, else ") +
                     kDefaultRegistryEndpoint);
  app.add_option("--param", parameters, "KEY:=VALUE, a parameter; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--params", files, "YAML file of parameters; --param overrides")
      ->allow_extra_args(false);
  app.add_option("--remap", remaps, "FROM:=TO, another name for a topic, service or action")
      ->allow_extra_args(false);
  app.add_option("--clock", clock, "wall or simulated (topic /clock)")
      ->check(CLI::IsMember({"wall", "simulated"}))
      ->capture_default_str();
  app.add_option("--log-level", level, "debug, info, warning or error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}))
      ->capture_default_str();
  app.add_flag("--tcp", options.use_tcp, "Peers connect by tcp on loopback instead of ipc");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw std::invalid_argument(std::string(error.what()) + " (see --help)");
  }
  for (const std::string& file : files) read_parameter_file(file, options.parameters);
  for (const std::string& text : parameters) {
    const auto [name, value] = split(text, "--param");
    options.parameters[name] = value;
  }
  for (const std::string& text : remaps) options.remaps.insert(split(text, "--remap"));
  options.clock = clock == "wall" ? ClockMode::kWall : ClockMode::kSimulated;
  options.log_level = level == "debug"     ? LogLevel::kDebug
                      : level == "info"    ? LogLevel::kInfo
                      : level == "warning" ? LogLevel::kWarning
                                           : LogLevel::kError;
  result.help = app.help(description.name);
  return result;
}

void print_parameter(const ParameterInfo& parameter) {
  std::string text = "  " + parameter.name + " = " + to_text(parameter.default_value);
  if (!parameter.unit.empty()) text += " [" + parameter.unit + "]";
  if (parameter.minimum || parameter.maximum) {
    text += fmt::format(" ({} to {})", parameter.minimum ? to_text(*parameter.minimum) : "any",
                        parameter.maximum ? to_text(*parameter.maximum) : "any");
  }
  for (std::size_t i = 0; i < parameter.choices.size(); ++i) {
    text += (i == 0 ? " one of " : ", ") + to_text(parameter.choices[i]);
  }
  fmt::print("{}\n      {}\n", text, parameter.description);
}

void print_parameters(Node& node, const std::function<void(Node&)>& set_up) {
  std::string failure;
  try {
    set_up(node);
  } catch (const DescriptionDone&) {
    // the first thing it does on the graph: all parameters are declared
  } catch (const std::exception& error) {
    failure = error.what();
  }
  const auto parameters = node.parameters();
  if (!parameters.empty()) fmt::print("\nParameters:\n");
  for (const ParameterInfo& parameter : parameters) print_parameter(parameter);
  if (!failure.empty()) fmt::print("\nNot all may be listed: {}\n", failure);
}

// Large messages come and go all the time: keep their memory instead of giving it back and paying
// for page faults again.
void keep_heap_warm() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

}  // namespace

int run_node(int argc, char** argv, const NodeDescription& description,
             const std::function<void(Node&)>& set_up) {
  std::string name = description.name;
  try {
    CommandLine command = read_command_line(argc, argv, description);
    name = command.options.name;
    if (command.wants_help) {
      fmt::print("{}", command.help);
      Node node(command.options, true);
      print_parameters(node, set_up);
      return 0;
    }
    keep_heap_warm();
    Node node(std::move(command.options));
    const SignalWatch watch(node);
    set_up(node);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 1;
  }
}

}  // namespace prehend::graph
