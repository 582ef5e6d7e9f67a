#include "nodes/report/task_section.h"

#include <set>
#include <string>

#include <fmt/format.h>

#include "msgs/convert/outcomes.h"
#include "prehend/report/charts.h"
#include "prehend/report/state_chart.h"

namespace prehend::nodes {

void add_task(report::Page& page, const msgs::Task& task,
              const std::optional<msgs::CycleResult>& result) {
  report::StateChart chart;
  chart.title = task.name();
  chart.start = task.start();
  std::set<std::string> names;
  for (const auto& state : task.states()) {
    chart.states.push_back(
        {state.name(), control::to_string(convert::from_message(state.action()))});
    names.insert(state.name());
    for (const auto& way : state.ways()) {
      chart.ways.push_back({state.name(), way.next(), way.outcome()});
    }
    if (state.times() > 0) {
      chart.ways.push_back(
          {state.name(), state.then(), fmt::format("done {} times", state.times())});
    }
  }
  std::set<std::string> ends;
  for (const auto& way : chart.ways) {
    if (names.count(way.to) == 0 && ends.insert(way.to).second)
      chart.states.push_back({way.to, ""});
  }
  if (result) chart.path.assign(result->task_path().begin(), result->task_path().end());
  page.add_chart(report::draw_state_chart(chart),
                 fmt::format("The task {} ({}), with the path that was taken.", task.name(),
                             task.description()));
}

}  // namespace prehend::nodes
