#include "prehend/belief/percepts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/planning/hand_act.h"
#include "prehend/text/require.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;
using planning::HandAct;
using simulation::RobotWorld;

constexpr double kLookEvery = 0.012;               // s, at the pads and joints while it closes
constexpr double kStill = 0.02, kStillJaw = 1e-3;  // rad, m: see PerceivedMotor
const std::array<const char*, 2> kMoments{"closed", "lifted"};

void require_finite(bool finite, const std::string& what) {
  if (!finite) throw std::invalid_argument("Percepts: " + what + " is not finite");
}

void check_wrench(const std::optional<Wrench>& wrench, const std::string& name) {
  if (!wrench) return;
  require_finite(wrench->force.allFinite(), "the wrist's force, " + name + ",");
  require_finite(wrench->torque.allFinite(), "the wrist's torque, " + name + ",");
}

// Notes what is perceived while the hand of an act closes, and when it has.
class Perceiver {
 public:
  Perceiver(const robot::HandModel& hand, HandAct& act,
            const planning::TouchPredictionOptions& options)
      : hand_(hand), act_(act), options_(options) {
    for (const robot::HandPad& pad : hand.pads) percepts_.pads.push_back({pad.name, {}, {}});
    for (const std::string& name : hand.actuated_names())
      percepts_.motors.push_back({name, {}, {}});
    start_ = next_ = act.world().time();
    act.after_step = [this] { look(); };
  }
  ~Perceiver() { act_.after_step = nullptr; }
  Perceiver(const Perceiver&) = delete;

  bool began_in_touch() const { return began_in_touch_; }
  void closed() {
    act_.after_step = nullptr;
    note(kClosed);
    if (looks_ > 0) {
      percepts_.closing = Wrench{force_ / looks_, torque_ / looks_};
    }
    for (std::size_t m = 0; m < percepts_.motors.size(); ++m) note_stop(m);
  }
  Percepts lifted() {
    note(kLifted);
    // Up is the table's normal; what it carries pulls the other way.
    percepts_.weight = -(act_.world().X_WH().linear() * percepts_.wrist[kLifted]->force).z();
    return std::move(percepts_);
  }

 private:
  void look() {
    const RobotWorld& world = act_.world();
    if (world.time() < next_) return;
    next_ += kLookEvery;
    if (looks_ == 0) began_in_touch_ = act_.object().touches_robot;
    const simulation::ContactWrench wrench = world.wrist_wrench();
    force_ += wrench.force;
    torque_ += wrench.torque;
    ++looks_;
    times_.push_back(world.time() - start_);
    ways_.push_back(world.hand_positions());
    const double closure = act_.way().closure(ways_.back());
    const std::vector<planning::PredictedPad> pads = act_.read();
    for (std::size_t i = 0; i < pads.size(); ++i) {
      std::optional<double>& touched_at = percepts_.pads[i].touched_at;
      if (!touched_at && image(i, pads[i]).force >= options_.grip.touch_force) touched_at = closure;
    }
  }

  // As its electronics show it, not as the simulation knows it.
  PadImage image(std::size_t i, const planning::PredictedPad& pad) const {
    PadImage image;
    image.center_P = pad.center_P;
    image.area = pad.area;
    for (const std::uint16_t count : pad.counts) {
      const bool touched = count > options_.touch_counts;
      image.texels.push_back(touched ? count * hand_.pads[i].model.newton_per_count : 0);
      image.force += image.texels.back();
    }
    return image;
  }

  void note(std::size_t moment) {
    const std::vector<planning::PredictedPad> pads = act_.read();
    for (std::size_t i = 0; i < pads.size(); ++i) percepts_.pads[i].at[moment] = image(i, pads[i]);
    const Eigen::VectorXd positions = act_.world().hand_positions();
    for (std::size_t m = 0; m < percepts_.motors.size(); ++m) {
      percepts_.motors[m].at[moment] = positions[static_cast<Eigen::Index>(m)];
    }
    const simulation::ContactWrench wrench = act_.world().wrist_wrench();
    percepts_.wrist[moment] = Wrench{wrench.force, wrench.torque};
  }

  void note_stop(std::size_t motor) {
    PerceivedMotor& percept = percepts_.motors[motor];
    const auto at = static_cast<Eigen::Index>(motor);
    const bool slides = hand_.gripper.has_value();
    std::size_t last = times_.size();
    while (last > 0 &&
           std::abs(ways_[last - 1][at] - *percept.at[kClosed]) <= (slides ? kStillJaw : kStill)) {
      --last;
    }
    if (last < times_.size()) percept.stopped_after = times_[last];
  }

  const robot::HandModel& hand_;
  HandAct& act_;
  const planning::TouchPredictionOptions& options_;
  Percepts percepts_;
  double start_ = 0, next_ = 0;  // s
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero(), torque_ = Eigen::Vector3d::Zero();
  int looks_ = 0;
  bool began_in_touch_ = false;
  std::vector<double> times_;  // s
  std::vector<Eigen::VectorXd> ways_;
};

// In words, as what it says is about the object.
template <class Work>
auto in_words(const Work& work) {
  try {
    return work();
  } catch (const planning::ActEnds& end) {
    throw geometry::InputError("The act cannot be simulated: " + end.why,
                               "Take a shape that stands, or look again");
  }
}

SimulatedAct perform(const robot::HandModel& hand, HandAct& act, const planning::GraspToFeel& grasp,
                     const ActOptions& options) {
  act.begin(grasp);
  Perceiver perceiver(hand, act, options.touch);
  act.close();
  perceiver.closed();
  const auto in_hand = [&] {
    return act.world().X_WH().inverse(Eigen::Isometry) * act.object().X_WB;
  };
  const RigidTransform X_HB = in_hand();
  const double height = act.object().height;
  act.lift(options.lift_height, options.lift_time);
  SimulatedAct done{perceiver.lifted(), perceiver.began_in_touch(), 0,
                    act.object().height - height};
  done.slide = (in_hand().translation() - X_HB.translation()).norm();
  // An object that flies off has no pose; what is perceived of it must have one.
  check_percepts(done.percepts);
  return done;
}

}  // namespace

void check_percepts(const Percepts& percepts) {
  for (const PerceivedPad& pad : percepts.pads) {
    for (std::size_t moment = 0; moment < kMoments.size(); ++moment) {
      const PadImage& image = pad.at[moment];
      const std::string where = fmt::format("pad '{}', {}: ", pad.name, kMoments[moment]);
      require_finite(std::isfinite(image.force), where + "force");
      require_finite(std::isfinite(image.area), where + "area");
      require_finite(image.center_P.allFinite(), where + "centre");
      for (std::size_t i = 0; i < image.texels.size(); ++i) {
        require_finite(std::isfinite(image.texels[i]), where + fmt::format("texel {}", i));
      }
    }
    require_finite(std::isfinite(pad.touched_at.value_or(0)),
                   fmt::format("pad '{}': where it first touched", pad.name));
  }
  for (const PerceivedMotor& motor : percepts.motors) {
    for (std::size_t moment = 0; moment < kMoments.size(); ++moment) {
      require_finite(std::isfinite(motor.at[moment].value_or(0)),
                     fmt::format("motor '{}', {}: position", motor.name, kMoments[moment]));
    }
    require_finite(std::isfinite(motor.stopped_after.value_or(0)),
                   fmt::format("motor '{}': when it stopped", motor.name));
  }
  check_wrench(percepts.closing, "closing");
  for (std::size_t m = 0; m < kMoments.size(); ++m) check_wrench(percepts.wrist[m], kMoments[m]);
  require_finite(std::isfinite(percepts.weight.value_or(0)), "the weight");
}

void ActOptions::validate() const {
  touch.validate();
  const text::Require require{"ActOptions::"};
  require(std::isfinite(lift_height) && lift_height > 0, "lift_height must be positive");
  require(std::isfinite(lift_time) && lift_time > 0, "lift_time must be positive");
}

void PerceptOptions::validate() const {
  act.validate();
  const text::Require require{"PerceptOptions::"};
  require(std::isfinite(place) && place >= 0, "place must not be negative");
  require(least_weight >= 0 && least_weight <= 1, "least_weight must be in [0, 1]");
  require(most_shapes >= 1, "most_shapes must be at least 1");
}

SimulatedAct simulate_act(const robot::HandModel& hand, const planning::GraspToFeel& grasp,
                          const planning::ObjectToFeel& object, const ActOptions& options) {
  options.validate();
  planning::check_act(hand, grasp, object);
  return in_words([&] {
    HandAct act(hand, object, options.touch, std::chrono::steady_clock::time_point::max());
    return perform(hand, act, grasp, options);
  });
}

PerceptForecast predict_percepts(const robot::HandModel& hand, const planning::GraspToFeel& grasp,
                                 std::vector<PossibleShape> shapes, const PerceptOptions& options) {
  options.validate();
  const text::Require require{"predict_percepts: "};
  double most = 0;
  for (const PossibleShape& shape : shapes) {
    require(std::isfinite(shape.weight) && shape.weight >= 0, "weights must not be negative");
    planning::check_act(hand, grasp, shape.object);
    most = std::max(most, shape.weight);
  }
  require(most > 0, "there must be a shape with a weight");
  std::stable_sort(shapes.begin(), shapes.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  struct Place {
    double along, across, weight;
  };
  const double off = std::sqrt(3.0) * options.place;
  std::vector<Place> places{{0, 0, 1.0 / 3}};
  for (const double side : {-off, off}) {
    places.push_back({side, 0, 1.0 / 6});
    places.push_back({0, side, 1.0 / 6});
  }
  if (options.place == 0) places = {{0, 0, 1}};
  PerceptForecast predicted;
  double sum = 0;
  int taken = 0;
  for (const PossibleShape& shape : shapes) {
    if (taken == options.most_shapes || shape.weight < options.least_weight * most) break;
    if (shape.weight == 0) break;
    std::vector<PossiblePercepts> here;
    try {
      in_words([&] {
        HandAct act(hand, shape.object, options.act.touch,
                    std::chrono::steady_clock::time_point::max());
        const Eigen::Vector3d up = shape.object.table_W.normal;
        for (const Place& place : places) {
          // The hand is displaced the other way: the object need not be set down again.
          Eigen::Vector3d shift =
              place.along * grasp.X_WG.linear().col(1) + place.across * grasp.X_WG.linear().col(0);
          shift -= shift.dot(up) * up;
          planning::GraspToFeel at = grasp;
          at.X_WG.translation() -= shift;
          here.push_back({shape.name, place.along, place.across, shape.weight * place.weight,
                          perform(hand, act, at, options.act).percepts});
        }
        return true;
      });
    } catch (const std::exception& error) {  // of this shape; the others may do
      predicted.problems.push_back(shape.name + ": " + error.what());
      continue;
    }
    ++taken;
    sum += shape.weight;
    for (PossiblePercepts& one : here) predicted.possible.push_back(std::move(one));
  }
  for (PossiblePercepts& one : predicted.possible) one.weight /= sum;
  return predicted;
}

}  // namespace prehend::belief
