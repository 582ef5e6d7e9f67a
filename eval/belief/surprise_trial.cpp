#include "eval/belief/surprise_trial.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include "eval/grasp/in_reach.h"
#include "eval/grasp/platform_under_test.h"
#include "eval/grasp/resting_pose.h"
#include "eval/grasp/seen_object.h"
#include "eval/processor_time.h"
#include "prehend/belief/percept_forecast.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr double kRightWithin = 0.003, kWrongBeyond = 0.008;  // m
constexpr double kSlid = 0.01, kRaised = 0.02;                // m
constexpr int kRightActs = 4;
constexpr double kFar = 1;  // m

/// What the acts of a case have in common.
class ActsOfCase {
 public:
  ActsOfCase(const Case& one, const SurprisedPlatform& platform, const planning::PlannedPick& pick)
      : platform_(platform),
        pick_(pick),
        truth_W_(geometry::transformed(*one.data_set->mesh_B, one.X_WB())),
        mass_(household_mass(geometry::mass_properties(truth_W_).volume)),
        random_(static_cast<std::uint32_t>(one.seed * 1000003 + 17 * one.orientation + 5)) {}

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
    const std::vector<Eigen::Vector3d> points = grasp::contact_points(pick_.grasp);
    double sum = 0;
    for (const auto& p_W : points) sum += query.nearest(p_W)->distance;
    return sum / static_cast<double>(points.size());
  }

  PlatformAct act(const TriangleMesh& mesh_W, double mass, double friction) {
    simulation::TactileOptions tactile;
    tactile.sensor = simulation::TactileSensorOptions::realistic();
    tactile.sensor.seed = static_cast<std::uint32_t>(random_());
    tactile.foam = contact::FoamMemory::realistic();
    return act_once(platform_.platform(), platform_.home(), pick_, {mesh_W, mass, {}, friction},
                    tactile);
  }
  static bool is_held(const PlatformAct& act) {
    return act.slide <= kSlid && act.raised >= kRaised;
  }

  // 1 when it was one.
  int add(ActTruth truth, double off, const TriangleMesh& mesh_W, double mass, double friction,
          SurpriseCase* result) {
    try {
      SurpriseAct done{truth, off, act(mesh_W, mass, friction)};
      if (!done.act.closed) {
        (truth == ActTruth::kRight ? result->left_out : result->stopped) += 1;
        return 0;
      }
      const bool fits = truth == ActTruth::kRight   ? is_held(done.act)
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
    if (distance > kRightWithin) {
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

  const SurprisedPlatform& platform_;
  const planning::PlannedPick& pick_;
  TriangleMesh truth_W_;
  double mass_;  // kg
  std::mt19937 random_;
};

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

SurprisedPlatform::SurprisedPlatform(const std::string& name)
    : planner_(in_reach(
          robot::read_platform(robot::platform_file(text::tree_file("config/robots"), name)))),
      home_(start_of(planner_.platform())) {}

planning::PlatformPlan SurprisedPlatform::plan(const Belief& belief) const {
  planning::PlatformPlanOptions options(platform().hand);
  options.grasps.threads = 1;
  options.touch.emplace().threads = 1;
  return planner_.plan(belief.object, {}, belief.others, {}, platform().home(home_).arm, options);
}

SurpriseCase run_surprise_trial(const Case& one, const SurprisedPlatform& platform) {
  constexpr int kAlternatives = 2;  // as the node shape_completion has them
  SurpriseCase result;
  result.name = one.name();
  result.group = one.data_set->group;
  try {
    const Belief belief =
        believed_object(one, see_object(one, one.X_WB(), 0), PlannedOn::kPredicted, kAlternatives);
    const planning::PlatformPlan plan = platform.plan(belief);
    if (plan.picks.empty() || plan.picks.front().segments.empty()) {
      throw geometry::InputError("No grasp of it can be executed: " + grasp::in_words(plan),
                                 "Take another platform");
    }
    const planning::PlannedPick& pick = plan.picks.front();
    const double start = processor_time();
    const auto shapes =
        belief::possible_shapes(belief.object, {}, pick.grasp.predicted.lifted_mass);
    result.predicted = belief::predict_percepts(platform.platform().hand,
                                                planning::grasp_to_feel(pick.grasp), shapes);
    if (result.predicted.possible.empty()) {
      throw geometry::InputError("Nothing is predicted: " + result.predicted.problems.front(),
                                 "Look again");
    }
    result.shapes = static_cast<int>(
        std::min<std::size_t>(shapes.size(), belief::PerceptOptions().most_shapes));
    result.prediction_seconds = (processor_time() - start) / result.shapes;
    ActsOfCase(one, platform, pick).run(&result);
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

}  // namespace prehend::eval
