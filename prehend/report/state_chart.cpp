#include "prehend/report/state_chart.h"

#include <algorithm>
#include <map>
#include <ostream>
#include <utility>

#include "prehend/report/drawing_program.h"

namespace prehend::report {
namespace {

// In DOT's double-quoted strings quotes and backslashes are special.
std::string dot_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

using Pair = std::pair<std::string, std::string>;

void write_dot(const StateChart& chart, std::ostream& out) {
  std::map<Pair, int> taken;
  for (std::size_t i = 1; i < chart.path.size(); ++i) ++taken[{chart.path[i - 1], chart.path[i]}];
  out << "digraph task {\n"
      << "graph [bgcolor=white, rankdir=LR, fontname=\"DejaVu Sans\", nodesep=0.3, ranksep=0.45]\n"
      << "node [shape=box, style=\"rounded,filled\", fillcolor=\"#f4f4f4\", color=\"#999999\", "
         "fontname=\"DejaVu Sans\", fontsize=11]\n"
      << "edge [color=\"#bbbbbb\", fontcolor=\"#888888\", fontname=\"DejaVu Sans\", fontsize=9]\n";
  for (const StateChart::State& state : chart.states) {
    const bool entered =
        std::find(chart.path.begin(), chart.path.end(), state.name) != chart.path.end();
    out << dot_string(state.name) << " [label=" << dot_string(state.name)
        << ", tooltip=" << dot_string(state.text);
    if (state.text.empty()) out << ", peripheries=2";
    if (entered) out << ", fillcolor=\"#cfe3f7\", color=\"#1f6fb4\"";
    if (state.name == chart.start) out << ", penwidth=2";
    out << "]\n";
  }
  // Ways between the same two states are one arrow.
  std::map<Pair, std::string> labels;
  for (const StateChart::Way& way : chart.ways) {
    std::string& label = labels[{way.from, way.to}];
    label += (label.empty() ? "" : ", ") + way.label;
  }
  for (const auto& [ends, label] : labels) {
    const auto found = taken.find(ends);
    const int times = found == taken.end() ? 0 : found->second;
    out << dot_string(ends.first) << " -> " << dot_string(ends.second) << " [label="
        << dot_string(label + (times > 1 ? " (" + std::to_string(times) + " times)" : ""));
    if (times > 0) out << ", color=\"#1f6fb4\", fontcolor=\"#1f6fb4\", penwidth=1.8";
    out << "]\n";
  }
  out << "}\n";
}

}  // namespace

std::string draw_state_chart(const StateChart& chart) {
  return drawn_by(
      {"Graphviz", "dot -Tsvg script -o chart.svg", "graphviz"}, chart.title,
      [&chart](const auto& /*folder*/, std::ostream& script) { write_dot(chart, script); });
}

}  // namespace prehend::report
