#include "eval/touch/extremes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "eval/touch/experiment.h"
#include "prehend/contact/parallel_grasp.h"

namespace prehend::eval::touch {

using namespace contact;

namespace {

constexpr double kGravity = 9.81;

ParallelGraspOptions usual() {
  ParallelGraspOptions options;
  // Higher than the pads, so that no row of texels slips over its edge.
  options.box_size.z() = 0.08;
  options.opening = 0.0501;
  options.mass = 0.3;
  options.law.static_friction = options.law.dynamic_friction = 0.8;
  options.law.bristle_law = BristleLaw::kElastoPlastic;
  options.law.return_map = true;
  return options;
}

Extreme make(const std::string& subject, const std::string& value,
             const ParallelGraspOptions& options) {
  Extreme extreme;
  extreme.subject = subject;
  extreme.value = value;
  extreme.model = parallel_grasp(options);
  extreme.force = std::max(5.0, 1.5 * options.mass * kGravity / (2 * 0.8));
  return extreme;
}

void add_masses(std::vector<Extreme>& rows) {
  for (const double ratio : {1.0, 20.0, 60.0, 1e3, 1e4}) {
    ParallelGraspOptions options = usual();
    options.mass = ratio * 0.05;
    // What the pads' foam can bear; harder foam for heavier things.
    options.law.stiffness *= std::max(1.0, ratio / 100);
    options.law.bristle_stiffness *= std::max(1.0, ratio / 100);
    rows.push_back(make("object : 50 g jaw", number_text(ratio) + " : 1", options));
    rows.back().duration = 4;  // heavy things swing longer
  }
}

void add_laws(std::vector<Extreme>& rows) {
  for (const double k : {1e1, 1e3, 1e5, 1e7}) {
    ParallelGraspOptions options = usual();
    options.law.stiffness = k;
    options.mass = 0.1;
    Extreme row = make("stiffness k", number_text(k) + " N/m", options);
    if (k < 100) row.force = 2;  // 84 texels of 10 N/m bear 2.5 N in 3 mm
    rows.push_back(row);
  }
  for (const double c : {0.0, 1.0, 1e2, 1e4}) {
    ParallelGraspOptions options = usual();
    options.law.damping = c;
    rows.push_back(make("damping c", number_text(c) + " N s/m", options));
  }
  for (const double sigma : {1e1, 1e3, 1e5, 1e7}) {
    ParallelGraspOptions options = usual();
    options.law.bristle_stiffness = sigma;
    rows.push_back(make("bristle stiffness", number_text(sigma) + " N/m", options));
  }
}

void add_steps_and_sizes(std::vector<Extreme>& rows) {
  for (const double h : {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 2e-2}) {
    Extreme row = make("step", number_text(1e3 * h) + " ms", usual());
    row.step = h;
    if (h < 1e-5) row.duration = 0.1;
    rows.push_back(row);
  }
  for (const double size : {0.001, 0.01, 0.1, 1.0}) {
    ParallelGraspOptions options = usual();
    options.box_size.setConstant(size);
    options.opening = size + 1e-4;
    options.mass = std::clamp(1000 * size * size * size, 1e-4, 3.0);
    // Rays 3.4 mm apart would miss a thing of 1 mm.
    if (size <= 0.001) options.pad = refined(options.pad, 5);
    Extreme row = make("object's size", number_text(1e3 * size) + " mm", options);
    if (size <= 0.001) row.force = 0.01;
    rows.push_back(row);
  }
  for (const double force : {1e-3, 1.0, 100.0, 1e3}) {
    ParallelGraspOptions options = usual();
    options.mass = 1e-4 * std::max(1.0, force);
    options.pad.thickness = 0.02;  // deep enough for 1 kN on 84 texels of 1 kN/m
    Extreme row = make("grip force", number_text(force) + " N", options);
    row.force = force;
    rows.push_back(row);
  }
  for (const int factor : {0, 1, 5, 11}) {
    ParallelGraspOptions options = usual();
    options.mass = 0.05;
    if (factor == 0) {
      options.pad.rows = options.pad.columns = 1;
    } else {
      options.pad = refined(options.pad, factor);
    }
    Extreme row =
        make("texels of a pad", std::to_string(options.pad.rows * options.pad.columns), options);
    if (factor > 1) row.duration = 0.2;
    rows.push_back(row);
  }
}

void add_violence(std::vector<Extreme>& rows) {
  {
    ParallelGraspOptions options = usual();
    options.opening = 0.045;
    rows.push_back(make("deep start", "2.5 mm into each pad", options));
  }
  {
    ParallelGraspOptions options = usual();
    options.opening = 0.056;
    Extreme row = make("thrown into the hand", "5 m/s", options);
    row.start_velocity = {0, 5, 0};
    row.is_held = false;
    row.model.gravity.setZero();
    row.duration = 0.2;
    rows.push_back(row);
  }
}

void add_refusals(std::vector<Extreme>& rows) {
  const auto refused = [&](const std::string& subject, const std::string& value,
                           const std::string& name, auto change) {
    Extreme row = make(subject, value, usual());
    change(row.model);
    row.refused = name;
    rows.push_back(row);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused("object's mass", "0", "GraspModel::mass", [](GraspModel& m) { m.mass = 0; });
  refused("jaw's mass", "0", "slides[1].mass", [](GraspModel& m) { m.slides[1].mass = 0; });
  refused("stiffness k", "-1 N/m", "stiffness",
          [](GraspModel& m) { m.pads[0].law.stiffness = -1; });
  refused("damping c", "NaN", "damping", [&](GraspModel& m) { m.pads[0].law.damping = nan; });
  refused("static friction", "NaN", "static_friction",
          [&](GraspModel& m) { m.pads[1].law.static_friction = nan; });
  refused("inertia", "NaN", "inertia", [&](GraspModel& m) { m.inertia(2, 2) = nan; });
}

/// Of the box along the pads: the means of two windows at the end, so that what swings counts as
/// still.
class Sliding {
 public:
  explicit Sliding(double duration) : window_(0.2 * duration), begin_(duration - 2 * window_) {}
  void add(double time, double height) {
    if (time < begin_) return;
    Window& window = windows_[time < begin_ + window_ ? 0 : 1];
    window.sum += height;
    ++window.count;
  }
  double speed() const {  // m/s
    if (windows_[0].count == 0 || windows_[1].count == 0) return 0;
    return std::abs(windows_[0].sum / windows_[0].count - windows_[1].sum / windows_[1].count) /
           window_;
  }

 private:
  struct Window {
    double sum = 0;
    int count = 0;
  };
  double window_, begin_;  // s
  Window windows_[2];
};

// Runs to the end; the state there, and the most energy on the way and how it slides when asked
// for.
GraspState run(const Extreme& extreme, const StepOptions& options, double* growth,
               double* sliding = nullptr) {
  Sliding slid(extreme.duration);
  GraspStepper stepper(extreme.model, options);
  GraspState state = stepper.state();
  state.velocity = extreme.start_velocity;
  stepper.set_state(state);
  for (const int slide : {0, 1}) stepper.system().set_command(slide, {.force = extreme.force}, 0);
  double previous = growth ? stepper.system().energy(stepper.state()) : 0;
  double scale = std::abs(previous) + 1e-9;
  double slides = 0;
  int since = 0;
  while (stepper.state().time < extreme.duration) {
    stepper.step(extreme.duration);
    slid.add(stepper.state().time, stepper.state().p_WB.z());
    if (!growth || ++since % 10 != 0) continue;
    // Energy less the work of the drives.
    const double now_slides = stepper.state().slide_position[0] + stepper.state().slide_position[1];
    const double work = extreme.force * (now_slides - slides);
    const double energy = stepper.system().energy(stepper.state());
    scale = std::max({scale, std::abs(energy), std::abs(work)});
    *growth = std::max(*growth, (energy - previous - work) / scale);
    previous = energy;
    slides = now_slides;
  }
  if (sliding) *sliding = slid.speed();
  return stepper.state();
}

}  // namespace

std::vector<Extreme> extremes() {
  std::vector<Extreme> rows;
  add_masses(rows);
  add_laws(rows);
  add_steps_and_sizes(rows);
  add_violence(rows);
  add_refusals(rows);
  return rows;
}

ExtremeResult run_extreme(const Extreme& extreme, bool with_reference) {
  ExtremeResult result;
  StepOptions options;
  options.step = extreme.step;
  GraspState state;
  try {
    state = run(extreme, options, &result.energy_growth, &result.sliding);
  } catch (const std::invalid_argument& error) {
    result.refused = true;
    result.message = error.what();
    return result;
  }
  StepOptions fine;
  fine.integration = Integration::kSecondOrder;
  fine.step = std::clamp(extreme.step / 20, 1e-6, 2e-5);
  if (with_reference) {
    result.error = (state.p_WB - run(extreme, fine, nullptr).p_WB).norm();
  }
  result.final_speed = state.velocity.norm();
  // Within the hand, and no faster than what was thrown or fell.
  const double fastest = extreme.start_velocity.norm() + kGravity * extreme.duration;
  result.stable = state.p_WB.allFinite() && state.velocity.allFinite() &&
                  result.final_speed <= fastest && result.energy_growth < 1e-6;
  result.held = result.stable && result.sliding < kStill;
  return result;
}

bool is_as_expected(const Extreme& extreme, const ExtremeResult& result) {
  if (!extreme.refused.empty()) {
    return result.refused && result.message.find(extreme.refused) != std::string::npos;
  }
  if (result.refused || !result.stable) return false;
  return !extreme.is_held || result.held == extreme.limit.empty();
}

std::string outcome(const Extreme& extreme, const ExtremeResult& result) {
  if (result.refused) return "refused: " + result.message;
  if (!result.stable) return "UNSTABLE";
  if (!extreme.is_held) return "stable";
  if (result.held) return "held";
  return extreme.limit.empty() ? "slides" : "limit: " + extreme.limit;
}

std::string extremes_markdown(const std::vector<Extreme>& cases,
                              const std::vector<ExtremeResult>& results) {
  std::string table =
      "# Soft contact at its extremes\n\n"
      "Made by `build/bin/eval_stability --out DIR` (DIR/touch_extremes.md); test_eval_touch runs\n"
      "every row again, but for the reference. A box between two pads of 6 x 14 texels on 50 g "
      "jaws that are pressed "
      "from\n"
      "the start; steps of 1 ms, first order, unless the row says otherwise. Energy: the most "
      "that\n"
      "ten steps added beyond the work of the drives, relative to the largest energy seen (0: it\n"
      "only fell). Held: at the end the box slides by less than 0.1 mm/s, means over 0.2 of the\n"
      "time, so that what still swings in the foam counts as held. Error: of the box's centre at "
      "the end, against a second-order reference of at\n"
      "least 20 times finer steps; a first-order step that meets an impact coarsely moves the\n"
      "moment of grip, and so the height at which a falling box is caught.\n\n"
      "| what | value | result | energy | sliding [mm/s] | speed at the end [m/s] | error [um] |\n"
      "|---|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const ExtremeResult& r = results[i];
    table += "| " + cases[i].subject + " | " + cases[i].value + " | ";
    table += outcome(cases[i], r) + " | ";
    if (r.refused) {
      table += "| | | |\n";
    } else {
      table += number_text(std::max(0.0, r.energy_growth), 2) + " | " +
               number_text(1e3 * r.sliding, 2) + " | " + number_text(r.final_speed, 2) + " | " +
               number_text(1e6 * r.error, 2) + " |\n";
    }
  }
  return table;
}

}  // namespace prehend::eval::touch
