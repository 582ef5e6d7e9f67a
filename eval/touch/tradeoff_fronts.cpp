#include "eval/touch/tradeoff.h"
#include "prehend/simulation/engines/registry.h"

namespace prehend::eval::touch {
namespace {

using fidelity::Setting;

constexpr double kLost = 0.005;  // m off

// Without settings that lose the object, and without what is slower and hardly more accurate: less
// than 1 % is no gain.
fidelity::Front front_of(const std::string& subject, const std::string& scene,
                         const std::vector<MeasuredTouch>& measured, const std::string& machine) {
  fidelity::Front front;
  front.subject = subject;
  front.error_name = "difference of the pads' images from a finer run's, root mean square over " +
                     scene + "; milliseconds are of each simulated second";
  front.error_unit = "of the largest sum";
  front.machine = machine;
  front.other_errors = {
      {"sum", "the same of the pads' sums"},
      {"largest", "largest difference of an image at any instant [of the largest sum]"},
      {"motion", "largest distance of the object from the finer run's [m]"}};
  const bool is_own = !measured.empty() && measured.front().own.has_value();
  if (is_own) {
    front.other_errors.emplace_back("own_image", "as error, from the same engine's finer steps");
    front.other_errors.emplace_back("own_motion", "as motion, from the same engine's finer steps");
  }
  std::vector<Setting> settings;
  for (const MeasuredTouch& one : measured) {
    if (!one.feels || one.error.motion > kLost) continue;
    Setting setting = one.setting;
    setting.error = one.error.image;
    setting.other_errors = {
        {"sum", one.error.sum}, {"largest", one.error.largest}, {"motion", one.error.motion}};
    if (is_own) {
      setting.other_errors.emplace_back("own_image", one.own->image);
      setting.other_errors.emplace_back("own_motion", one.own->motion);
    }
    settings.push_back(std::move(setting));
  }
  for (Setting& setting : fidelity::pareto_front(std::move(settings))) {
    if (front.settings.empty() || setting.error < 0.99 * front.settings.back().error) {
      front.settings.push_back(std::move(setting));
    }
  }
  return front;
}

std::vector<Setting> with_steps(const Setting& fixed, const std::vector<const char*>& steps,
                                const char* knob = "step") {
  std::vector<Setting> settings;
  for (const char* step : steps) {
    settings.push_back(fixed);
    settings.back().knobs.emplace_back(knob, step);
  }
  return settings;
}

void append(std::vector<Setting> more, std::vector<Setting>* settings) {
  settings->insert(settings->end(), more.begin(), more.end());
}

std::vector<Setting> swept_cycle(bool quick) {
  // The node publishes every 10 ms, so no step is longer.
  const std::vector<const char*> steps =
      quick ? std::vector<const char*>{"0.01", "0.002"}
            : std::vector<const char*>{"0.01", "0.005", "0.002", "0.001", "0.0005"};
  const std::vector<const char*> tolerances =
      quick ? std::vector<const char*>{"0.0001"}
            : std::vector<const char*>{"0.001", "0.0001", "1e-05", "1e-06", "1e-07"};
  std::vector<Setting> settings;
  for (const char* iterations : {"1", "2", "6"}) {
    if (quick && iterations != std::string("6")) continue;
    for (const char* integration : {"first_order", "second_order"}) {
      Setting fixed;
      fixed.knobs = {{"integration", integration}, {"iterations", iterations}};
      append(with_steps(fixed, steps), &settings);
    }
    Setting fixed;
    fixed.knobs = {{"integration", "adaptive"}, {"iterations", iterations}};
    append(with_steps(fixed, tolerances, "tolerance"), &settings);
  }
  return settings;
}

std::vector<Setting> swept_texels(bool quick) {
  std::vector<Setting> settings;
  for (const auto& [rows, columns] :
       {std::pair{"7", "3"}, std::pair{"14", "6"}, std::pair{"28", "12"}}) {
    if (quick && rows == std::string("28")) continue;
    settings.emplace_back();
    settings.back().knobs = {
        {"integration", "second_order"}, {"step", "0.001"}, {"rows", rows}, {"columns", columns}};
  }
  return settings;
}

std::vector<Setting> swept_engines(bool quick) {
  const std::vector<const char*> steps =
      quick ? std::vector<const char*>{"0.01"}
            : std::vector<const char*>{"0.01", "0.005", "0.002", "0.001", "0.0005"};
  const simulation::engines::EngineRegistry registry;
  std::vector<Setting> settings;
  for (const std::string& engine : registry.names()) {
    const std::vector<std::string> solvers = registry.create(engine)->solvers();
    for (const std::string& solver : solvers) {
      for (const char* pads : {"yes", "no"}) {
        // With pads in sub-steps the contact solver has nothing to do: one will do.
        const bool idle = pads == std::string("yes") && engine != "native";
        if (idle && (quick || solver != solvers.front())) continue;
        Setting fixed;
        fixed.knobs = {{"engine", engine}, {"solver", solver}, {"pads", pads}};
        append(with_steps(fixed, steps), &settings);
      }
    }
  }
  return settings;
}

}  // namespace

TouchSweep touch_sweep(bool quick) {
  TouchSweep sweep;
  sweep.cycle = swept_cycle(quick);
  sweep.texels = swept_texels(quick);
  sweep.hand = with_steps({}, quick ? std::vector<const char*>{"0.01", "0.002"}
                                    : std::vector<const char*>{"0.01", "0.005", "0.002", "0.001",
                                                               "0.0005", "0.0002", "0.0001"});
  sweep.engines = swept_engines(quick);
  if (quick) {
    sweep.repetitions = 1;
    sweep.reference_step = sweep.own_finest_step = 1e-4;
  }
  return sweep;
}

fidelity::Front cycle_front(const TouchTradeoff& tradeoff, const std::string& machine) {
  return front_of("touch", "work cycles of the PG70", tradeoff.cycle, machine);
}

fidelity::Front hand_front(const TouchTradeoff& tradeoff, const std::string& machine) {
  return front_of("touch_hand", "work cycles of the SDH-2", tradeoff.hand, machine);
}

fidelity::Front engine_front(const TouchTradeoff& tradeoff, const std::string& machine) {
  return front_of("touch_engines", "a held, shaken cube", tradeoff.engines, machine);
}

}  // namespace prehend::eval::touch
