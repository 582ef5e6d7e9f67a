#include "prehend/control/cycle_in_world.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prehend/text/require.h"

namespace prehend::control {

CycleInWorld::CycleInWorld(CycleWorld& world, const ArmCycleOptions& options,
                           const CycleInWorldOptions& run)
    : world_(world), options_(run), cycle_(options, world.arm(), world.hand()) {
  const text::Require require{"CycleInWorldOptions."};
  require(std::isfinite(run.period) && run.period > 0, "period must be positive");
  require(run.touch_counts >= 0, "touch_counts must not be negative");
  require(std::isfinite(run.time_limit) && run.time_limit > 0, "time_limit must be positive");
  steps_ = std::max(1, static_cast<int>(std::lround(run.period / world.step_time())));
}

void CycleInWorld::feel() {
  percepts_ = world_.percepts(options_.touch_counts);
  if (count_++ % 2 == 0) {
    pads_ = percepts_.pads;
    frames_ = percepts_.frames;
    frame_time_ = percepts_.time;
  }
  percepts_.pads = pads_;
  percepts_.frames = frames_;
  for (PadPercept& pad : percepts_.pads) pad.age = percepts_.time - frame_time_;
}

void CycleInWorld::step() {
  world_.advance(steps_);
  feel();
  cycle_.step(percepts_);
}

const CycleResult& CycleInWorld::run(GraspsToTry first,
                                     const std::function<GraspsToTry()>& look_again,
                                     const std::function<void()>& after_step) {
  const double end = world_.time() + options_.time_limit;
  feel();
  cycle_.step(percepts_);
  cycle_.start(std::move(first.grasps), first.problem, std::move(first.advice));
  while (!cycle_.finished() && world_.time() < end) {
    step();
    if (look_again && cycle_.looks_since()) {
      GraspsToTry again = look_again();
      cycle_.take_plan(std::move(again.grasps), again.problem, std::move(again.advice));
    }
    if (after_step) after_step();
  }
  if (!cycle_.finished()) cycle_.abort("the time was used up");
  return cycle_.result();
}

}  // namespace prehend::control
