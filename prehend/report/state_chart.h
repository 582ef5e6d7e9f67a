#pragma once

#include <string>
#include <vector>

namespace prehend::report {

/// A state machine and the path that was taken through it.
struct StateChart {
  struct State {
    std::string name;
    std::string text;  // what is done there; empty: an end
  };
  struct Way {
    std::string from, to, label;
  };
  std::string title;
  std::string start;
  std::vector<State> states;
  std::vector<Way> ways;
  std::vector<std::string> path;  // names of states as they were entered
};

/// The chart as an SVG element, drawn by Graphviz; what was entered stands out, with how often each
/// way between two states was taken where that was more than once.
/// @throws std::runtime_error when Graphviz is missing or refuses it.
std::string draw_state_chart(const StateChart& chart);

}  // namespace prehend::report
