#include "eval/touch/experiment.h"

#include <exception>
#include <iostream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "eval/text_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/json.h"

namespace prehend::eval::touch {
namespace {

std::string shown(const Value& value) {
  if (const auto* number = std::get_if<double>(&value)) return number_text(*number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "yes" : "no";
  return std::get<std::string>(value);
}

text::Json json_value(const Value& value) {
  return std::visit([](const auto& said) { return text::Json(said); }, value);
}

text::Json& add_members(text::Json& json, const Row& row) {
  for (const auto& [name, value] : row) json.set(name, json_value(value));
  return json;
}

}  // namespace

std::string number_text(double value, int digits) { return fmt::format("{:.{}g}", value, digits); }

std::string to_json(const Findings& findings) {
  text::Json json = text::Json::object();
  json.set("title", findings.title);
  add_members(json, findings.summary);
  for (const auto& [name, rows] : findings.tables) {
    text::Json table = text::Json::array();
    for (const Row& row : rows) {
      text::Json object = text::Json::object();
      table.add(add_members(object, row));
    }
    json.set(name, table);
  }
  return json.pretty();
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
                   const std::function<Findings(const ExperimentOptions&, report::Page&)>& work,
                   const std::function<void(CLI::App&)>& add_options) {
  ExperimentOptions options;
  CLI::App app(description);
  app.add_option("--out", options.out, "folder of the report (report.html)");
  app.add_option("--json", options.json, "file of the figures");
  app.add_flag("--quick", options.quick, "a coarser run, for a first look");
  if (add_options) add_options(app);
  if (const auto code = text::parse_command_line(app, argc, argv)) return *code;
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
