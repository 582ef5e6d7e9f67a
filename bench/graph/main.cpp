#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <optional>

#include "bench/graph/node_options.h"
#include "bench/graph/report.h"
#include "bench/graph/soak.h"
#include "bench/graph/workers.h"

namespace prehend::bench {
namespace {

struct Options {
  std::string json;
  std::string filter;
  double seconds = 1.0;
  int rounds = 2;
  bool list = false;
  std::optional<double> soak_seconds;
};

std::string own_program() { return std::filesystem::read_symlink("/proc/self/exe"); }

/// The ROS 1 peer's program beside this one, when it was built.
std::string ros1_program() {
  return (std::filesystem::path(own_program()).parent_path() / "peers" / "bench_graph_ros1");
}

std::string explanation() {
  std::string text =
      "Latency: from the call of publish (with encoding and copying) until the callback has the\n"
      "payload in hand, between two processes, one message at a time. Rows:\n";
  for (const PeerKind& kind : peer_kinds()) {
    text += fmt::format("  {:<23}{}\n", kind.name, kind.description);
  }
  text +=
      "Every round of a row runs in fresh processes over loopback or ipc; rounds of all rows take\n"
      "turns. What was measured and what was promised: docs/graph_speed.md.\n"
      "The row ros1 needs the optional target bench_graph_ros1 (libroscpp-dev, "
      "libsensor-msgs-dev,\n"
      "python3-rosmaster).";
  return text;
}

std::vector<RowResult> measure(const std::vector<Row>& chosen, const Options& options) {
  std::vector<RowResult> results(chosen.begin(), chosen.end());
  for (int round = 0; round < options.rounds; ++round) {
    for (std::size_t i = 0; i < results.size() && !interrupted; ++i) {
      const Row& row = results[i].row();
      std::cerr << fmt::format("[round {}/{}, row {}/{}] {}\n", round + 1, options.rounds, i + 1,
                               results.size(), row.name());
      const Job job{row.kind->name, row.bytes, options.seconds / options.rounds};
      results[i].add(run_workers(row.kind->ros1 ? ros1_program() : own_program(), job,
                                 row.kind->same_process));
    }
  }
  return results;
}

int run_rows(const Options& options) {
  const bool has_ros1 = std::filesystem::exists(ros1_program());
  const std::vector<Row> chosen = rows(options.filter, has_ros1);
  if (options.list) {
    for (const Row& row : chosen) std::cout << row.name() << "\n";
    return 0;
  }
  if (!has_ros1) std::cerr << "without ROS 1: bench_graph_ros1 was not built (see --help)\n";
  // An unwritable file is found now and not after the measurement.
  if (!options.json.empty()) write_file(options.json, "");
  const std::vector<RowResult> results = measure(chosen, options);
  if (interrupted) throw BenchError("interrupted; nothing written");
  bool ok = true;
  std::cout << table_head() << "\n";
  for (const RowResult& result : results) {
    std::cout << table_line(result) << "\n";
    ok = ok && result.ok();
  }
  const std::vector<Target> promised = targets(results);
  std::cout << "\n" << target_table(promised);
  if (!options.json.empty()) write_file(options.json, json_report(results, promised));
  return ok ? 0 : 1;
}

int read_command_line_and_run(int argc, char** argv) {
  CLI::App app{"Measures the node graph's latency and throughput beside other transports."};
  Options options;
  app.add_option("--json", options.json,
                 "write the figures to this file, as Google Benchmark does");
  app.add_option("--filter", options.filter, "only rows whose name this regular expression finds");
  app.add_option("--seconds", options.seconds, "time to measure each row, all rounds together")
      ->check(CLI::Range(0.05, 600.0))
      ->capture_default_str();
  app.add_option("--rounds", options.rounds, "rounds to spread that time over")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  std::string busy_wait;
  app.add_option("--busy-wait", busy_wait,
                 "let our nodes look out for so long before they sleep [s], e.g. 0.0001")
      ->check(CLI::Range(0.0, 1.0));
  app.add_flag("--list", options.list, "print the rows' names and end");
  app.footer(explanation());
  auto* soak = app.add_option("--soak", options.soak_seconds,
                              "instead of the rows: mixed traffic for so many seconds (no number: "
                              "600, 1 million messages), with memory and losses accounted")
                   ->expected(0, 1)
                   ->check(CLI::Range(5.0, 86400.0));
  CLI11_PARSE(app, argc, argv);
  if (!busy_wait.empty()) ::setenv(kBusyWaitVariable, busy_wait.c_str(), 1);
  if (soak->count() == 0) return run_rows(options);
  return run_soak(own_program(), options.soak_seconds.value_or(kDefaultSoakSeconds), options.json);
}

int run_program(int argc, char** argv) {
  catch_interrupts();
  if (argc > 1 && argv[1] == std::string("--worker")) {
    run_worker(parse_worker_arguments(argc, argv));
    return 0;
  }
  return read_command_line_and_run(argc, argv);
}

}  // namespace
}  // namespace prehend::bench

int main(int argc, char** argv) {
  try {
    return prehend::bench::run_program(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "bench_graph: " << error.what() << "\n";
    return 1;
  }
}
