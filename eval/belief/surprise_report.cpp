#include "eval/belief/surprise_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "eval/grasp/stability_fit.h"
#include "eval/text_files.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/text/json.h"

namespace prehend::eval {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
const char* const kAllGroups = "all";
const char* const kTotalBits = "total";

/// An act and what is made of it.
struct JudgedAct {
  const SurpriseCase* of;
  const SurpriseAct* act;
  belief::PerceptSurprise surprise;

  bool is_right() const { return act->truth == ActTruth::kRight; }
  double bits(const std::string& sense) const {
    if (sense == kTotalBits) return surprise.bits;
    for (const belief::SenseSurprise& one : surprise.senses) {
      if (one.sense == sense) return one.bits;
    }
    return kNone;
  }
  bool alarm(const std::string& sense) const {
    if (sense == kTotalBits) return surprise.alarm;
    for (const belief::SenseSurprise& one : surprise.senses) {
      if (one.sense == sense) return one.alarm;
    }
    return false;
  }
};

std::vector<JudgedAct> judged(const std::vector<SurpriseCase>& cases,
                              const belief::SurpriseModel& model) {
  std::vector<JudgedAct> all;
  for (const SurpriseCase& one : cases) {
    for (const SurpriseAct& act : one.acts) {
      all.push_back({&one, &act, belief::percept_surprise(one.predicted, act.act.percepts, model)});
    }
  }
  return all;
}

double share(int part, int all) { return all > 0 ? static_cast<double>(part) / all : kNone; }

SenseScore score(const std::vector<JudgedAct>& acts, const std::string& objects,
                 const std::string& sense) {
  SenseScore score{objects, sense, 0, 0, 0, 0, kNone, {}, {}};
  std::vector<Answer> answers;
  int alarms = 0, detected = 0;
  std::vector<int> count(act_truths().size()), found(act_truths().size());
  for (const JudgedAct& one : acts) {
    if (objects != kAllGroups && one.of->group != objects) continue;
    const bool alarm = one.alarm(sense);
    (one.is_right() ? score.right : score.others) += 1;
    (one.is_right() ? alarms : detected) += alarm;
    const auto truth = static_cast<std::size_t>(one.act->truth);
    count[truth] += 1;
    found[truth] += alarm;
    if (std::isfinite(one.bits(sense))) answers.emplace_back(one.bits(sense), !one.is_right());
  }
  score.false_alarms = share(alarms, score.right);
  score.detected = share(detected, score.others);
  if (!answers.empty() && score.right > 0 && score.others > 0) {
    score.area = roc_area(answers);
    score.curve = roc_curve(answers);
  }
  for (std::size_t i = 1; i < count.size(); ++i)
    score.by_truth.push_back(share(found[i], count[i]));
  return score;
}

std::string percent(double value) {
  return std::isfinite(value) ? fmt::format("{:.1f} %", 100 * value) : "-";
}

std::vector<std::string> header() {
  std::vector<std::string> names{"objects",      "sense",    "right",   "others",
                                 "false alarms", "detected", "ROC area"};
  for (const ActTruth truth : act_truths()) {
    if (truth != ActTruth::kRight) names.push_back(to_string(truth));
  }
  return names;
}

std::vector<std::string> row(const SenseScore& score) {
  std::vector<std::string> cells{
      score.objects,
      score.sense,
      std::to_string(score.right),
      std::to_string(score.others),
      percent(score.false_alarms),
      percent(score.detected),
      std::isfinite(score.area) ? fmt::format("{:.3f}", score.area) : "-"};
  for (const double value : score.by_truth) cells.push_back(percent(value));
  return cells;
}

std::string summary(const SurpriseFindings& findings) {
  return fmt::format(
      "{} cases, {} of them without a grasp or a prediction, {} acts left out as none of what is "
      "asked for; a prediction takes {:.2f} s of processor for each shape (median); right "
      "predictions give {:.1f} bits, standard deviation {:.1f}.\n",
      findings.cases, findings.without, findings.left_out, findings.prediction_seconds,
      findings.bits_right, findings.deviation_right);
}

}  // namespace

SurpriseFindings surprise_findings(const std::vector<SurpriseCase>& cases,
                                   const belief::SurpriseModel& model) {
  SurpriseFindings findings;
  std::vector<double> seconds;
  std::set<std::string> groups;
  for (const SurpriseCase& one : cases) {
    ++findings.cases;
    findings.without += !one.problem.empty();
    findings.left_out += one.left_out;
    if (one.shapes > 0) seconds.push_back(one.prediction_seconds);
    if (!one.acts.empty()) groups.insert(one.group);
  }
  if (!seconds.empty()) {
    std::nth_element(seconds.begin(), seconds.begin() + seconds.size() / 2, seconds.end());
    findings.prediction_seconds = seconds[seconds.size() / 2];
  }
  const std::vector<JudgedAct> acts = judged(cases, model);
  double sum = 0, squares = 0;
  int right = 0;
  for (const JudgedAct& one : acts) {
    if (!one.is_right()) continue;
    sum += one.surprise.bits;
    squares += one.surprise.bits * one.surprise.bits;
    ++right;
  }
  if (right > 0) {
    findings.bits_right = sum / right;
    findings.deviation_right =
        std::sqrt(std::max(0.0, squares / right - findings.bits_right * findings.bits_right));
  }
  std::vector<std::string> objects(groups.begin(), groups.end());
  objects.emplace_back(kAllGroups);
  std::vector<std::string> senses = belief::percept_senses();
  senses.emplace_back(kTotalBits);
  for (const std::string& group : objects) {
    for (const std::string& sense : senses) findings.scores.push_back(score(acts, group, sense));
  }
  return findings;
}

std::string surprise_text(const SurpriseFindings& findings) {
  std::string text = summary(findings);
  std::vector<std::vector<std::string>> rows{header()};
  for (const SenseScore& score : findings.scores) rows.push_back(row(score));
  for (const auto& cells : rows) {
    std::string line;
    for (const std::string& cell : cells) line += fmt::format("{:13}", cell);
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string surprise_json(const SurpriseFindings& findings) {
  text::Json json = text::Json::object();
  json.set("cases", static_cast<double>(findings.cases));
  json.set("without", static_cast<double>(findings.without));
  json.set("left_out", static_cast<double>(findings.left_out));
  json.set("prediction_seconds", findings.prediction_seconds);
  json.set("bits_right", findings.bits_right);
  json.set("deviation_right", findings.deviation_right);
  text::Json scores = text::Json::array();
  for (const SenseScore& score : findings.scores) {
    text::Json one = text::Json::object();
    one.set("objects", score.objects).set("sense", score.sense);
    one.set("right", static_cast<double>(score.right));
    one.set("others", static_cast<double>(score.others));
    // What there is none of is left out: JSON has no NaN.
    const auto set = [&one](const std::string& name, double value) {
      if (std::isfinite(value)) one.set(name, value);
    };
    set("false_alarms", score.false_alarms);
    set("detected", score.detected);
    set("area", score.area);
    for (std::size_t i = 0; i < score.by_truth.size(); ++i) {
      set(to_string(act_truths()[i + 1]), score.by_truth[i]);
    }
    text::Json curve = text::Json::array();
    for (const auto& [x, y] : score.curve) {
      text::Json point = text::Json::object();
      point.set("false_alarms", x).set("detected", y);
      curve.add(point);
    }
    one.set("curve", curve);
    scores.add(one);
  }
  json.set("scores", scores);
  return json.pretty();
}

void write_surprise_report(const std::filesystem::path& folder, const SurpriseFindings& findings,
                           const std::vector<SurpriseCase>& cases,
                           const belief::SurpriseModel& model) {
  report::Page page("Surprise: what was perceived against what was to be");
  page.add_paragraph(summary(findings));
  std::vector<report::LineChart> charts;
  for (const SenseScore& score : findings.scores) {
    if (score.curve.empty()) continue;
    if (charts.empty() || charts.back().title != score.objects) {
      charts.push_back({score.objects,
                        "share of right predictions that raise an alarm",
                        "share of the others that are detected",
                        {},
                        {}});
    }
    charts.back().series.push_back(
        {fmt::format("{} ({:.3f})", score.sense, score.area), score.curve});
  }
  for (const report::LineChart& chart : charts) {
    page.add_chart(report::draw_line_chart(chart), "ROC curves: " + chart.title);
  }
  std::vector<std::vector<std::string>> rows;
  for (const SenseScore& score : findings.scores) rows.push_back(row(score));
  page.add_table(header(), rows);
  rows.clear();
  for (const SurpriseCase& one : cases) {
    if (!one.problem.empty()) rows.push_back({one.name, one.problem});
  }
  if (!rows.empty()) page.add_table({"case", "why nothing was done"}, rows);
  page.write(folder / "index.html");
  std::string csv = "case,group,shape_off,shape_95,truth,off,slide,raised,alarm,total";
  for (const std::string& sense : belief::percept_senses()) csv += "," + sense;
  csv += "\n";
  for (const JudgedAct& one : judged(cases, model)) {
    csv += fmt::format("{},{},{:.4g},{:.4g},{},{:.4g},{:.4g},{:.4g},{},{:.2f}", one.of->name,
                       one.of->group, one.of->shape_off.mean, one.of->shape_off.percentile_95,
                       to_string(one.act->truth), one.act->off, one.act->act.slide,
                       one.act->act.raised, one.surprise.alarm ? 1 : 0, one.surprise.bits);
    for (const std::string& sense : belief::percept_senses()) {
      csv += fmt::format(",{:.2f}", one.bits(sense));
    }
    csv += "\n";
  }
  write_text(folder / "acts.csv", csv);
}

belief::SurpriseModel fitted_surprise(const std::vector<SurpriseCase>& cases,
                                      const std::string& group, double false_alarms,
                                      const robot::HandModel& hand) {
  std::vector<belief::KnownPercepts> right;
  for (const SurpriseCase& one : cases) {
    if (one.group != group) continue;
    for (const SurpriseAct& act : one.acts) {
      if (act.truth == ActTruth::kRight) right.push_back({&one.predicted, &act.act.percepts});
    }
  }
  // When a jaw stops says little: it comes fast to where it is to touch. Where it touches says
  // more.
  return belief::fit_surprise(right, false_alarms, hand.gripper ? "contact" : "time");
}

}  // namespace prehend::eval
