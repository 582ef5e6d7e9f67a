#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

namespace prehend::bench {

/// Figures of a program that measures by itself, as Google Benchmark's JSON has them: rows with a
/// name and numbers.
class Figures {
 public:
  void add(const std::string& name, const nlohmann::json& values) {
    nlohmann::json row = values;
    row["name"] = name;
    rows_.push_back(std::move(row));
  }
  /// To `file`; nowhere where it is empty. @throws std::runtime_error when it cannot be written.
  void write(const std::string& file) const {
    if (file.empty()) return;
    std::ofstream stream(file);
    stream << nlohmann::json{{"benchmarks", rows_}}.dump(1) << '\n';
    if (!stream.flush()) throw std::runtime_error("cannot write " + file);
  }

 private:
  nlohmann::json rows_ = nlohmann::json::array();
};

}  // namespace prehend::bench
