#include "tools/command_node.h"

#include <unistd.h>

#include <vector>

#include "prehend/graph/introspection.h"

namespace prehend::tools {

int run_as_node(const std::string& name, const std::string& registry,
                const std::function<void(graph::Node&)>& set_up, bool simulated_clock) {
  std::vector<std::string> words{"prehend", "--name", name + "_" + std::to_string(::getpid()),
                                 "--log-level", "warning"};
  if (!registry.empty()) words.insert(words.end(), {"--registry", registry});
  if (simulated_clock) words.insert(words.end(), {"--clock", "simulated"});
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return graph::run_node(static_cast<int>(words.size()), pointers.data(), {name, ""}, set_up);
}

graph::NodeOptions command_node(const std::string& name, const std::string& registry) {
  graph::NodeOptions options;
  options.name = name + "_" + std::to_string(::getpid());
  options.program = name;
  options.registry = registry;
  options.log_level = graph::LogLevel::kWarning;
  return options;
}

void require_publisher(const std::string& registry, const std::string& topic) {
  graph::Introspection(registry).topic_schema(topic);
}

}  // namespace prehend::tools
