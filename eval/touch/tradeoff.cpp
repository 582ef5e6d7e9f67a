#include "eval/touch/tradeoff.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "eval/processor_time.h"
#include "eval/touch/hold.h"
#include "prehend/fidelity/touch_settings.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/simulation/work_cycle.h"

namespace prehend::eval::touch {
namespace {

using fidelity::Setting;
using simulation::engines::EngineRegistry;

const std::vector<double> kMasses{0.1, 0.3, 1};      // kg
const std::vector<double> kCoverages{0.52, 0.6, 1};  // of the pad, in the cycle of each
constexpr double kLost = 0.005;                      // m off
constexpr double kSamplePeriod = 0.1;                // s, of the cycle
constexpr double kNone = std::numeric_limits<double>::infinity();

std::string described(const Setting& setting) {
  std::string text;
  for (const auto& [name, value] : setting.knobs) text += name + " " + value + "  ";
  return text;
}

simulation::WorkCycleOptions cycle_of(std::size_t index, const fidelity::TouchOptions& touch) {
  const double mass = kMasses[index];
  simulation::WorkCycleOptions options;
  options.grasp.mass = mass;
  options.grasp.law.viscous_friction = 0.1;
  options.grasp.law.bristle_law = contact::BristleLaw::kElastoPlastic;
  options.grasp.law.return_map = true;
  options.grasp.pad = touch.pad;
  options.coverage = kCoverages[index];
  options.grip_force = 12 * std::max(1.0, mass / 0.3);
  options.step = touch.step;
  options.solve = touch.solve;
  return options;
}

// Fills in time and error; false and the reason when the setting cannot do it.
class CycleScene {
 public:
  explicit CycleScene(double reference_step) {
    fidelity::TouchOptions fine;
    fine.step.integration = contact::Integration::kSecondOrder;
    fine.step.step = reference_step;
    for (std::size_t i = 0; i < kMasses.size(); ++i) {
      references_.push_back(sampled(cycle_of(i, fine)));
    }
  }

  bool measure(Setting& setting, int repetitions, std::string& reason) const {
    const fidelity::TouchOptions touch = fidelity::touch_options(setting);
    setting.error = setting.seconds = 0;
    for (std::size_t i = 0; i < kMasses.size(); ++i) {
      const simulation::WorkCycleOptions options = cycle_of(i, touch);
      const double error = largest_difference(sampled(options), references_[i]);
      if (!std::isfinite(error)) {
        reason = fmt::format("diverges at {} kg", kMasses[i]);
        return false;
      }
      setting.error = std::max(setting.error, error);
      // Without samples, which end steps.
      double least = kNone;
      for (int k = 0; k < repetitions; ++k) {
        const simulation::WorkCycleResult result = run_work_cycle(options);
        least = std::min(least, result.cpu_time / result.duration);
      }
      setting.seconds += least / static_cast<double>(kMasses.size());
    }
    return true;
  }

 private:
  static simulation::WorkCycleResult sampled(simulation::WorkCycleOptions options) {
    options.sample_period = kSamplePeriod;
    return run_work_cycle(options);
  }

  std::vector<simulation::WorkCycleResult> references_;
};

class EngineScenes {
 public:
  explicit EngineScenes(double reference_step) {
    fidelity::EngineChoice fine;
    fine.solver = "second_order";
    fine.step = reference_step;
    for (const double mass : kMasses) references_.push_back(run(fine, mass).path);
  }

  bool measure(Setting& setting, int repetitions, std::string& reason) const {
    const fidelity::EngineChoice choice = fidelity::engine_choice(setting);
    setting.error = setting.seconds = 0;
    try {
      for (std::size_t i = 0; i < kMasses.size(); ++i) {
        double least = kNone;
        for (int k = 0; k < repetitions; ++k) {
          const Run done = run(choice, kMasses[i]);
          least = std::min(least, done.seconds);
          if (k > 0) continue;
          for (std::size_t s = 0; s < done.path.size(); ++s) {
            const double error = (done.path[s] - references_[i][s]).norm();
            if (!std::isfinite(error)) {
              reason = fmt::format("diverges at {} kg", kMasses[i]);
              return false;
            }
            setting.error = std::max(setting.error, error);
          }
        }
        setting.seconds += least / static_cast<double>(kMasses.size());
      }
    } catch (const simulation::engines::UnsupportedScene& refusal) {
      reason = refusal.what();
      return false;
    }
    return true;
  }

 private:
  struct Run {
    std::vector<Eigen::Vector3d> path;  // m, of the cube
    double seconds = 0;                 // of processor for each simulated second
  };

  Run run(const fidelity::EngineChoice& choice, double mass) const {
    HoldTest test;
    test.mass = mass;
    test.step = choice.step;
    test.solver = choice.solver;
    test.pads = choice.pads;
    const auto engine = registry_.create(choice.engine);
    engine->load(hold_scene(test));
    const double begin = processor_time();
    Run done;
    done.path = shaken_hold(*engine, test);
    done.seconds = (processor_time() - begin) / kShakenDuration;
    return done;
  }

  EngineRegistry registry_;
  std::vector<std::vector<Eigen::Vector3d>> references_;
};

template <class Scene>
std::vector<Setting> measure_all(const Scene& scene, const std::vector<Setting>& settings,
                                 int repetitions, std::vector<std::string>& left_out,
                                 const std::function<void(const std::string&)>& progress) {
  std::vector<Setting> measured;
  for (Setting setting : settings) {
    std::string reason;
    if (!scene.measure(setting, repetitions, reason)) {
      left_out.push_back(described(setting) + ": " + reason);
      progress(left_out.back());
      continue;
    }
    progress(fmt::format("{:9.3f} ms/s {:11.4f} um  {}", 1e3 * setting.seconds, 1e6 * setting.error,
                         described(setting)));
    measured.push_back(setting);
  }
  return measured;
}

}  // namespace

std::vector<Setting> swept_cycle_settings(bool quick) {
  using Texels = std::pair<const char*, const char*>;
  const std::vector<Texels> texels = quick
                                         ? std::vector<Texels>{{"7", "3"}, {"14", "6"}}
                                         : std::vector<Texels>{{"4", "2"}, {"7", "3"}, {"14", "6"}};
  const std::vector<const char*> steps =
      quick ? std::vector<const char*>{"0.02", "0.005"}
            : std::vector<const char*>{"0.02", "0.01", "0.005", "0.002", "0.001", "0.0005"};
  const std::vector<const char*> tolerances =
      quick ? std::vector<const char*>{"1e-06"}
            : std::vector<const char*>{"1e-05", "1e-06", "1e-07", "1e-08"};
  const std::vector<const char*> iterations =
      quick ? std::vector<const char*>{"6"} : std::vector<const char*>{"1", "2", "6"};
  std::vector<Setting> settings;
  const auto add = [&](const char* integration, const char* knob, const char* value,
                       const char* most, const Texels& grid) {
    Setting setting;
    setting.knobs = {{"integration", integration},
                     {knob, value},
                     {"iterations", most},
                     {"rows", grid.first},
                     {"columns", grid.second}};
    settings.push_back(setting);
  };
  for (const Texels& grid : texels) {
    for (const char* most : iterations) {
      for (const char* integration : {"first_order", "second_order"}) {
        for (const char* step : steps) add(integration, "step", step, most, grid);
      }
      for (const char* tolerance : tolerances) {
        add("adaptive", "tolerance", tolerance, most, grid);
      }
    }
  }
  // The paper's; above 0.12 ms it is unstable, as the sweep shows.
  if (!quick) {
    for (const char* step : {"0.0002", "0.00005"}) {
      add("explicit", "step", step, "6", {"14", "6"});
    }
  }
  return settings;
}

std::vector<Setting> swept_engine_settings(bool quick) {
  const std::vector<const char*> steps =
      quick ? std::vector<const char*>{"0.01"}
            : std::vector<const char*>{"0.01", "0.005", "0.002", "0.001", "0.0005"};
  const EngineRegistry registry;
  std::vector<Setting> settings;
  for (const std::string& engine : registry.names()) {
    const std::vector<std::string> solvers = registry.create(engine)->solvers();
    for (const std::string& solver : solvers) {
      for (const char* pads : {"yes", "no"}) {
        // With pads in sub-steps the contact solver has nothing to do: one will do.
        const bool idle = pads == std::string("yes") && engine != "native";
        if (idle && (quick || solver != solvers.front())) continue;
        for (const char* step : steps) {
          Setting setting;
          setting.knobs = {{"engine", engine}, {"solver", solver}, {"pads", pads}, {"step", step}};
          settings.push_back(setting);
        }
      }
    }
  }
  return settings;
}

TouchTradeoff measure_touch_tradeoff(const std::vector<Setting>& cycle,
                                     const std::vector<Setting>& engines, int repetitions,
                                     const std::function<void(const std::string&)>& progress,
                                     double reference_step) {
  TouchTradeoff tradeoff;
  tradeoff.cycle =
      measure_all(CycleScene(reference_step), cycle, repetitions, tradeoff.left_out, progress);
  tradeoff.engines =
      measure_all(EngineScenes(reference_step), engines, repetitions, tradeoff.left_out, progress);
  return tradeoff;
}

namespace {

// The front without settings that lose the object, and without what is slower and hardly more
// accurate: less than 1 % is no gain.
std::vector<Setting> front_settings(const std::vector<Setting>& measured) {
  std::vector<Setting> kept;
  for (Setting& setting : fidelity::pareto_front(measured)) {
    if (setting.error > kLost) continue;
    if (kept.empty() || setting.error < 0.99 * kept.back().error) {
      kept.push_back(std::move(setting));
    }
  }
  return kept;
}

}  // namespace

fidelity::Front cycle_front(const TouchTradeoff& tradeoff, const std::string& machine) {
  fidelity::Front front;
  front.subject = "touch";
  front.error_name =
      "largest distance of the box in work cycles from a finer run's; milliseconds are of each "
      "simulated second";
  front.machine = machine;
  front.settings = front_settings(tradeoff.cycle);
  return front;
}

fidelity::Front engine_front(const TouchTradeoff& tradeoff, const std::string& machine) {
  fidelity::Front front;
  front.subject = "touch_engines";
  front.error_name =
      "largest distance of a held, shaken cube from a finer run's with pads; milliseconds are of "
      "each simulated second";
  front.machine = machine;
  front.settings = front_settings(tradeoff.engines);
  return front;
}

}  // namespace prehend::eval::touch
