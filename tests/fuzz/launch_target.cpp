// A launch file that may include another: `argument byte | launch file`. Bit 0 of the byte gives
// the argument `mode`. A file that loads is described too.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/launch/launch_file.h"
#include "prehend/launch/process_plan.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

namespace fs = std::filesystem;
using namespace prehend::launch;

constexpr std::string_view kPart = R"(
arguments: {rate: {default: 5, type: int}}
nodes:
  - {node: alpha, name: part_alpha, parameters: {rate: $(rate)}}
)";

// The folder `launch` with the file under test and `part.yaml`, and `bin` with two programs.
class Files {
 public:
  Files() {
    folder_.write("launch/part.yaml", kPart);
    for (const char* program : {"bin/alpha", "bin/beta"}) {
      fs::permissions(folder_.write(program, ""), fs::perms::owner_all);
    }
  }
  std::string launch_file(std::string_view content) const {
    return folder_.write("launch/graph.yaml", content);
  }
  std::string programs() const { return folder_.path() / "bin"; }

 private:
  const prehend::fuzz::Folder folder_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Files files;
  prehend::fuzz::FuzzInput input(data, size);
  std::map<std::string, std::string> arguments;
  if (input.byte() & 1) arguments["mode"] = "fast";
  const std::string path = files.launch_file(input.rest());
  try {
    declared_arguments(path);
  } catch (const LaunchError&) {
  }
  try {
    const LaunchGraph graph = load_launch_file(path, arguments, files.programs());
    FUZZ_CHECK(!graph.nodes.empty());
    check_processes(graph);
    std::vector<std::string> hosts{""};
    for (const auto& host : graph.hosts) hosts.push_back(host.name);
    for (const std::string& host : hosts) {
      for (const LaunchProcess& process : processes_of(graph, host)) {
        FUZZ_CHECK(!process.command.empty() && !process.nodes.empty());
      }
    }
    FUZZ_CHECK(!describe(graph).empty());
  } catch (const LaunchError&) {
  }
  return 0;
}
