#include "bench/graph/report.h"

#include <fmt/chrono.h>
#include <fmt/core.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>

namespace prehend::bench {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string json_benchmark(const RowResult& result) {
  const std::string name = json_quote("graph/" + result.row().name());
  std::string text = fmt::format(
      "    {{\"name\": {0}, \"run_name\": {0}, \"run_type\": \"iteration\", \"repetitions\": 1, "
      "\"repetition_index\": 0, \"threads\": 1, \"payload_bytes\": {1}, ",
      name, result.row().bytes);
  if (!result.ok()) return text + "\"error_occurred\": true, \"error_message\": \"failed\"}";
  text += fmt::format("\"iterations\": {}, \"cpu_time\": {:.3f}, \"time_unit\": \"us\", ",
                      result.messages(), result.cpu_per_message());
  if (result.row().kind->throughput) {
    return text + fmt::format("\"real_time\": {:.4f}, \"items_per_second\": {:.0f}, \"lost\": {}}}",
                              1e6 / result.rate(), result.rate(), result.lost());
  }
  return text + fmt::format(
                    "\"real_time\": {0:.3f}, \"p50_us\": {0:.3f}, \"p90_us\": {1:.3f}, "
                    "\"p99_us\": {2:.3f}, \"best_round_p50_us\": {3:.3f}}}",
                    result.p50(), result.p90(), result.p99(), result.best_p50());
}

std::string json_target(const Target& target) {
  return fmt::format(
      "    {{\"name\": {}, \"value\": {:.4f}, \"{}\": {}, \"unit\": {}, \"promised\": {}, "
      "\"met\": {}}}",
      json_quote(target.name), target.value, target.at_least ? "at_least" : "at_most", target.limit,
      json_quote(target.unit.empty() ? "ratio" : target.unit), !target.aim, target.met());
}

template <class Item, class Write>
std::string json_list(const std::vector<Item>& items, Write write) {
  std::string text = "[";
  for (std::size_t i = 0; i < items.size(); ++i) {
    text += (i == 0 ? "\n" : ",\n") + write(items[i]);
  }
  return text + "\n  ]";
}

}  // namespace

std::string json_quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char character : text) {
    if (character == '"' || character == '\\') quoted += '\\';
    if (static_cast<unsigned char>(character) < 0x20) {
      quoted += fmt::format("\\u{:04x}", static_cast<int>(character));
    } else {
      quoted += character;
    }
  }
  return quoted + "\"";
}

std::string json_context() {
  utsname system{};
  uname(&system);
  double load[3] = {};
  [[maybe_unused]] const int count = getloadavg(load, 3);
  return fmt::format(
      "  \"context\": {{\n    \"date\": \"{:%Y-%m-%dT%H:%M:%S%z}\",\n    \"host_name\": {},\n"
      "    \"executable\": \"bench_graph\",\n    \"num_cpus\": {},\n    \"cpu\": {},\n"
      "    \"kernel\": {},\n    \"load_avg\": [{:.2f}, {:.2f}, {:.2f}],\n"
      "    \"library_build_type\": \"{}\"\n  }}",
      fmt::localtime(std::time(nullptr)), json_quote(system.nodename),
      sysconf(_SC_NPROCESSORS_ONLN), json_quote(processor_name()), json_quote(system.release),
      load[0], load[1], load[2],
#ifdef NDEBUG
      "release"
#else
      "debug"
#endif
  );
}

void write_file(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw BenchError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

std::string table_head() {
  return fmt::format("{:<28} {:>9} {:>9} {:>9} {:>9} {:>10}", "row", "p50 us", "p90 us", "p99 us",
                     "messages", "cpu us/msg");
}

std::string table_line(const RowResult& result) {
  const std::string name = result.row().name();
  if (!result.ok()) return fmt::format("{:<28} {:>9}", name, "FAILED");
  if (result.row().kind->throughput) {
    return fmt::format("{:<28} {:>9.0f} messages/s, {} lost {:>17} {:>10.2f}", name, result.rate(),
                       result.lost(), result.messages(), result.cpu_per_message());
  }
  return fmt::format("{:<28} {:>9.1f} {:>9.1f} {:>9.1f} {:>9} {:>10.1f}", name, result.p50(),
                     result.p90(), result.p99(), result.messages(), result.cpu_per_message());
}

std::string target_table(const std::vector<Target>& all) {
  std::string text;
  for (const Target& target : all) {
    const int digits = target.unit.empty() ? 2 : target.at_least ? 0 : 1;
    text += fmt::format("{:<32} {:>10.{}f} {:<5} {} {:<8g} {}{}\n", target.name, target.value,
                        digits, target.unit, target.at_least ? ">=" : "<=", target.limit,
                        target.met() ? "met" : "MISSED", target.aim ? " (an aim)" : "");
  }
  return text;
}

std::string json_report(const std::vector<RowResult>& results, const std::vector<Target>& all) {
  return "{\n" + json_context() + ",\n  \"benchmarks\": " + json_list(results, json_benchmark) +
         ",\n  \"targets\": " + json_list(all, json_target) + "\n}\n";
}

}  // namespace prehend::bench
