#include "eval/belief/surprise_trial.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <Eigen/Geometry>

#include "eval/belief/predicted_case.h"
#include "eval/belief/rendered_hold.h"
#include "eval/grasp/trial_setup.h"
#include "eval/household_objects.h"
#include "eval/processor_time.h"
#include "eval/resting_pose.h"
#include "prehend/belief/object_belief.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/planning/hand_act.h"
#include "prehend/robot/placed_links.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr double kRightWithin = 0.003, kWrongBeyond = 0.008;  // m
constexpr double kSlid = 0.01, kRaised = 0.02;                // m
constexpr double kWristForceNoise = 0.1;                      // N, of the FT 300
// m, rad, standard: the hand is so much beside where it is said to be, as in look_trial.h.
constexpr double kPlacement = 0.0005, kOrientation = 0.002;
constexpr int kRightActs = 4;
constexpr double kFar = 1;       // m
constexpr double kStep = 0.002;  // s, of the acts; predictions have 4 ms

/// What the acts of a case have in common.
class ActsOfCase {
 public:
  ActsOfCase(const Case& one, const TouchingHand& hand, const grasp::Grasp& grasp,
             const TriangleMesh& believed_W)
      : hand_(hand.model()),
        planned_(grasp),
        truth_W_(geometry::transformed(*one.data_set->mesh_B, one.X_WB())),
        mass_(household_mass(geometry::mass_properties(truth_W_).volume)),
        random_(static_cast<std::uint32_t>(one.seed * 1000003 + 17 * one.orientation + 5)),
        rendered_(scene_of(one)),
        looks_random_(one.seed) {
    const RigidTransform X_WH_closed = planning::hand_root(hand_, to_feel());
    X_WH_lifted_ = X_WH_closed;
    X_WH_lifted_.translation().z() += belief::ActOptions().lift_height;
    constexpr int kSamples = 5000;
    shape_off_ = surface::deviation(surface::sample_surface(truth_W_, kSamples, 1),
                                    geometry::MeshQuery(believed_W));
    thought_W_ = geometry::transformed(belief::thought_surface(believed_W),
                                       X_WH_lifted_ * X_WH_closed.inverse(Eigen::Isometry));
  }

  /// The camera that has seen the object sees it lifted, too.
  belief::ViewAfterLift view() const {
    return {rendered_.scene.camera.camera.left, rendered_.scene.camera.X_WC(), X_WH_lifted_, {}};
  }

  planning::GraspToFeel to_feel() const {
    constexpr double kLeastEffort = 1e-3;  // as planning::add_touch()
    return {planned_.X_WG,   planned_.preshape, planned_.open,
            planned_.closed, planned_.force,    std::clamp(planned_.effort, kLeastEffort, 1.0)};
  }

  const surface::DeviationStatistics& shape_off() const { return shape_off_; }

  void run(SurpriseCase* result) {
    int held = 0;
    for (int i = 0; i < kRightActs; ++i) held += right(result);
    for (const double scale : {0.7, 1.35}) wrong(scale * between(0.95, 1.05), result);
    moved(result);
    moved(result);
    fell(result);
    if (held > 0) slips(result);
    absent(result);
  }

 private:
  double between(double a, double b) {
    return a + (b - a) * std::uniform_real_distribution<double>(0, 1)(random_);
  }
  Eigen::Vector3d level(double length) {
    const double way = between(-M_PI, M_PI);
    return length * Eigen::Vector3d(std::cos(way), std::sin(way), 0);
  }
  static TriangleMesh shifted(const TriangleMesh& mesh, const Eigen::Vector3d& by) {
    RigidTransform X = RigidTransform::Identity();
    X.translation() = by;
    return geometry::transformed(mesh, X);
  }
  double off(const TriangleMesh& mesh_W) const {
    const geometry::MeshQuery query(mesh_W);
    const std::vector<Eigen::Vector3d> points = grasp::contact_points(planned_);
    double sum = 0;
    for (const auto& p_W : points) sum += query.nearest(p_W)->distance;
    return sum / static_cast<double>(points.size());
  }

  belief::SimulatedAct act(const TriangleMesh& mesh_W, double mass, double friction) {
    belief::ActOptions options;
    options.touch.world.step = kStep;
    options.touch.world.tactile.sensor = simulation::TactileSensorOptions::realistic();
    options.touch.world.tactile.sensor.seed = static_cast<std::uint32_t>(random_());
    options.touch.world.tactile.foam = contact::FoamMemory::realistic();
    options.touch.world.wrench.emplace();
    options.touch.world.wrench->force_noise = kWristForceNoise;
    options.touch.friction = friction;
    belief::SimulatedAct act = belief::simulate_act(hand_, to_feel(), {mesh_W, {}, mass}, options);
    act.percepts.view = seen(mesh_W, act);
    return act;
  }

  // Hand and fingers are said to be a little beside where they are.
  belief::PerceivedView seen(const TriangleMesh& mesh_W, const belief::SimulatedAct& act) {
    const auto links_W = robot::placed_hand_links(hand_, X_WH_lifted_, act.joints);
    const geometry::DepthImage depth = seen_hold(rendered_, std::make_shared<TriangleMesh>(mesh_W),
                                                 X_WH_lifted_ * act.X_HO, links_W, ++looks_);
    const RigidTransform said =
        disturbance(kPlacement, kOrientation, X_WH_lifted_.translation(), &looks_random_);
    const belief::ViewAfterLift view = this->view();
    belief::LiftedView seen{view.camera, view.X_WC, {}, said * X_WH_lifted_, {}, thought_W_};
    for (const TriangleMesh& link_W : links_W) {
      seen.robot_W.push_back(geometry::transformed(link_W, said));
    }
    return belief::perceived_view(depth, seen);
  }
  static bool is_held(const belief::SimulatedAct& act) {
    return act.slide <= kSlid && act.raised >= kRaised;
  }

  // 1 when it was one.
  int add(ActTruth truth, double off, const TriangleMesh& mesh_W, double mass, double friction,
          SurpriseCase* result) {
    try {
      SurpriseAct done{truth, off, act(mesh_W, mass, friction)};
      // Where the open hand touches what is there, it is not as predicted, whatever the contacts
      // say.
      const bool fits = truth == ActTruth::kRight   ? is_held(done.act) && !done.act.begins_in_touch
                        : truth == ActTruth::kSlips ? !is_held(done.act)
                                                    : true;
      if (fits) result->acts.push_back(std::move(done));
      result->left_out += !fits;
      return fits;
    } catch (const geometry::InputError&) {  // it does not stand so
      ++result->left_out;
      return 0;
    }
  }

  int right(SurpriseCase* result) {
    const TriangleMesh mesh_W = shifted(truth_W_, level(between(0, 0.0025)));
    const double friction = between(0.6, 0.8);
    const double distance = off(mesh_W);
    const bool is_right = std::max(distance, shape_off_.mean) <= kRightWithin &&
                          shape_off_.percentile_95 < kWrongBeyond;
    if (!is_right) {
      ++result->left_out;
      // Believed worse than that where it matters.
      if (distance >= kWrongBeyond) {
        add(ActTruth::kWrong, distance, mesh_W, mass_, friction, result);
      }
      return 0;
    }
    return add(ActTruth::kRight, distance, mesh_W, mass_, friction, result);
  }

  void wrong(double scale, SurpriseCase* result) {
    TriangleMesh mesh_W = truth_W_;
    Eigen::Vector3d middle = geometry::bounds(mesh_W).center();
    middle.z() = 0;
    for (auto& p : mesh_W.vertices) p = middle + scale * (p - middle);
    const double distance = off(mesh_W);
    if (distance < kWrongBeyond) {
      ++result->left_out;
      return;
    }
    add(ActTruth::kWrong, distance, mesh_W, mass_, between(0.6, 0.8), result);
  }

  void moved(SurpriseCase* result) {
    const double by = between(0.008, 0.02);
    add(ActTruth::kMoved, by, shifted(truth_W_, level(by)), mass_, between(0.6, 0.8), result);
  }

  void fell(SurpriseCase* result) {
    const Eigen::Vector3d middle = geometry::bounds(truth_W_).center();
    const double way = between(-M_PI, M_PI);
    const Eigen::Vector3d axis(std::cos(way), std::sin(way), 0);
    RigidTransform X = RigidTransform::Identity();
    X.linear() = Eigen::AngleAxisd(M_PI / 2, axis).toRotationMatrix();
    X.translation() = middle - X.linear() * middle;
    TriangleMesh mesh_W = geometry::transformed(truth_W_, X);
    mesh_W = shifted(mesh_W, -geometry::bounds(mesh_W).min().z() * Eigen::Vector3d::UnitZ());
    RigidTransform X_rest = resting_pose(mesh_W, RigidTransform::Identity(), mass_, {}, 5);
    const TriangleMesh rests = geometry::transformed(mesh_W, X_rest);
    Eigen::Vector3d back = middle - geometry::bounds(rests).center();
    back.z() = 0;
    const TriangleMesh lies = shifted(rests, back);
    // A ball that rolled on is as it was.
    if (off(lies) < kWrongBeyond) {
      ++result->left_out;
      return;
    }
    add(ActTruth::kFell, off(lies), lies, mass_, between(0.6, 0.8), result);
  }

  void slips(SurpriseCase* result) {
    add(ActTruth::kSlips, 0, truth_W_, mass_ * between(2, 4), between(0.05, 0.15), result);
  }
  void absent(SurpriseCase* result) {
    add(ActTruth::kAbsent, kFar, shifted(truth_W_, {kFar, 0, 0}), mass_, 0.7, result);
  }

  const robot::HandModel& hand_;
  const grasp::Grasp& planned_;
  TriangleMesh truth_W_;
  double mass_;  // kg
  std::mt19937 random_;
  RenderedScene rendered_;
  std::mt19937_64 looks_random_;
  RigidTransform X_WH_lifted_ = RigidTransform::Identity();
  geometry::PointCloud thought_W_;          // lifted with the hand
  surface::DeviationStatistics shape_off_;  // see SurpriseCase
  int looks_ = 0;
};

std::vector<belief::PossibleShape> shapes_of(const belief::ObjectBelief& belief) {
  std::vector<belief::PossibleShape> shapes;
  for (std::size_t i = 0; i < belief.shapes().size(); ++i) {
    const belief::BelievedShape& shape = belief.shapes()[i];
    if (shape.weight < belief::PerceptOptions().least_weight * belief.shapes()[0].weight) continue;
    planning::ObjectToFeel object{belief.mesh(i), belief.table_W(), 0};
    object.mass = household_mass(geometry::mass_properties(object.mesh_W).volume);
    shapes.push_back({shape.name, std::move(object), shape.weight});
  }
  return shapes;
}

}  // namespace

std::string to_string(ActTruth truth) {
  switch (truth) {
    case ActTruth::kRight:
      return "right";
    case ActTruth::kWrong:
      return "wrong shape";
    case ActTruth::kMoved:
      return "moved";
    case ActTruth::kFell:
      return "fell";
    case ActTruth::kSlips:
      return "slips";
    case ActTruth::kAbsent:
      return "absent";
  }
  return "unknown";
}

const std::vector<ActTruth>& act_truths() {
  static const std::vector<ActTruth> all{ActTruth::kRight, ActTruth::kWrong, ActTruth::kMoved,
                                         ActTruth::kFell,  ActTruth::kSlips, ActTruth::kAbsent};
  return all;
}

SurpriseCase run_surprise_trial(const Case& one, const TouchingHand& hand) {
  SurpriseCase result;
  result.name = one.name();
  result.group = one.data_set->group;
  try {
    const PredictedCase predicted = predict_case(one);
    belief::ObjectBelief belief(predicted.shape, predicted.support_W);
    belief.update();
    const std::vector<grasp::Grasp> grasps = hand.grasps(belief);
    if (grasps.empty()) throw geometry::InputError("No grasp of it is found", "Take another hand");
    const std::vector<belief::PossibleShape> possible = shapes_of(belief);
    ActsOfCase acts(one, hand, grasps.front(), possible.front().object.mesh_W);
    belief::PerceptOptions options;
    options.view = acts.view();
    result.shape_off = acts.shape_off();
    const double start = processor_time();
    result.predicted = belief::predict_percepts(hand.model(), acts.to_feel(), possible, options);
    if (result.predicted.possible.empty()) {
      throw geometry::InputError("Nothing is predicted: " + result.predicted.problems.front(),
                                 "Look again");
    }
    result.shapes = static_cast<int>(
        std::min<std::size_t>(possible.size(), belief::PerceptOptions().most_shapes));
    result.prediction_seconds = (processor_time() - start) / result.shapes;
    acts.run(&result);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

}  // namespace prehend::eval
