#pragma once

#include <string>
#include <vector>

#include "bench/graph/results.h"

namespace prehend::bench {

/// Text of a string in JSON, with its quotes.
std::string json_quote(const std::string& text);
/// The object `"context": {...}` of Google Benchmark's files: date, machine, program.
std::string json_context();
/// Throws BenchError naming the file when it cannot be written.
void write_file(const std::string& path, const std::string& text);

/// One line of the table, without a line end.
std::string table_line(const RowResult& result);
std::string table_head();
/// The promises and whether they hold.
std::string target_table(const std::vector<Target>& targets);

/// The figures in the form of Google Benchmark's JSON (real_time: p50), with the additional members
/// p50_us, p90_us, p99_us of each benchmark and a list `targets`.
std::string json_report(const std::vector<RowResult>& results, const std::vector<Target>& targets);

}  // namespace prehend::bench
