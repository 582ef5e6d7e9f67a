// What recognition by imprints leaves open, chosen on shapes, pads and presses that
// eval_shape_recognition never uses: how far a learned map is blurred, its contrast, and how much
// worse than its own presses a press may fit.

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "eval/touch/experiment.h"
#include "eval/touch/imprint_trials.h"

namespace {

using namespace prehend;
using namespace prehend::eval::touch;
using prehend::touch::ImprintMemory;
using prehend::touch::ImprintOptions;

constexpr std::array kTogether{1, 2, 4, 8};
constexpr int kKnownShapes = 7;
constexpr int kLimits = 40;  // of patience that are tried, in steps
constexpr double kLimitStep = 0.2;

struct Setting {
  double blur, contrast;
};
constexpr std::array<Setting, 6> kSettings{
    {{1e-3, 1}, {1e-3, 2.5}, {1.4e-3, 1}, {1.4e-3, 2.5}, {1.4e-3, 4}, {1.7e-3, 2.5}}};

// Which of ten shapes are taught: all ways to leave three out, or each sixth.
std::vector<std::vector<std::string>> taught_sets(bool quick) {
  std::vector<std::string> names;
  for (const Hole& hole : holes_to_choose_on()) names.push_back(hole.name);
  std::vector<bool> known(names.size(), false);
  std::fill(known.begin(), known.begin() + kKnownShapes, true);
  std::vector<std::vector<std::string>> sets;
  int k = 0;
  do {
    if (k++ % (quick ? 24 : 6) != 0) continue;
    sets.emplace_back();
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (known[i]) sets.back().push_back(names[i]);
    }
  } while (std::prev_permutation(known.begin(), known.end()));
  return sets;
}

// Shares of right answers with each limit, asked with each number of presses.
using Shares = std::array<std::array<double, kLimits>, kTogether.size()>;

void add_shares(const BlockPresses& presses, const Setting& setting, bool quick, double weight,
                Shares* shares) {
  const ImprintOptions options{.blur = setting.blur, .contrast = setting.contrast};
  ImprintMemory all(options);
  for (const auto& [name, hole] : presses.of) all.teach(name, hole.taught);
  const FitsOfHoles fits = fits_of(presses, all);
  const auto sets = taught_sets(quick);
  for (const auto& taught : sets) {
    ImprintMemory memory(options, 1);  // a misfit of 1 is one deviation
    for (const std::string& name : taught) memory.teach(name, all.faces().at(name));
    for (std::size_t n = 0; n < kTogether.size(); ++n) {
      const auto answers = ask_all(memory, fits, kTogether[n]);
      const double one =
          weight / static_cast<double>(sets.size()) / static_cast<double>(answers.size());
      for (const auto& [shown, answer] : answers) {
        const auto& likeliest = answer.candidates.front();
        const bool known = memory.faces().contains(shown);
        for (int k = 0; k < kLimits; ++k) {
          const bool accepted = likeliest.misfit <= (k + 1) * kLimitStep;
          (*shares)[n][k] += one * (known ? accepted && likeliest.name == shown : !accepted);
        }
      }
    }
  }
}

Findings shape_choice(const ExperimentOptions& options, report::Page& page) {
  Findings findings;
  findings.title = "choices of shape recognition";
  const std::size_t pads = options.quick ? 1 : kChoosingSeeds.size();
  std::vector<BlockPresses> presses;
  for (std::size_t k = 0; k < pads; ++k) {
    presses.push_back(
        press_blocks(holes_to_choose_on(), true, kChoosingSeeds[k], options.quick ? 16 : 32));
  }
  std::vector<Row> rows;
  double best = -1;
  Setting chosen{};
  double patience = 0;
  for (const Setting& setting : kSettings) {
    Shares shares{};
    for (const BlockPresses& of_pads : presses) {
      add_shares(of_pads, setting, options.quick, 1.0 / static_cast<double>(pads), &shares);
    }
    const auto mean = [&](int limit) {
      double sum = 0;
      for (const auto& of_number : shares) sum += of_number[limit] / kTogether.size();
      return sum;
    };
    int limit = 0;
    for (int k = 1; k < kLimits; ++k) {
      if (mean(k) > mean(limit)) limit = k;
    }
    Row row{{"blur_mm", 1e3 * setting.blur},
            {"contrast", setting.contrast},
            {"patience", (limit + 1) * kLimitStep}};
    for (std::size_t n = 0; n < kTogether.size(); ++n) {
      row.push_back({fmt::format("right_{}", kTogether[n]), shares[n][limit]});
    }
    rows.push_back(row);
    if (mean(limit) > best) {
      best = mean(limit);
      chosen = setting;
      patience = (limit + 1) * kLimitStep;
    }
  }
  page.add_paragraph(fmt::format(
      "{} pairs of realistic pads, ten shapes; {} of them are taught, in {} ways. The patience is "
      "the one with the greatest mean of the shares asked with 1, 2, 4 and 8 presses.",
      pads, kKnownShapes, taught_sets(options.quick).size()));
  add_table(page, rows);
  const ImprintOptions shipped;
  const bool same = chosen.blur == shipped.blur && chosen.contrast == shipped.contrast &&
                    std::abs(patience - prehend::touch::kImprintPatience) < 1e-9;
  page.add_verdict(same ? "These are the library's defaults" : "The library's defaults are others",
                   same);
  findings.summary = {{"blur_mm", 1e3 * chosen.blur},
                      {"contrast", chosen.contrast},
                      {"patience", patience},
                      {"mean_right", best},
                      {"are_the_defaults", same}};
  findings.tables = {{"settings", rows}};
  return findings;
}

}  // namespace

int main(int argc, char** argv) {
  return run_experiment(argc, argv, "Choices of recognition by imprints", shape_choice);
}
