#include "prehend/belief/percept_forecast.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/belief/act_perceiver.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/uncertainty.h"
#include "prehend/planning/hand_act.h"
#include "prehend/robot/placed_links.h"
#include "prehend/text/require.h"

namespace prehend::belief {
namespace {

using geometry::RigidTransform;
using planning::HandAct;
using simulation::RobotWorld;

constexpr double kLookEvery = 0.012;  // s, at the pads and joints while it closes

// Perceives an act of a simulated hand: every kLookEvery while it closes, when it has, and lifted.
class Perceiver {
 public:
  Perceiver(const robot::HandModel& hand, HandAct& act,
            const planning::TouchPredictionOptions& options)
      : hand_(hand),
        act_(act),
        options_(options),
        perceiver_(hand, act.way(), options.grip.touch_force) {
    next_ = act.world().time();
    act.after_step = [this] { look(); };
  }
  ~Perceiver() { act_.after_step = nullptr; }
  Perceiver(const Perceiver&) = delete;

  bool began_in_touch() const { return began_in_touch_; }
  void closed() {
    act_.after_step = nullptr;
    perceiver_.closed(moment());
  }
  Percepts lifted() {
    // The table's normal is up.
    perceiver_.lifted(moment(), act_.world().X_WH());
    return perceiver_.percepts();
  }

 private:
  void look() {
    if (act_.world().time() < next_) return;
    next_ += kLookEvery;
    if (perceiver_.empty()) began_in_touch_ = act_.object().touches_robot;
    perceiver_.closing(moment());
  }

  ActMoment moment() const {
    const RobotWorld& world = act_.world();
    const simulation::ContactWrench wrench = world.wrist_wrench();
    ActMoment now{world.time(), {}, joints_of_motors(), Wrench{wrench.force, wrench.torque}};
    // As the pads' electronics show it, not as the simulation knows it.
    for (const simulation::HandPadReading& pad : world.pads()) {
      const robot::HandPad& model = hand_.pads[now.pads.size()];
      now.pads.push_back(pad_image(*model.layout, {pad.counts.begin(), pad.counts.end()},
                                   model.model.newton_per_count, options_.touch_counts));
    }
    return now;
  }

  // As the joints' states have them: of a coupling that broke away, the motor goes on without the
  // joint.
  Eigen::VectorXd joints_of_motors() const {
    const std::vector<simulation::JointReading> joints = act_.world().joints();
    Eigen::VectorXd positions = act_.world().hand_positions();
    const std::vector<std::string> names = hand_.actuated_names();
    for (std::size_t m = 0; m < names.size(); ++m) {
      const auto joint = std::find_if(joints.begin(), joints.end(),
                                      [&](const auto& one) { return one.name == names[m]; });
      if (joint != joints.end()) positions[static_cast<Eigen::Index>(m)] = joint->position;
    }
    return positions;
  }

  const robot::HandModel& hand_;
  HandAct& act_;
  const planning::TouchPredictionOptions& options_;
  ActPerceiver perceiver_;
  double next_ = 0;  // s
  bool began_in_touch_ = false;
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
  SimulatedAct done;
  done.percepts = perceiver.lifted();
  done.begins_in_touch = perceiver.began_in_touch();
  done.raised = act.object().height - height;
  done.slide = (in_hand().translation() - X_HB.translation()).norm();
  done.X_HO = act.X_HO();
  done.joints = act.all_joints();
  // An object that flies off has no pose; what is perceived of it must have one.
  check_percepts(done.percepts);
  return done;
}

/// What the camera is to show once the hand has lifted, by where acts end.
class ForeseenViews {
 public:
  /// @param thought_W the object's surface as it stands, by what is believed.
  ForeseenViews(const robot::HandModel& hand, const planning::GraspToFeel& grasp,
                const ViewAfterLift& after, const geometry::TriangleMesh& thought_W)
      : hand_(hand), after_(after) {
    const RigidTransform X_WH_closed = planning::hand_root(hand, grasp);
    thought_W_ = geometry::transformed(thought_surface(thought_W),
                                       after.X_WH * X_WH_closed.inverse(Eigen::Isometry));
  }

  PerceivedView of(const SimulatedAct& act, const planning::ObjectToFeel& object) const {
    LiftedView view{after_.camera, after_.X_WC,  object.table_W,
                    after_.X_WH,   after_.arm_W, thought_W_};
    for (auto& link_W : robot::placed_hand_links(hand_, after_.X_WH, act.joints)) {
      view.robot_W.push_back(std::move(link_W));
    }
    return predicted_view(geometry::transformed(object.mesh_W, after_.X_WH * act.X_HO), view);
  }

 private:
  const robot::HandModel& hand_;
  const ViewAfterLift& after_;
  geometry::PointCloud thought_W_;
};

}  // namespace

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

std::vector<PossibleShape> possible_shapes(const surface::ObjectModel& object,
                                           const geometry::Plane& table_W, double mass) {
  const std::vector<double> weights = grasp::shape_weights(object);
  std::vector<PossibleShape> shapes{{"model", {object.mesh_W, table_W, mass}, weights.front()}};
  for (std::size_t i = 0; i < object.alternatives_W.size(); ++i) {
    shapes.push_back({fmt::format("alternative {}", i + 1),
                      {object.alternatives_W[i], table_W, mass},
                      weights[i + 1]});
  }
  return shapes;
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
  std::optional<ForeseenViews> views;
  if (options.view) views.emplace(hand, grasp, *options.view, shapes.front().object.mesh_W);
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
          SimulatedAct done = perform(hand, act, at, options.act);
          if (views) done.percepts.view = views->of(done, shape.object);
          here.push_back({shape.name, place.along, place.across, shape.weight * place.weight,
                          std::move(done.percepts)});
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
