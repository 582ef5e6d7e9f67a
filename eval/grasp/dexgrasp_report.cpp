#include "eval/grasp/dexgrasp_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "eval/grasp/share_bounds.h"
#include "eval/text_files.h"
#include "prehend/report/page.h"
#include "prehend/text/json.h"

namespace prehend::eval {
namespace {

using Rows = std::vector<std::vector<std::string>>;

const std::vector<std::string> kHoldHeader{
    "",     "test",           "cases",          "no grasp", "tried",     "hold",
    "95 %", "best one holds", "depth mm: mean", "largest",  "in itself", "largest in itself"};
const std::vector<std::string> kRateHeader{
    "",        "test",    "tried",   "valid",      "distinct",
    "seconds", "tried/s", "valid/s", "distinct/s", "distinct / processor s"};

std::vector<DexTotals> dex_totals(const std::vector<DexCase>& cases,
                                  const std::function<std::string(const DexCase&)>& name_of) {
  std::vector<DexTotals> all;
  std::vector<int> lasting;  // trials that did not fail at their start
  for (const DexCase& one : cases) {
    const std::string name = name_of(one), test = to_string(one.test);
    auto found = std::find_if(all.begin(), all.end(), [&](const DexTotals& totals) {
      return totals.name == name && totals.test == test;
    });
    if (found == all.end()) {
      all.push_back({name, test});
      lasting.push_back(0);
      found = all.end() - 1;
    }
    DexTotals& totals = *found;
    ++totals.cases;
    totals.unplanned += one.valid == 0;
    totals.held_first += !one.tried.empty() && one.tried.front().held;
    totals.candidates += one.candidates;
    totals.valid += one.valid;
    totals.distinct += one.distinct;
    totals.seconds += one.seconds;
    totals.processor_seconds += one.processor_seconds;
    for (const DexOutcome& outcome : one.tried) {
      ++totals.tried;
      totals.held += outcome.held;
      if (outcome.lost == "start") continue;
      ++lasting[static_cast<std::size_t>(found - all.begin())];
      totals.depth += outcome.depth;
      totals.self_depth += outcome.self_depth;
      totals.largest_depth = std::max(totals.largest_depth, outcome.depth);
      totals.largest_self_depth = std::max(totals.largest_self_depth, outcome.self_depth);
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].depth /= std::max(1, lasting[i]);
    all[i].self_depth /= std::max(1, lasting[i]);
  }
  return all;
}

Rows hold_rows(const std::vector<DexTotals>& all) {
  Rows rows;
  for (const DexTotals& t : all) {
    rows.push_back({t.name, t.test, std::to_string(t.cases), std::to_string(t.unplanned),
                    std::to_string(t.tried), fmt::format("{:.1f} %", 100 * t.share()),
                    to_string(share_bounds(t.held, t.tried)),
                    fmt::format("{} of {}", t.held_first, t.cases - t.unplanned),
                    fmt::format("{:.2f}", 1e3 * t.depth),
                    fmt::format("{:.2f}", 1e3 * t.largest_depth),
                    fmt::format("{:.2f}", 1e3 * t.self_depth),
                    fmt::format("{:.2f}", 1e3 * t.largest_self_depth)});
  }
  return rows;
}

Rows rate_rows(const std::vector<DexTotals>& all) {
  Rows rows;
  for (const DexTotals& t : all) {
    const auto rate = [](int count, double seconds) {
      return fmt::format("{:.1f}", seconds > 0 ? count / seconds : 0.0);
    };
    rows.push_back({t.name, t.test, std::to_string(t.candidates), std::to_string(t.valid),
                    std::to_string(t.distinct), fmt::format("{:.2f}", t.seconds),
                    rate(t.candidates, t.seconds), rate(t.valid, t.seconds),
                    rate(t.distinct, t.seconds), rate(t.distinct, t.processor_seconds)});
  }
  return rows;
}

Rows lost_rows(const std::vector<DexCase>& cases) {
  std::map<std::pair<std::string, std::string>, int> counts;
  for (const DexCase& one : cases) {
    for (const DexOutcome& outcome : one.tried) {
      if (!outcome.held) ++counts[{one.hand + " " + to_string(one.test), outcome.lost}];
    }
  }
  Rows rows;
  for (const auto& [key, count] : counts) {
    rows.push_back({key.first, key.second, std::to_string(count)});
  }
  return rows;
}
const std::vector<std::string> kLostHeader{"", "lost", "grasps"};

std::string table_text(const std::vector<std::string>& header, const Rows& rows) {
  std::vector<std::size_t> widths;
  for (const std::string& cell : header) widths.push_back(cell.size());
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      text += c < 2 ? fmt::format("{:{}}  ", row[c], widths[c])
                    : fmt::format("{:>{}}  ", row[c], widths[c]);
    }
    text += '\n';
  };
  add(header);
  for (const auto& row : rows) add(row);
  return text + '\n';
}

std::string csv_of(const std::vector<std::string>& header, const Rows& rows) {
  std::string csv;
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t c = 0; c < row.size(); ++c) csv += (c > 0 ? "," : "") + row[c];
    csv += '\n';
  };
  add(header);
  for (const auto& row : rows) add(row);
  return csv;
}

std::string cases_csv(const std::vector<DexCase>& cases) {
  Rows rows;
  for (const DexCase& one : cases) {
    const auto held = std::count_if(one.tried.begin(), one.tried.end(),
                                    [](const DexOutcome& outcome) { return outcome.held; });
    rows.push_back({one.hand, one.group, one.object, to_string(one.test),
                    std::to_string(one.candidates), std::to_string(one.valid),
                    std::to_string(one.distinct), std::to_string(one.tried.size()),
                    std::to_string(held)});
  }
  return csv_of(
      {"hand", "group", "object", "test", "candidates", "valid", "distinct", "tried", "held"},
      rows);
}

std::string trials_csv(const std::vector<DexCase>& cases) {
  Rows rows;
  for (const DexCase& one : cases) {
    for (std::size_t rank = 0; rank < one.tried.size(); ++rank) {
      const DexOutcome& outcome = one.tried[rank];
      rows.push_back(
          {one.hand, one.group, one.object, to_string(one.test), std::to_string(rank),
           outcome.held ? "1" : "0", outcome.lost, fmt::format("{:.6g}", outcome.shift),
           fmt::format("{:.6g}", outcome.turn), fmt::format("{:.6g}", outcome.start_depth),
           fmt::format("{:.6g}", outcome.depth), fmt::format("{:.6g}", outcome.self_depth)});
    }
  }
  return csv_of({"hand", "group", "object", "test", "rank", "held", "lost", "shift_m", "turn_rad",
                 "start_depth_m", "depth_m", "self_depth_m"},
                rows);
}

text::Json json_of(const std::vector<DexTotals>& all) {
  text::Json list = text::Json::array();
  for (const DexTotals& t : all) {
    const ShareBounds bounds = share_bounds(t.held, t.tried);
    text::Json one = text::Json::object();
    one.set("name", t.name).set("test", t.test).set("cases", t.cases);
    one.set("unplanned", t.unplanned).set("tried", t.tried).set("held", t.held);
    one.set("share", t.share()).set("low", bounds.low).set("high", bounds.high);
    one.set("held_first", t.held_first).set("depth_m", t.depth);
    one.set("largest_depth_m", t.largest_depth).set("self_depth_m", t.self_depth);
    one.set("largest_self_depth_m", t.largest_self_depth).set("candidates", t.candidates);
    one.set("valid", t.valid).set("distinct", t.distinct);
    list.add(one);
  }
  return list;
}

}  // namespace

std::vector<DexTotals> totals_by_hand(const std::vector<DexCase>& cases) {
  return dex_totals(cases, [](const DexCase& one) { return one.hand; });
}

std::vector<DexTotals> totals_by_object(const std::vector<DexCase>& cases) {
  return dex_totals(cases, [](const DexCase& one) { return one.object; });
}

std::string dex_text(const std::vector<DexCase>& cases) {
  const std::vector<DexTotals> by_hand = totals_by_hand(cases);
  std::string text = table_text(kHoldHeader, hold_rows(totals_by_object(cases)));
  text += table_text(kHoldHeader, hold_rows(by_hand));
  text += table_text(kRateHeader, rate_rows(by_hand));
  return text + table_text(kLostHeader, lost_rows(cases));
}

std::string dex_json(const std::vector<DexCase>& cases) {
  text::Json json = text::Json::object();
  json.set("hands", json_of(totals_by_hand(cases)));
  json.set("objects", json_of(totals_by_object(cases)));
  return json.pretty();
}

void write_dex_report(const std::filesystem::path& folder, const std::vector<DexCase>& cases) {
  const std::vector<DexTotals> by_hand = totals_by_hand(cases);
  report::Page page("Grasps tried as DexGraspBench tries them");
  page.add_paragraph(
      "A body of 100 g, free in the air or on a table; a hand whose root stands still closes on "
      "it, "
      "squeezes, and the body is pulled by its weight along each axis, or lifted by 10 cm. It "
      "holds "
      "if the body moves by less than 5 cm and turns by less than 15 degrees.");
  page.add_table(kHoldHeader, hold_rows(by_hand));
  page.add_heading("How grasps were lost");
  page.add_table(kLostHeader, lost_rows(cases));
  page.add_heading("Objects");
  page.add_table(kHoldHeader, hold_rows(totals_by_object(cases)));
  page.write(folder / "index.html");
  write_text(folder / "cases.csv", cases_csv(cases));
  write_text(folder / "trials.csv", trials_csv(cases));
  write_text(folder / "rates.csv", csv_of(kRateHeader, rate_rows(by_hand)));
}

}  // namespace prehend::eval
