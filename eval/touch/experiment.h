#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "prehend/report/page.h"

namespace CLI {
class App;
}

namespace prehend::eval::touch {

/// A row of figures: name and value, in order. What a table of the report and an object of the JSON
/// file are made of.
using Value = std::variant<double, std::string, bool>;
using Row = std::vector<std::pair<std::string, Value>>;

/// What an experiment found.
struct Findings {
  std::string title;
  Row summary;
  std::vector<std::pair<std::string, std::vector<Row>>> tables;  // by name
};

/// The findings as one JSON object: the summary's members, then an array for each table.
std::string to_json(const Findings& findings);
/// A table of rows that all have the first one's names.
void add_table(report::Page& page, const std::vector<Row>& rows);

struct ExperimentOptions {
  std::filesystem::path out;   // folder of the report, empty: none
  std::filesystem::path json;  // file of the figures, empty: none
  bool quick = false;          // a coarser run, for a first look
};

/// The main function of an experiment: --out DIR, --json FILE, --quick. `work` fills the page and
/// returns the findings; the summary goes to the terminal. Returns the exit code: 0, or 1 with the
/// reason on standard error.
/// @param add_options of this experiment alone.
int run_experiment(int argc, char** argv, const std::string& description,
                   const std::function<Findings(const ExperimentOptions&, report::Page&)>& work,
                   const std::function<void(CLI::App&)>& add_options = {});

/// `value` with `digits` significant digits.
std::string number_text(double value, int digits = 4);

}  // namespace prehend::eval::touch
