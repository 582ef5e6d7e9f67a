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

ArmPercepts CycleInWorld::feel() {
  ArmPercepts percepts = world_.percepts(options_.touch_counts);
  if (count_++ % 2 == 0) {
    pads_ = percepts.pads;
    frames_ = percepts.frames;
    frame_time_ = percepts.time;
  }
  percepts.pads = pads_;
  percepts.frames = frames_;
  for (PadPercept& pad : percepts.pads) pad.age = percepts.time - frame_time_;
  return percepts;
}

void CycleInWorld::step() {
  world_.advance(steps_);
  cycle_.step(feel());
}

const CycleResult& CycleInWorld::run(GraspsToTry first,
                                     const std::function<GraspsToTry()>& look_again,
                                     const std::function<void()>& after_step) {
  const double end = world_.time() + options_.time_limit;
  cycle_.step(feel());
  cycle_.start(std::move(first.grasps), first.problem);
  while (!cycle_.finished() && world_.time() < end) {
    step();
    if (look_again && cycle_.looks_since()) {
      GraspsToTry again = look_again();
      cycle_.take_plan(std::move(again.grasps), again.problem);
    }
    if (after_step) after_step();
  }
  if (!cycle_.finished()) cycle_.abort("the time was used up");
  return cycle_.result();
}

}  // namespace prehend::control
