#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "eval/grasp/chain_extremes.h"
#include "prehend/report/cell_map.h"

namespace prehend::eval {
namespace {

using Cases = std::vector<ExtremeCase>;
using report::CellMap;

constexpr int kMapsAcross = 2;

// The shortest part of a message that tells its reason: no figures of the place, no mend.
std::string short_reason(const std::string& message) {
  constexpr std::size_t kMost = 130;
  std::string reason = message.substr(0, message.find_first_of(";\n"));
  std::replace(reason.begin(), reason.end(), '|', '/');
  return reason.size() <= kMost ? reason : reason.substr(0, kMost) + " ...";
}

// The first reason of the worst outcome; empty when all work.
std::string reason_of(const Cases& cases, const ExtremeResults& results) {
  const ExtremeResult* worst = nullptr;
  for (const ExtremeCase& one : cases) {
    const auto found = results.find(one.name());
    if (found == results.end()) return "crashed: " + one.name();
    if (found->second.outcome == ExtremeOutcome::kWorks) continue;
    if (worst == nullptr || found->second.outcome > worst->outcome) worst = &found->second;
  }
  return worst == nullptr ? "" : worst->stage + ": " + short_reason(worst->message);
}

CellMap::Cell cell_of(const Cases& cases, const ExtremeResults& results) {
  const ExtremeTotals sum = totals(cases, results);
  CellMap::Cell cell;
  cell.hint = fmt::format("{} of {} work, {} refused, {} said to be wrong, {} wrong in silence. {}",
                          sum.works, sum.cases, sum.refused, sum.said, sum.silent,
                          reason_of(cases, results));
  cell.text = fmt::format("{} of {}", sum.works, sum.cases);
  if (sum.crashed > 0 || sum.silent > 0) {
    cell.kind = CellMap::Kind::kBad;
    cell.text = sum.crashed > 0 ? "crash" : fmt::format("{} silent", sum.silent);
  } else if (sum.works == sum.cases) {
    cell.kind = CellMap::Kind::kGood;
  } else if (sum.works == 0 && sum.said == 0) {
    cell.kind = CellMap::Kind::kRefused;
    cell.text = "refused";
  } else {
    cell.kind = CellMap::Kind::kLimit;
    if (sum.works == 0) cell.text = sum.refused == 0 ? "said" : "said, ref.";
  }
  return cell;
}

Cases with_seeds(ExtremeCase one, const std::vector<std::string>& objects,
                 const ExtremeGrid& grid) {
  Cases cases;
  for (const std::string& object : objects) {
    for (const std::uint64_t seed : grid.seeds) {
      one.object = object;
      one.seed = seed;
      cases.push_back(one);
    }
  }
  return cases;
}

std::string label(const ExtremeAxis& axis) {
  return axis.unit.empty() ? axis.name : axis.name + " [" + axis.unit + "]";
}

std::vector<std::string> texts_of(const ExtremeAxis& axis) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < axis.values.size(); ++i) texts.push_back(axis.text(i));
  return texts;
}

CellMap map_of(const ExtremeAxis& axis, const ExtremeGrid& grid, const ExtremeResults& results) {
  CellMap map{"", "", label(axis), grid.objects, texts_of(axis), {}};
  for (const std::string& object : grid.objects) {
    for (const double value : axis.values) {
      ExtremeCase one;
      one.*axis.value = value;
      map.cells.push_back(cell_of(with_seeds(one, {object}, grid), results));
    }
  }
  return map;
}

CellMap map_of(const ExtremePair& pair, const ExtremeGrid& grid, const ExtremeResults& results) {
  CellMap map{label(pair.rows) + " down, " + label(pair.columns) + " across",
              "",
              "",
              texts_of(pair.rows),
              texts_of(pair.columns),
              {}};
  for (const double row : pair.rows.values) {
    for (const double column : pair.columns.values) {
      ExtremeCase one;
      one.*pair.rows.value = row;
      one.*pair.columns.value = column;
      map.cells.push_back(cell_of(with_seeds(one, grid.objects, grid), results));
    }
  }
  return map;
}

std::string table_of(const ExtremeAxis& axis, const ExtremeGrid& grid,
                     const ExtremeResults& results) {
  std::string rows = fmt::format(
      "| {} | work | refused | said | silent | the worst says, for one |\n"
      "|---|---|---|---|---|---|\n",
      label(axis));
  for (std::size_t i = 0; i < axis.values.size(); ++i) {
    ExtremeCase one;
    one.*axis.value = axis.values[i];
    const Cases cases = with_seeds(one, grid.objects, grid);
    const ExtremeTotals sum = totals(cases, results);
    rows += fmt::format("| {} | {} | {} | {} | {} | {} |\n", axis.text(i), sum.works, sum.refused,
                        sum.said, sum.silent, reason_of(cases, results));
  }
  return rows + "\n";
}

// The slowest case, and that with most memory.
std::string cost_in_words(const Cases& cases, const ExtremeResults& results) {
  double seconds = 0, memory = 0;
  std::string slowest, largest;
  for (const ExtremeCase& one : cases) {
    const auto found = results.find(one.name());
    if (found == results.end()) continue;
    const double took = found->second.see_seconds + found->second.rest_seconds;
    if (took > seconds) seconds = took, slowest = one.name();
    if (found->second.memory > memory) memory = found->second.memory, largest = one.name();
  }
  return fmt::format(
      "The slowest case took {:.1f} s of one processor from the depth picture to the end of the "
      "cycle ({}), the largest {:.1f} GB, its rendering included ({}).",
      seconds, slowest, memory / 1e9, largest);
}

// Each case that is wrong in silence, as a list.
std::string silent_cases(const Cases& cases, const ExtremeResults& results) {
  std::string list;
  for (const ExtremeCase& one : cases) {
    const auto found = results.find(one.name());
    if (found == results.end() || found->second.outcome != ExtremeOutcome::kSilent) continue;
    list += fmt::format("- `{}`: {}\n", one.name(), found->second.message);
  }
  return list.empty() ? "" : "Wrong in silence:\n\n" + list + "\n";
}

}  // namespace

std::string extremes_picture(const ExtremeGrid& grid, const ExtremeResults& results) {
  std::vector<CellMap> maps;
  for (const ExtremeAxis& axis : grid.axes) maps.push_back(map_of(axis, grid, results));
  for (const ExtremePair& pair : grid.pairs) maps.push_back(map_of(pair, grid, results));
  return report::draw_cell_maps(maps, kMapsAcross);
}

std::string extremes_page(const ExtremeGrid& grid, const ExtremeResults& results,
                          const std::string& command, const std::string& picture) {
  const Cases cases = grid.cases();
  const ExtremeTotals sum = totals(cases, results);
  const ExtremeCase middle;
  std::string page = fmt::format(
      R"(# The whole chain at its extremes

Made by `{0}`; test_chain_extremes runs the ends of each axis again.
A depth picture of a known object on a table is rendered, spoilt, and given to what ships: table
and segmentation, completion with its confidence, mesh, plan, and the cycle of the PG70 on its stage
in simulation, with the object's mass and friction. In the middle a picture has {1:.0e} points, the
object is {2:.0f} mm, {3:g} m away, noise {4:g} mm, no outliers, a level table, {5:g} degrees over the
table, {6:g} kg, friction {7:g}; each map takes one value, or two, to the extremes.

- **works**: the mesh is right (its mean distance to the truth, of the two directions the larger, is
  within 5 mm; a tenth of the size of objects under 50 mm, a twentieth of those over 100 mm), and
  the object was lifted at the first attempt, carried and put down.
- **refused**: nothing was found, predicted or planned, with a reason.
- **said**: the mesh is wrong with confidence under {8:g}, or the grasp failed and the cycle says so.
- **silent**: the mesh is wrong with confidence {8:g} or more, or success was said of what was
  dropped.

Outliers have 0.5 to 1.5 times their depth. A tilted table is one whose normal is not up by the
camera's pose; the platform stands on it, and weight pulls along its normal. Where the object is not
found, the largest of what was found is taken for it.

**{9} cases: {10} work, {11} refused, {12} said to be wrong, {13} wrong in silence ({14:.1f} %, of
the {15} meshes with confidence {8:g} or more {16:.1f} %), {17} crashed.** {18}

Green: all work. Amber: some fail and say so. Grey: refused. Red: wrong in silence, or a crash.

![Where the chain works and where it refuses]({19})

)",
      command, middle.points, 1e3 * middle.size, middle.distance, 1e3 * middle.noise,
      middle.elevation, middle.mass, middle.friction, kConfident, sum.cases, sum.works, sum.refused,
      sum.said, sum.silent, 100 * sum.silent_share(), sum.sure,
      sum.sure > 0 ? 100.0 * sum.silent / sum.sure : 0.0, sum.crashed,
      cost_in_words(cases, results), picture);
  page += silent_cases(cases, results);
  for (const ExtremeAxis& axis : grid.axes) page += table_of(axis, grid, results);
  page.pop_back();
  return page;
}

}  // namespace prehend::eval
