#include "eval/grasp/stability_report.h"

#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "eval/text_files.h"
#include "prehend/report/charts.h"
#include "prehend/report/page.h"
#include "prehend/text/json.h"

namespace prehend::eval {
namespace {

using touch::GripMoment;

constexpr int kFolds = 10;
constexpr double kNotAsked = std::numeric_limits<double>::quiet_NaN();
const std::string kAll = "all";

// Standing and lying it is the same object.
std::string body_of(const std::string& data_set) {
  const std::string lying = "_lying";
  return data_set.ends_with(lying) ? data_set.substr(0, data_set.size() - lying.size()) : data_set;
}

const std::vector<std::string>& score_header() {
  static const std::vector<std::string> header{"asked",  "hand", "pads",     "model",
                                               "grasps", "held", "ROC area", "95 % of objects"};
  return header;
}

std::vector<std::string> score_row(const StabilityScore& score) {
  return {score.moment,
          score.hand,
          score.pads,
          score.model,
          std::to_string(score.grasps),
          std::to_string(score.held),
          fmt::format("{:.3f}", score.area),
          fmt::format("{:.3f} to {:.3f}", score.bounds.low, score.bounds.high)};
}

}  // namespace

std::vector<std::pair<std::size_t, KnownHold>> known_holds(
    const std::vector<StabilityTrial>& trials, GripMoment moment) {
  std::vector<std::pair<std::size_t, KnownHold>> known;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const StabilityTrial& trial = trials[i];
    const bool lifting = moment == GripMoment::kLifting;
    if (!trial.counts() || (lifting && trial.lifting.frames.empty())) continue;
    const Eigen::VectorXd features = lifting ? touch::grip_features(trial.closed, trial.lifting)
                                             : touch::grip_features(trial.closed);
    known.push_back({i, {features, trial.held, body_of(trial.object), trial.platform}});
  }
  return known;
}

StabilityFindings stability_findings(const std::vector<StabilityTrial>& trials) {
  StabilityFindings findings;
  findings.trials = static_cast<int>(trials.size());
  for (const StabilityTrial& trial : trials) {
    findings.counted += trial.counts() ? 1 : 0;
    findings.lost_before += trial.counts() && trial.lifting.frames.empty() ? 1 : 0;
  }
  std::set<std::string> hands{};
  for (const StabilityTrial& trial : trials) hands.insert(trial.platform);
  for (const GripMoment moment : {GripMoment::kClosed, GripMoment::kLifting}) {
    const auto indexed = known_holds(trials, moment);
    std::vector<KnownHold> known;
    for (const auto& [index, one] : indexed) known.push_back(one);
    std::vector<double>& asked = moment == GripMoment::kClosed ? findings.closed : findings.lifting;
    asked.assign(trials.size(), kNotAsked);
    for (const bool each : {false, true}) {
      const std::vector<double> said = crossed_probabilities(known, kFolds, each);
      const auto score = [&](const std::string& hand, const std::string& pads) {
        StabilityScore result;
        result.moment = to_string(moment);
        result.hand = hand;
        result.pads = pads;
        result.model = each ? "each" : "one";
        std::vector<Answer> answers;
        std::vector<std::string> objects;
        for (std::size_t k = 0; k < known.size(); ++k) {
          const bool realistic = trials[indexed[k].first].realistic;
          if (std::isnan(said[k]) || (hand != kAll && known[k].hand != hand)) continue;
          if (pads != kAll && realistic != (pads == "realistic")) continue;
          answers.emplace_back(said[k], known[k].held);
          objects.push_back(known[k].object);
          result.held += known[k].held ? 1 : 0;
        }
        result.grasps = static_cast<int>(answers.size());
        result.area = roc_area(answers);
        result.bounds = area_bounds(answers, objects);
        result.curve = roc_curve(answers);
        findings.scores.push_back(std::move(result));
      };
      score(kAll, kAll);
      for (const std::string& hand : hands) score(hand, kAll);
      if (each) continue;
      for (const char* pads : {"ideal", "realistic"}) score(kAll, pads);
      for (std::size_t k = 0; k < known.size(); ++k) asked[indexed[k].first] = said[k];
    }
  }
  return findings;
}

std::string stability_text(const StabilityFindings& findings) {
  std::string text = fmt::format(
      "{} trials, {} closed and felt something, {} of these ended before the hand had risen by "
      "{:.0f} mm\n",
      findings.trials, findings.counted, findings.lost_before, 1e3 * kAsked);
  text += fmt::format("{:9} {:14} {:10} {:6} {:>7} {:>6}  {:8}  {}\n", "asked", "hand", "pads",
                      "model", "grasps", "held", "ROC area", "95 %, objects drawn anew");
  for (const StabilityScore& score : findings.scores) {
    text += fmt::format("{:9} {:14} {:10} {:6} {:7} {:6}  {:8.3f}  {:.3f} to {:.3f}\n",
                        score.moment, score.hand, score.pads, score.model, score.grasps, score.held,
                        score.area, score.bounds.low, score.bounds.high);
  }
  return text;
}

std::string stability_json(const StabilityFindings& findings) {
  text::Json json = text::Json::object();
  json.set("trials", static_cast<double>(findings.trials));
  json.set("grasps", static_cast<double>(findings.counted));
  json.set("lost_before", static_cast<double>(findings.lost_before));
  text::Json scores = text::Json::array();
  for (const StabilityScore& score : findings.scores) {
    text::Json one = text::Json::object();
    one.set("asked", score.moment).set("hand", score.hand).set("pads", score.pads);
    one.set("model", score.model);
    one.set("grasps", static_cast<double>(score.grasps));
    one.set("held", static_cast<double>(score.held));
    one.set("area", score.area).set("low", score.bounds.low).set("high", score.bounds.high);
    scores.add(one);
  }
  json.set("scores", scores);
  return json.pretty();
}

void write_stability_report(const std::filesystem::path& folder, const StabilityFindings& findings,
                            const std::vector<StabilityTrial>& trials) {
  report::Page page("Whether a lift will hold, by touch alone");
  page.add_paragraph(fmt::format(
      "{} trials; {} closed and felt something, of which {} ended before the hand had risen by "
      "{:.0f} mm. Every object is answered by a model of the others.",
      findings.trials, findings.counted, findings.lost_before, 1e3 * kAsked));
  for (const GripMoment moment : {GripMoment::kClosed, GripMoment::kLifting}) {
    report::LineChart chart{"Asked: " + to_string(moment),
                            "share of those lost that are let pass",
                            "share of those held that are let pass",
                            {},
                            {}};
    for (const StabilityScore& score : findings.scores) {
      if (score.moment != to_string(moment) || score.model != "one" || score.pads != kAll) continue;
      if (!std::isfinite(score.area)) continue;
      chart.series.push_back({fmt::format("{} ({:.3f})", score.hand, score.area), score.curve});
    }
    if (!chart.series.empty()) page.add_chart(report::draw_line_chart(chart), chart.title);
  }
  std::vector<std::vector<std::string>> rows;
  for (const StabilityScore& score : findings.scores) rows.push_back(score_row(score));
  page.add_table(score_header(), rows);
  page.write(folder / "index.html");
  std::string csv =
      "platform,object,pads,across,along,yaw,depth,force,mass,friction,closed,held,slide,raised,"
      "probability_closed,probability_lifting,reason\n";
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const StabilityTrial& t = trials[i];
    const Disturbance& by = t.disturbance;
    std::string reason = t.reason;
    for (char& c : reason) c = c == ',' || c == '"' || c == '\n' ? ' ' : c;
    csv += fmt::format(
        "{},{},{},{:.4g},{:.4g},{:.3g},{:.3g},{:.3g},{:.3g},{:.3g},{},{},{:.3g},"
        "{:.3g},{:.4g},{:.4g},{}\n",
        t.platform, t.object, t.realistic ? "realistic" : "ideal", by.across, by.along, by.yaw,
        by.depth, by.force, by.mass, by.friction, t.counts() ? 1 : 0, t.held ? 1 : 0, t.slide,
        t.raised, findings.closed[i], findings.lifting[i], reason);
  }
  write_text(folder / "trials.csv", csv);
}

touch::GraspStability fitted_stability(const std::vector<StabilityTrial>& trials) {
  const auto fit = [&](GripMoment moment) {
    std::vector<KnownHold> known;
    for (auto& [index, one] : known_holds(trials, moment)) known.push_back(std::move(one));
    return fit_stability(known);
  };
  return {fit(GripMoment::kClosed), fit(GripMoment::kLifting)};
}

}  // namespace prehend::eval
