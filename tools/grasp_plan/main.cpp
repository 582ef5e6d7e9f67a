// grasp_plan: what `prehend plan` becomes; see there.

#include <cstdio>
#include <exception>

#include "prehend/text/command_line.h"
#include "tools/grasp_plan/printed.h"

int main(int argc, char** argv) {
  using namespace prehend::tools;
  constexpr int kNoPlan = 3;
  PlanChoices choices;
  CLI::App app("Plan grasps of a mesh or of an object in a recorded cloud", "prehend plan");
  add_plan_options(app, choices);
  if (const auto code = prehend::text::parse_command_line(app, argc, argv)) return *code;
  try {
    Progress progress;
    const PlanTarget target = read_target(choices, progress);
    const Planned planned = make_plan(choices, target, progress);
    progress.over();
    print_plan(choices, target, planned);
    if (!choices.save.empty()) save_plan(choices, target, planned);
    if (!choices.out.empty()) {
      progress.stage("drawing the page");
      write_plan_page(choices, target, planned);
      if (!choices.json) std::printf("%s/index.html\n", choices.out.c_str());
    }
    const bool found =
        !planned.plan.grasps.empty() && (!planned.arm || planned.arm->motion.found());
    return found ? 0 : kNoPlan;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend plan: %s\n", error.what());
    return 1;
  }
}
