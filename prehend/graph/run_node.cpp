#include <fmt/format.h>
#include <malloc.h>
#include <stdlib.h>

#include <stdexcept>

#include "prehend/graph/node_command_line.h"
#include "prehend/graph/node_program.h"
#include "prehend/graph/stop_signals.h"
#include "prehend/graph/warm_heap.h"
#include "prehend/text/input_error.h"

namespace prehend::graph {

void keep_heap_warm() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

std::chrono::milliseconds stop_time_of(const NodeDescription& description) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(description.stop_time * 1e3));
}

int report_end(const std::string& node, const std::exception& error) {
  fmt::print(stderr, "{}: {}\n", node, error.what());
  const bool is_wrong_input = dynamic_cast<const text::InputError*>(&error) != nullptr ||
                              dynamic_cast<const std::invalid_argument*>(&error) != nullptr;
  return is_wrong_input ? kWrongInput : 1;
}

int run_program(int argc, char** argv, const NodeProgram& program) {
  std::string name = program.description.name;
  try {
    NodeCommandLine command = read_node_command_line({argv + 1, argv + argc}, program.description);
    name = command.options.name;
    if (print_what_is_asked(command, program.description, program.run)) return 0;
    // What looks at the graph from this process, or is started by it, looks at the same.
    if (!command.options.registry.empty()) {
      ::setenv("PREHEND_REGISTRY", command.options.registry.c_str(), 1);
    }
    keep_heap_warm();
    Node node(std::move(command.options));
    const StopSignals signals(
        [&] {
          if (!program.stops_itself) node.shutdown();
        },
        stop_time_of(program.description));
    return program.run(node);
  } catch (const std::exception& error) {
    return report_end(name, error);
  }
}

int run_node(int argc, char** argv, const NodeDescription& description,
             const std::function<void(Node&)>& set_up) {
  const auto run = [&set_up](Node& node) {
    set_up(node);
    return 0;
  };
  return run_program(argc, argv, {description, run});
}

}  // namespace prehend::graph
