// The main function of all benchmarks: Google Benchmark's, with --json FILE besides its own flags.

#include <cstring>
#include <iostream>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

int main(int argc, char** argv) {
  std::vector<std::string> arguments = {argv[0]};
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") != 0) {
      arguments.emplace_back(argv[i]);
      continue;
    }
    if (i + 1 == argc) {
      std::cerr << "--json needs a file name: " << argv[0] << " --json FILE\n";
      return 2;
    }
    arguments.push_back(std::string("--benchmark_out=") + argv[++i]);
    arguments.emplace_back("--benchmark_out_format=json");
  }
  if (arguments.size() == 2 && arguments[1] == "--help") {
    std::cout << "usage: " << argv[0] << " [--json FILE]  writes the figures to FILE as well\n";
  }
  std::vector<char*> pointers;
  for (auto& argument : arguments) pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(count, pointers.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
