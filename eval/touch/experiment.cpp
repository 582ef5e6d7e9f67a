#include "eval/touch/experiment.h"

#include <exception>
#include <iostream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "eval/text_files.h"

namespace prehend::eval::touch {
namespace {

std::string shown(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "yes" : "no";
  return std::get<std::string>(value);
}

std::string json_value(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return json_number(*number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  return json_string(std::get<std::string>(value));
}

std::string json_members(const Row& row) {
  std::string members;
  for (const auto& [name, value] : row) {
    members += (members.empty() ? "" : ", ") + json_string(name) + ": " + json_value(value);
  }
  return members;
}

}  // namespace

std::string number_text(double value, int digits) { return fmt::format("{:.{}g}", value, digits); }

std::string to_json(const Findings& findings) {
  std::string json = "{\n  \"title\": " + json_string(findings.title);
  if (!findings.summary.empty()) json += ",\n  " + json_members(findings.summary);
  for (const auto& [name, rows] : findings.tables) {
    json += ",\n  " + json_string(name) + ": [";
    for (std::size_t i = 0; i < rows.size(); ++i) {
      json += (i ? ",\n    {" : "\n    {") + json_members(rows[i]) + "}";
    }
    json += "\n  ]";
  }
  return json + "\n}\n";
}

void add_table(report::Page& page, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  std::vector<std::string> header;
  for (const auto& [name, value] : rows.front()) header.push_back(name);
  std::vector<std::vector<std::string>> cells;
  for (const Row& row : rows) {
    cells.emplace_back();
    for (const auto& [name, value] : row) cells.back().push_back(shown(value));
  }
  page.add_table(header, cells);
}

int run_experiment(int argc, char** argv, const std::string& description,
                   const std::function<Findings(const ExperimentOptions&, report::Page&)>& work) {
  ExperimentOptions options;
  CLI::App app(description);
  app.add_option("--out", options.out, "folder of the report (report.html)");
  app.add_option("--json", options.json, "file of the figures");
  app.add_flag("--quick", options.quick, "a coarser run, for a first look");
  CLI11_PARSE(app, argc, argv);
  try {
    report::Page page(description);
    const Findings findings = work(options, page);
    for (const auto& [name, value] : findings.summary) {
      std::cout << name << ": " << shown(value) << '\n';
    }
    if (!options.out.empty()) page.write(options.out / "report.html");
    if (!options.json.empty()) write_text(options.json, to_json(findings));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << app.get_name() << ": " << error.what() << '\n';
    return 1;
  }
}

}  // namespace prehend::eval::touch
