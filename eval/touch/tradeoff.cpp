#include "eval/touch/tradeoff.h"

#include <algorithm>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "eval/processor_time.h"
#include "eval/touch/felt_cycles.h"
#include "eval/touch/hold.h"
#include "prehend/fidelity/touch_settings.h"
#include "prehend/simulation/engines/registry.h"

namespace prehend::eval::touch {
namespace {

using fidelity::Setting;
using simulation::engines::EngineRegistry;

const std::vector<double> kMasses{0.1, 0.3, 1};  // kg, of what the hand and the engines hold
constexpr const char* kHand = "sdh2";

// Runs of several scenes beside their references.
class Comparison {
 public:
  Comparison(MeasuredTouch* measured, int repetitions)
      : measured_(*measured), repetitions_(repetitions) {
    measured_.setting.seconds = 0;
  }

  /// Runs one more scene of `scenes` by `run`. False when it diverges.
  bool add(const std::function<CycleRun()>& run, const FeltRun& reference, const FeltRun* own,
           int scenes) {
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < repetitions_; ++k) {
      const CycleRun done = run();
      least = std::min(least, done.seconds);
      if (k > 0) continue;
      const FeltError error = felt_error(done.felt, reference);
      measured_.error = worst(measured_.error, error);
      if (own) {
        measured_.own = worst(measured_.own.value_or(FeltError{}), felt_error(done.felt, *own));
      }
      if (!error.is_finite()) return false;
    }
    measured_.setting.seconds += least / scenes;
    return true;
  }

 private:
  MeasuredTouch& measured_;
  int repetitions_;
};

// Fill in times and errors; false and the reason when the setting cannot do it.
class CycleScenes {
 public:
  explicit CycleScenes(const TouchSweep& sweep) : repetitions_(sweep.repetitions) {
    Setting fine;
    fine.knobs = {{"integration", "second_order"},
                  {"step", fmt::format("{}", sweep.reference_step)}};
    for (int i = 0; i < kCycleObjects; ++i) {
      references_.push_back(run_gripper_cycle(scene_of(fine, i)).felt);
    }
  }

  bool measure(MeasuredTouch& measured, std::string& reason) const {
    Comparison comparison(&measured, repetitions_);
    for (int i = 0; i < kCycleObjects; ++i) {
      const simulation::Scene scene = scene_of(measured.setting, i);
      if (!comparison.add([&] { return run_gripper_cycle(scene); },
                          references_[static_cast<std::size_t>(i)], nullptr, kCycleObjects)) {
        reason = std::string("diverges with a ") + kCycleNames.at(static_cast<std::size_t>(i));
        return false;
      }
    }
    return true;
  }

 private:
  // Rows and columns are no knobs of a front.
  static simulation::Scene scene_of(const Setting& setting, int object) {
    std::map<std::string, int> grid{{"rows", 14}, {"columns", 6}};
    Setting steps;
    for (const auto& [knob, value] : setting.knobs) {
      if (grid.count(knob) > 0) {
        grid[knob] = std::stoi(value);
      } else {
        steps.knobs.emplace_back(knob, value);
      }
    }
    simulation::Scene scene = cycle_scene(object, grid["rows"], grid["columns"]);
    fidelity::apply_touch_setting(steps, &scene);
    return scene;
  }

  int repetitions_;
  std::vector<FeltRun> references_;
};

class HandScenes {
 public:
  explicit HandScenes(const TouchSweep& sweep) : repetitions_(sweep.repetitions) {
    for (const double mass : kMasses) {
      references_.push_back(run_hand_cycle(kHand, mass, sweep.reference_step).felt);
    }
  }

  bool measure(MeasuredTouch& measured, std::string& reason) const {
    const double step = fidelity::touch_hand_step(measured.setting);
    Comparison comparison(&measured, repetitions_);
    for (std::size_t i = 0; i < kMasses.size(); ++i) {
      if (!comparison.add([&] { return run_hand_cycle(kHand, kMasses[i], step); }, references_[i],
                          nullptr, static_cast<int>(kMasses.size()))) {
        reason = fmt::format("diverges at {} kg", kMasses[i]);
        return false;
      }
    }
    return true;
  }

 private:
  int repetitions_;
  std::vector<FeltRun> references_;
};

class EngineScenes {
 public:
  explicit EngineScenes(const TouchSweep& sweep)
      : repetitions_(sweep.repetitions), own_step_(sweep.own_finest_step) {
    fidelity::EngineChoice fine;
    fine.solver = "second_order";
    fine.step = sweep.reference_step;
    for (const double mass : kMasses) references_.push_back(run(fine, mass).felt);
  }

  bool measure(MeasuredTouch& measured, std::string& reason) {
    const fidelity::EngineChoice choice = fidelity::engine_choice(measured.setting);
    measured.feels = choice.pads;
    Comparison comparison(&measured, repetitions_);
    try {
      for (std::size_t i = 0; i < kMasses.size(); ++i) {
        FeltRun reference = references_[i];
        if (!choice.pads) reference.frames.clear();
        if (!comparison.add([&] { return run(choice, kMasses[i]); }, reference,
                            &own_reference(choice, kMasses[i]), static_cast<int>(kMasses.size()))) {
          reason = fmt::format("diverges at {} kg", kMasses[i]);
          return false;
        }
      }
    } catch (const simulation::engines::UnsupportedScene& refusal) {
      reason = refusal.what();
      return false;
    }
    return true;
  }

 private:
  CycleRun run(const fidelity::EngineChoice& choice, double mass) const {
    HoldTest test;
    test.mass = mass;
    test.step = choice.step;
    test.solver = choice.solver;
    test.pads = choice.pads;
    const auto engine = registry_.create(choice.engine);
    engine->load(hold_scene(test));
    const double begin = processor_time();
    CycleRun done;
    done.felt = shaken_hold(*engine, test);
    done.seconds = (processor_time() - begin) / kShakenDuration;
    return done;
  }

  const FeltRun& own_reference(fidelity::EngineChoice choice, double mass) {
    const std::string name =
        fmt::format("{} {} {} {}", choice.engine, choice.solver, choice.pads, mass);
    const auto found = own_.find(name);
    if (found != own_.end()) return found->second;
    choice.step = own_step_;
    return own_.emplace(name, run(choice, mass).felt).first->second;
  }

  EngineRegistry registry_;
  int repetitions_;
  double own_step_;
  std::vector<FeltRun> references_;
  std::map<std::string, FeltRun> own_;
};

std::string in_words(const FeltError& error, bool feels) {
  const std::string motion = fmt::format("{:11.4f} um", 1e6 * error.motion);
  return feels ? fmt::format("{:9.4f} % image {:9.4f} % sum {:9.4f} % largest ", 100 * error.image,
                             100 * error.sum, 100 * error.largest) +
                     motion
               : motion;
}

template <class Scene>
std::vector<MeasuredTouch> measure_all(Scene scenes, const std::vector<Setting>& settings,
                                       std::vector<std::string>& left_out,
                                       const std::function<void(const std::string&)>& progress) {
  std::vector<MeasuredTouch> all;
  for (const Setting& setting : settings) {
    MeasuredTouch measured;
    measured.setting = setting;
    std::string reason;
    if (!scenes.measure(measured, reason)) {
      left_out.push_back(to_string(setting) + ": " + reason);
      progress(left_out.back());
      continue;
    }
    progress(fmt::format("{:9.3f} ms/s {}{}  {}", 1e3 * measured.setting.seconds,
                         in_words(measured.error, measured.feels),
                         measured.own ? "; own " + in_words(*measured.own, measured.feels) : "",
                         to_string(setting)));
    all.push_back(std::move(measured));
  }
  return all;
}

}  // namespace

TouchTradeoff measure_touch_tradeoff(const TouchSweep& sweep,
                                     const std::function<void(const std::string&)>& progress) {
  TouchTradeoff tradeoff;
  const CycleScenes cycles(sweep);
  tradeoff.cycle = measure_all(cycles, sweep.cycle, tradeoff.left_out, progress);
  tradeoff.texels = measure_all(cycles, sweep.texels, tradeoff.left_out, progress);
  tradeoff.hand = measure_all(HandScenes(sweep), sweep.hand, tradeoff.left_out, progress);
  tradeoff.engines = measure_all(EngineScenes(sweep), sweep.engines, tradeoff.left_out, progress);
  return tradeoff;
}

}  // namespace prehend::eval::touch
