#include "eval/grasp/grasp_report.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "eval/grasp/share_bounds.h"
#include "eval/grasp/success_fit.h"
#include "eval/grasp/surprise_totals.h"
#include "eval/text_files.h"
#include "prehend/planning/decision.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/text/json.h"

namespace prehend::eval {
namespace {

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return kUnknown;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::vector<std::string> distinct(const std::vector<GraspCase>& cases,
                                  const std::function<std::string(const GraspCase&)>& name_of) {
  std::vector<std::string> names;
  for (const GraspCase& one : cases) {
    const std::string name = name_of(one);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

std::vector<std::string> platforms_of(const std::vector<GraspCase>& cases) {
  return distinct(cases, [](const GraspCase& one) { return one.platform; });
}

std::vector<std::string> groups_of(const std::vector<GraspCase>& cases) {
  return distinct(cases, [](const GraspCase& one) { return one.group; });
}

std::vector<std::string> settings_of(const std::vector<GraspCase>& cases) {
  std::vector<std::string> names;
  for (const GraspCase& one : cases) {
    for (const GraspTrial& trial : one.executed()) {
      if (std::find(names.begin(), names.end(), trial.setting) == names.end()) {
        names.push_back(trial.setting);
      }
    }
  }
  return names;
}

std::vector<GraspCase> selected(const std::vector<GraspCase>& cases,
                                const std::function<bool(const GraspCase&)>& wanted) {
  std::vector<GraspCase> result;
  std::copy_if(cases.begin(), cases.end(), std::back_inserter(result), wanted);
  return result;
}

GraspTotals totals_of(const std::vector<GraspCase>& cases, const std::string& platform,
                      const std::string& setting) {
  GraspTotals totals;
  totals.platform = platform;
  totals.setting = setting;
  std::vector<double> slips, contacts, areas, openings, seconds;
  for (const GraspCase& one : cases) {
    const GraspTrial* trial = one.trial(setting);
    if (one.platform != platform || trial == nullptr || !one.fits()) continue;
    ++totals.cases;
    totals.unplanned += trial->grasps == 0 ? 1 : 0;
    totals.first += trial->lifted_at_first() ? 1 : 0;
    totals.within_three += trial->lifted ? 1 : 0;
    if (trial->lifted) slips.push_back(trial->slip);
    contacts.push_back(trial->contact_error);
    areas.push_back(std::abs(trial->area_error));
    openings.push_back(std::abs(trial->opening_error));
    seconds.push_back(trial->plan_seconds);
  }
  totals.slip = median(slips);
  totals.contact_error = median(contacts);
  totals.area_error = median(areas);
  totals.opening_error = median(openings);
  totals.plan_seconds = median(seconds);
  return totals;
}

std::string share_text(int part, int whole) {
  return whole > 0 ? fmt::format("{} of {} ({:.0f} %)", part, whole, 100.0 * part / whole) : "-";
}

std::string bounds_text(int part, int whole) {
  return whole > 0 ? to_string(share_bounds(part, whole)) : "-";
}

std::string millimetres(double metres) {
  return std::isnan(metres) ? "-" : fmt::format("{:.2f}", metres * 1e3);
}

using Rows = std::vector<std::vector<std::string>>;
const std::vector<std::string> kTotalsHeader{"platform",
                                             "group",
                                             "planned on",
                                             "at first",
                                             "95 % interval",
                                             "within three",
                                             "95 % interval",
                                             "no grasp",
                                             "slip [mm]",
                                             "contact error [mm]",
                                             "contact area error [%]",
                                             "opening error [mm]",
                                             "plan [ms]"};

Rows totals_rows(const std::vector<GraspCase>& cases) {
  Rows rows;
  for (const GraspTotals& t : grasp_totals(cases)) {
    rows.push_back(
        {t.platform, t.group, t.setting, share_text(t.first, t.cases),
         bounds_text(t.first, t.cases), share_text(t.within_three, t.cases),
         bounds_text(t.within_three, t.cases), fmt::format("{}", t.unplanned), millimetres(t.slip),
         millimetres(t.contact_error),
         std::isnan(t.area_error) ? "-" : fmt::format("{:.0f}", 100 * t.area_error),
         millimetres(t.opening_error),
         std::isnan(t.plan_seconds) ? "-" : fmt::format("{:.1f}", t.plan_seconds * 1e3)});
  }
  return rows;
}

std::vector<std::string> objects_header(const std::vector<GraspCase>& cases) {
  std::vector<std::string> header{"platform", "group", "object", "others", "fits"};
  for (const auto& setting : settings_of(cases)) {
    header.push_back(setting);
    header.emplace_back("95 % at first");
  }
  return header;
}

// For each setting: at first / within three.
Rows objects_rows(const std::vector<GraspCase>& cases) {
  Rows rows;
  for (const auto& platform : platforms_of(cases)) {
    const auto of_platform =
        selected(cases, [&](const GraspCase& c) { return c.platform == platform; });
    const auto name_of = [](const GraspCase& c) { return c.group + "/" + c.data_set; };
    for (const auto& object : distinct(of_platform, name_of)) {
      const auto views =
          selected(of_platform, [&](const GraspCase& c) { return name_of(c) == object; });
      const auto fitting =
          std::count_if(views.begin(), views.end(), [](const GraspCase& c) { return c.fits(); });
      const GraspCase& first = views.front();
      rows.push_back({platform, first.group, first.data_set,
                      first.others == 0 ? "-" : fmt::format("{} fixed", first.others),
                      fmt::format("{} of {}", fitting, views.size())});
      for (const auto& setting : settings_of(cases)) {
        const GraspTotals t = totals_of(views, platform, setting);
        rows.back().push_back(t.cases > 0 ? fmt::format("{} / {}", t.first, t.within_three) : "-");
        rows.back().push_back(bounds_text(t.first, t.cases));
      }
    }
  }
  return rows;
}

// Reasons with their figures left out, so that they can be counted.
std::string without_numbers(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!digit) {
      result += c;
    } else if (result.empty() || result.back() != '#') {
      result += '#';
    }
  }
  return result;
}

const std::vector<std::string> kReasonsHeader{"platform", "planned on", "stage", "cases",
                                              "why not at first"};

std::string why_not_at_first(const GraspTrial& trial) {
  if (trial.grasps == 0) return trial.problem;
  if (!trial.lifted) return trial.outcome.empty() ? trial.problem : trial.outcome;
  return "lifted by a later attempt" + (trial.stage.empty() ? "" : "; the first: " + trial.outcome);
}

Rows reasons_rows(const std::vector<GraspCase>& cases) {
  std::map<std::vector<std::string>, int> counts;
  for (const GraspCase& one : cases) {
    if (!one.fits()) continue;
    for (const GraspTrial& trial : one.executed()) {
      if (trial.lifted_at_first()) continue;
      ++counts[{one.platform, trial.setting, trial.stage.empty() ? "-" : trial.stage,
                without_numbers(why_not_at_first(trial))}];
    }
  }
  Rows rows;
  for (const auto& [key, count] : counts) {
    rows.push_back({key[0], key[1], key[2], fmt::format("{}", count), key[3]});
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return std::stoi(a[3]) > std::stoi(b[3]); });
  return rows;
}

std::string table_text(const std::vector<std::string>& header, const Rows& rows) {
  std::vector<std::size_t> widths;
  for (const auto& cell : header) widths.push_back(cell.size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      text += fmt::format("{:<{}}  ", row[i], i + 1 < row.size() ? widths[i] : 0);
    }
    text += "\n";
  };
  add(header);
  for (const auto& row : rows) add(row);
  return text + "\n";
}

struct Goal {
  std::string text;
  bool met = false;
};

// Of views lifted at the first attempt, planned on the prediction.
double first_goal(const std::string& platform) { return platform == "pa10_barrett" ? 0.94 : 0.95; }

// At first and within three attempts, of objects that fit.
std::vector<Goal> goals_of(const std::vector<GraspCase>& cases) {
  std::vector<Goal> goals;
  for (const auto& platform : platforms_of(cases)) {
    const GraspTotals predicted = totals_of(cases, platform, to_string(PlannedOn::kPredicted));
    const GraspTotals delaunay = totals_of(cases, platform, to_string(PlannedOn::kDelaunay));
    if (predicted.cases == 0) continue;
    const double first = first_goal(platform);
    goals.push_back({fmt::format("{}: {:.1f} % at the first attempt, goal {:.0f} %", platform,
                                 100 * predicted.first_share(), 100 * first),
                     predicted.first_share() >= first});
    if (platform == "stage_pg70") {
      goals.push_back({fmt::format("{}: {:.1f} % within three attempts, goal 97 %", platform,
                                   100 * predicted.within_three_share()),
                       predicted.within_three_share() >= 0.97});
    }
    if (delaunay.cases > 0) {
      goals.push_back({fmt::format("{}: {:.1f} % at the first attempt on the Delaunay baseline, "
                                   "goal: ten points below the prediction",
                                   platform, 100 * delaunay.first_share()),
                       delaunay.first_share() <= predicted.first_share() - 0.1});
    }
  }
  return goals;
}

const std::vector<std::string> kSuccessHeader{
    "predicted shapes", "first attempts", "lifted",           "held in none / all trials",
    "Brier score",      "of the share",   "calibration error"};

constexpr std::size_t kLeastAttempts = 10;  // that a line is fitted to

// How well the share of disturbed trials in which a grasp holds foretells its first attempt: of
// each platform and of all, by the line of the other objects, and of all by the one that ships.
std::vector<std::vector<std::string>> success_rows(const std::vector<GraspCase>& cases) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& name, const SuccessLine& line,
                       const SuccessCalibration& c) {
    rows.push_back({name, fmt::format("{}", c.attempts), fmt::format("{}", c.lifted),
                    fmt::format("{:.3f} / {:.3f}", line.of_none, line.of_all),
                    fmt::format("{:.4f}", c.brier), fmt::format("{:.4f}", c.brier_of_constant),
                    fmt::format("{:.1f} %", 100 * c.calibration_error)});
  };
  const auto fitted = [&](const std::string& name, const std::vector<KnownSuccess>& known) {
    if (known.size() >= kLeastAttempts) add(name, fit_success(known), cross_validated(known));
  };
  for (const auto& platform : platforms_of(cases)) {
    fitted(platform, first_attempts(selected(
                         cases, [&](const GraspCase& c) { return c.platform == platform; })));
  }
  const std::vector<KnownSuccess> known = first_attempts(cases);
  fitted("all", known);
  const planning::DecisionOptions ships;
  const SuccessLine line{ships.success_of_none, ships.success_of_all};
  if (known.size() >= kLeastAttempts) add("all, as ships", line, calibration_of(known, line));
  return rows;
}

std::string success_chart(const std::vector<GraspCase>& cases, const std::string& platform) {
  report::BarChart chart;
  chart.title = "Lifted at the first attempt: " + platform;
  chart.y_label = "share of views [%]";
  const auto of_platform =
      selected(cases, [&](const GraspCase& c) { return c.platform == platform && c.fits(); });
  chart.categories = distinct(of_platform, [](const GraspCase& c) { return c.data_set; });
  for (const auto& setting : settings_of(of_platform)) {
    report::BarChart::Bars bars;
    bars.name = setting;
    for (const auto& object : chart.categories) {
      const auto views =
          selected(of_platform, [&](const GraspCase& c) { return c.data_set == object; });
      bars.values.push_back(100 * totals_of(views, platform, setting).first_share());
    }
    chart.series.push_back(bars);
  }
  return draw_bar_chart(chart);
}

std::string cases_csv(const std::vector<GraspCase>& cases) {
  std::string csv =
      "platform,group,case,object,others,orientation_deg,setting,grasps,attempts,lifted,slip_m,"
      "contact_"
      "error_m,"
      "area_error,opening_error_m,robustness,guessed_contact,plan_s,stage,why\n";
  for (const GraspCase& one : cases) {
    for (const GraspTrial& t : one.executed()) {
      std::string why = t.outcome.empty() ? t.problem : t.outcome;
      std::replace(why.begin(), why.end(), '"', '\'');
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},\"{}\"\n",
                         one.platform, one.group, one.case_name, one.data_set, one.others,
                         one.orientation, t.setting, t.grasps, t.attempts, t.lifted, t.slip,
                         t.contact_error, t.area_error, t.opening_error, t.robustness,
                         t.guessed_contact, t.plan_seconds, t.stage, why);
    }
  }
  return csv;
}

}  // namespace

std::vector<GraspTotals> grasp_totals(const std::vector<GraspCase>& cases) {
  std::vector<GraspTotals> totals;
  const auto groups = groups_of(cases);
  for (const auto& platform : platforms_of(cases)) {
    const auto add = [&](const std::string& group, const std::vector<GraspCase>& of_group) {
      for (const auto& setting : settings_of(of_group)) {
        totals.push_back(totals_of(of_group, platform, setting));
        totals.back().group = group;
      }
    };
    for (const auto& group : groups) {
      add(group, selected(cases, [&](const GraspCase& c) {
            return c.platform == platform && c.group == group;
          }));
    }
    if (groups.size() > 1) add("all", cases);
  }
  return totals;
}

std::string grasp_text(const std::vector<GraspCase>& cases) {
  std::string text = table_text(kTotalsHeader, totals_rows(cases)) +
                     table_text(objects_header(cases), objects_rows(cases)) +
                     table_text(kReasonsHeader, reasons_rows(cases)) +
                     table_text(surprises_header(), surprises_rows(cases)) +
                     table_text(kSuccessHeader, success_rows(cases));
  for (const Goal& goal : goals_of(cases)) {
    text += fmt::format("{} {}\n", goal.met ? "met:   " : "missed:", goal.text);
  }
  return text;
}

std::string grasp_json(const std::vector<GraspCase>& cases) {
  text::Json totals = text::Json::array(), surprises = text::Json::array(),
             goals = text::Json::array();
  for (const GraspTotals& t : grasp_totals(cases)) {
    totals.add(text::Json::object()
                   .set("platform", t.platform)
                   .set("group", t.group)
                   .set("setting", t.setting)
                   .set("cases", t.cases)
                   .set("no_grasp", t.unplanned)
                   .set("first", t.first_share())
                   .set("first_low", share_bounds(t.first, t.cases).low)
                   .set("first_high", share_bounds(t.first, t.cases).high)
                   .set("within_three", t.within_three_share())
                   .set("within_three_low", share_bounds(t.within_three, t.cases).low)
                   .set("within_three_high", share_bounds(t.within_three, t.cases).high)
                   .set("slip_m", t.slip)
                   .set("contact_error_m", t.contact_error)
                   .set("contact_area_error", t.area_error)
                   .set("opening_error_m", t.opening_error)
                   .set("plan_s", t.plan_seconds));
  }
  for (const SurpriseTotals& t : surprise_totals(cases)) {
    surprises.add(text::Json::object()
                      .set("platform", t.platform)
                      .set("setting", t.setting)
                      .set("kind", to_string(t.kind))
                      .set("attempts", t.attempts)
                      .set("compared", t.compared)
                      .set("surprising", t.surprising)
                      .set("felt_less_predicted", t.difference));
  }
  for (const Goal& goal : goals_of(cases)) {
    goals.add(text::Json::object().set("goal", goal.text).set("met", goal.met));
  }
  return text::Json::object()
      .set("totals", totals)
      .set("surprises", surprises)
      .set("goals", goals)
      .pretty();
}

void write_grasp_report(const std::filesystem::path& folder, const std::vector<GraspCase>& cases) {
  report::Page page("Grasps planned on predicted shapes");
  page.add_paragraph(
      "Each object is seen once, by a rendered stereo pair; grasps are planned on the predicted "
      "shape, on the true one and on the Delaunay surface of what was seen, and executed in "
      "simulation on the true one. What else is in the scene is rendered and in the way, and does "
      "not move. Counted are views of objects that fit the hand: knowing the "
      "truth, the planner finds a grasp that holds in at least half of its disturbed trials. "
      "Intervals are Wilson's, of 95 %, as if the views of one object had nothing to do with each "
      "other.");
  for (const Goal& goal : goals_of(cases)) page.add_verdict(goal.text, goal.met);
  page.add_table(kTotalsHeader, totals_rows(cases));
  for (const auto& platform : platforms_of(cases)) {
    if (std::any_of(cases.begin(), cases.end(),
                    [&](const GraspCase& c) { return c.platform == platform && c.fits(); })) {
      page.add_chart(success_chart(cases, platform), "Views lifted at the first attempt");
    }
  }
  page.add_heading("Objects: views lifted at the first attempt / within three");
  page.add_table(objects_header(cases), objects_rows(cases));
  page.add_heading("Why not at the first attempt");
  page.add_table(kReasonsHeader, reasons_rows(cases));
  page.add_heading("Surprises");
  page.add_paragraph(
      "What was predicted against what was felt, each time that an act compared it; a surprise is "
      "beyond the tolerance of the cycle.");
  page.add_table(surprises_header(), surprises_rows(cases));
  page.add_heading("How sure grasps are");
  page.add_table(kSuccessHeader, success_rows(cases));
  page.write(folder / "index.html");
  write_text(folder / "cases.csv", cases_csv(cases));
}

}  // namespace prehend::eval
