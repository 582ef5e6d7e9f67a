// pad_fit LOG... : what `prehend calibrate tactile` becomes; see there.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "prehend/contact/pad_layout.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/robot/pad_fit/pad_fit.h"
#include "prehend/text/command_line.h"
#include "tools/grasp_plan/progress.h"
#include "tools/json.h"
#include "tools/pad_fit/choices.h"
#include "tools/table.h"

namespace {

using namespace prehend;
using robot::FittedValue;
using robot::FoamCheck;
using robot::PadFit;

std::map<std::string, std::string> named_columns(const std::vector<std::string>& words) {
  std::map<std::string, std::string> columns;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
      throw geometry::InputError("--column " + word + " names nothing",
                                 "Write --column force=NAME_IN_THE_FILE");
    }
    columns[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return columns;
}

struct Checked {
  std::string file;
  FoamCheck check;
};

void print_json(const PadFit& fit, const std::vector<Checked>& checks) {
  tools::Json values = tools::Json::array(), checked = tools::Json::array();
  for (const FittedValue& value : fit.values) {
    values.add(tools::Json::object()
                   .set("name", value.name)
                   .set("unit", value.unit)
                   .set("value", value.value)
                   .set("deviation", value.deviation));
  }
  for (const Checked& one : checks) {
    checked.add(tools::Json::object()
                    .set("log", one.file)
                    .set("off", one.check.off)
                    .set("most_off", one.check.most_off)
                    .set("most_force", one.check.most_force));
  }
  tools::print(tools::Json::object()
                   .set("values", values)
                   .set("presses", fit.foam.presses)
                   .set("off", fit.foam.off)
                   .set("most_force", fit.foam.most_force)
                   .set("checks", checked)
                   .set("remarks", fit.remarks));
}

void print_text(const PadFit& fit, const std::vector<Checked>& checks) {
  std::vector<std::vector<std::string>> rows{{"FOUND", "VALUE", "+-", "UNIT"}};
  for (const FittedValue& value : fit.values) {
    rows.push_back({value.name, fmt::format("{:.4g}", value.value),
                    value.deviation > 0 ? fmt::format("{:.2g}", value.deviation) : "-",
                    value.unit.empty() ? "-" : value.unit});
  }
  tools::print_table(rows);
  std::printf("\n%d presses up to %.3g N; forces are met to %.2g N (%.2g %%)\n", fit.foam.presses,
              fit.foam.most_force, fit.foam.off, 100 * fit.foam.off / fit.foam.most_force);
  for (const Checked& one : checks) {
    std::printf("%s: forces up to %.3g N predicted to %.2g N (%.2g %%), at most %.2g N off\n",
                one.file.c_str(), one.check.most_force, one.check.off,
                100 * one.check.off / one.check.most_force, one.check.most_off);
  }
  for (const std::string& remark : fit.remarks) std::printf("%s\n", remark.c_str());
}

report::Page residual_page(const PadFit& fit, const std::string& log,
                           const std::vector<Checked>& checks) {
  report::Page page("A tactile pad");
  page.add_paragraph(fmt::format("{} presses of {} up to {:.3g} N; forces are met to {:.2g} %.",
                                 fit.foam.presses, log, fit.foam.most_force,
                                 100 * fit.foam.off / fit.foam.most_force));
  for (const std::string& remark : fit.remarks) page.add_answer(remark);
  std::vector<std::vector<std::string>> found, checked;
  for (const FittedValue& value : fit.values) {
    found.push_back({value.name, fmt::format("{:.4g}", value.value),
                     value.deviation > 0 ? fmt::format("{:.2g}", value.deviation) : "-",
                     value.unit.empty() ? "-" : value.unit});
  }
  page.add_table({"", "value", "standard deviation", "unit"}, found);
  report::LineChart gains;
  gains.title = "Gain of each texel";
  gains.x_label = "texel, row by row from the fingertip";
  gains.y_label = "relative to the mean";
  report::Series series{"gain", {}, fit.gain_deviations, false};
  for (std::size_t i = 0; i < fit.calibration.gains.size(); ++i) {
    series.points.emplace_back(static_cast<double>(i), fit.calibration.gains[i]);
  }
  if (series.deviations.size() != series.points.size()) series.deviations.clear();
  if (!series.points.empty()) {
    gains.series.push_back(series);
    page.add_chart(report::draw_line_chart(gains), "0: a dead texel.");
  }
  page.add_heading("Presses that were not used");
  for (const Checked& one : checks) {
    checked.push_back({one.file, fmt::format("{:.3g}", one.check.most_force),
                       fmt::format("{:.2g}", one.check.off),
                       fmt::format("{:.2g}", 100 * one.check.off / one.check.most_force),
                       fmt::format("{:.2g}", one.check.most_off)});
  }
  if (checks.empty()) {
    page.add_answer("None were given (--check): how well others are predicted is not known.");
  } else {
    page.add_table({"log", "up to [N]", "off [N]", "off [%]", "at most off [N]"}, checked);
  }
  return page;
}

void run(const tools::PadFitChoices& choices) {
  const auto columns = named_columns(choices.columns);
  tools::Progress progress;
  progress.stage("reading " + choices.logs.front());
  const robot::PressingLog log =
      robot::read_pressing_log({choices.logs.begin(), choices.logs.end()}, columns);
  robot::PadFitOptions options;
  options.rows = choices.rows;
  options.columns = choices.texel_columns;
  options.texel_pitch = choices.pitch;
  options.full_scale = choices.full_scale;
  options.foam.creep_terms = choices.creep_terms;
  options.foam.hysteresis_terms = choices.hysteresis_terms;
  options.foam.progress = [&progress](int round, double off) {
    if (round % 10 != 0) return;
    progress.stage(fmt::format("fitting, round {}: forces off by {:.2g} %", round, 100 * off));
  };
  const PadFit fit = robot::fit_pad(log, options);
  std::vector<Checked> checks;
  for (const std::string& file : choices.checks) {
    progress.stage("checking " + file);
    const double area = log.texels * choices.pitch * choices.pitch / contact::kReferenceTexelArea;
    checks.push_back(
        {file, robot::check_foam(robot::read_pressing_log({file}, columns), fit.foam.law, area)});
  }
  progress.over();
  if (!choices.out.empty()) {
    geometry::write_whole_file(choices.out, robot::to_yaml(fit, log.name), "The calibration");
  }
  if (!choices.report.empty()) residual_page(fit, log.name, checks).write(choices.report);
  choices.json ? print_json(fit, checks) : print_text(fit, checks);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Finds what a tactile pad is like from presses"};
  tools::PadFitChoices choices;
  tools::add_pad_fit_options(app, choices);
  if (const auto code = text::parse_command_line(app, argc, argv)) return *code;
  try {
    run(choices);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend calibrate tactile: %s\n", error.what());
    return 1;
  }
  return 0;
}
