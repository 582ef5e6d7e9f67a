#include "prehend/simulation/hand_grasp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "prehend/contact/require.h"
#include "prehend/robot/closing_way.h"

namespace prehend::simulation {
namespace {

using contact::require;
using contact::require_not_negative;
using contact::require_positive;
using geometry::RigidTransform;

constexpr double kClosingTimeout = 10;  // s
constexpr double kSettling = 0.2;       // s, after closing
constexpr double kHeldHeight = 0.6;     // of the lift that the lowest point must have risen
constexpr double kMostCreep = 0.004;    // m, in half the hold
const std::string kObject = "object";

void check(const HandGrasp& grasp, const HandGraspOptions& options, int motors) {
  require(grasp.X_WG.matrix().allFinite(), "HandGrasp::X_WG", "finite");
  require(grasp.closed.size() == motors && grasp.closed.allFinite(), "HandGrasp::closed",
          "one finite position for each motor");
  require(grasp.open.size() == 0 || (grasp.open.size() == motors && grasp.open.allFinite()),
          "HandGrasp::open", "empty or one finite position for each motor");
  require(std::abs(grasp.approach_direction.norm() - 1) < 1e-6, "HandGrasp::approach_direction",
          "a unit vector");
  require_not_negative(grasp.pregrasp_distance, "HandGrasp::pregrasp_distance");
  require_positive(options.approach_speed, "HandGraspOptions::approach_speed");
  require_not_negative(options.overrun, "HandGraspOptions::overrun");
  require_not_negative(options.gather, "HandGraspOptions::gather");
  require(options.effort > 0 && options.effort <= 1, "HandGraspOptions::effort", "in (0, 1]");
  require_positive(options.lift_height, "HandGraspOptions::lift_height");
  require_positive(options.lift_time, "HandGraspOptions::lift_time");
  require_positive(options.hold_time, "HandGraspOptions::hold_time");
}

void run(RobotWorld& world, double seconds) {
  for (long i = std::lround(seconds / world.options().step); i > 0; --i) world.step();
}

RigidTransform moved(RigidTransform X, const Eigen::Vector3d& by) {
  X.translation() += by;
  return X;
}

class Execution {
 public:
  Execution(const robot::HandModel& hand, const HandGrasp& grasp, const HandGraspOptions& options)
      : hand_(hand),
        grasp_(grasp),
        options_(options),
        shape_(grasp.preshape.empty() ? hand.preshapes.front() : hand.preshape(grasp.preshape)),
        X_WH_(grasp.X_WG * (hand.X_HP * shape_.X_PG).inverse(Eigen::Isometry)),
        world_(hand, moved(X_WH_, -grasp.pregrasp_distance * grasp.approach_direction), shape_.name,
               options.world) {
    if (grasp.open.size() > 0) world_.set_hand(grasp.open);
  }

  HandGraspOutcome run_on(const geometry::TriangleMesh& mesh_W,
                          const std::vector<geometry::TriangleMesh>& obstacles) {
    world_.add_object(kObject, mesh_W, options_.mass, false, options_.friction);
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      world_.add_object(fmt::format("obstacle {}", i), obstacles[i], 1, true, options_.friction);
    }
    X_WB_start_ = world_.body(kObject).X_WB;
    approach();
    if (outcome_.reason.empty()) close();
    if (outcome_.reason.empty()) lift();
    outcome_.time = world_.time();
    return outcome_;
  }

 private:
  void approach() {
    const double duration = std::max(grasp_.pregrasp_distance / options_.approach_speed, 0.05);
    if (grasp_.pregrasp_distance > 0) world_.carry(X_WH_, duration);
    while (!world_.carried()) {
      world_.step();
      outcome_.touched_early = outcome_.touched_early || world_.body(kObject).touches_robot;
    }
    if (!world_.body(kObject).X_WB.matrix().allFinite()) outcome_.reason = "the object flew off";
  }

  // Moves the fingers to `beyond` [rad] past their predicted touch.
  void move_fingers(double beyond) {
    HandCommand command;
    command.speed = options_.closing_speed;
    command.until_contact = true;
    command.position = robot::closing_way(hand_, shape_, grasp_.open, grasp_.closed).at(beyond);
    command.effort.resize(hand_.size());
    for (int i = 0; i < hand_.size(); ++i) {
      const int joint = hand_.actuated[static_cast<std::size_t>(i)];
      command.effort[i] =
          options_.effort * hand_.model.joints[static_cast<std::size_t>(joint)].max_effort;
    }
    world_.move_hand(command);
    const double until = world_.time() + kClosingTimeout;
    while (world_.hand().moving() && world_.time() < until) world_.step();
  }

  void close() {
    if (options_.gather > 0) move_fingers(-options_.gather);
    move_fingers(options_.overrun);
    run(world_, kSettling);
    const RigidTransform X_WB = world_.body(kObject).X_WB;
    outcome_.shift = (X_WB.translation() - X_WB_start_.translation()).norm();
    read_contacts(X_WB_start_ * X_WB.inverse(Eigen::Isometry));
    if (outcome_.fingers == 0) outcome_.reason = "the fingers closed beside the object";
    X_HB_closed_ = world_.X_WH().inverse(Eigen::Isometry) * X_WB;
  }

  // `X_back`: takes points to where the object stood.
  void read_contacts(const RigidTransform& X_back) {
    std::vector<Eigen::Vector3d> points;
    std::set<int> fingers;
    for (const RobotWorld::ObjectTouch& touch : world_.object_touches(kObject)) {
      points.push_back(X_back * touch.p_W);
      if (touch.finger >= 0) fingers.insert(touch.finger);
    }
    outcome_.fingers = static_cast<int>(fingers.size());
    outcome_.contact_error = std::numeric_limits<double>::quiet_NaN();
    if (points.empty() || grasp_.contacts.empty()) return;
    double sum = 0;
    for (const Eigen::Vector3d& predicted : grasp_.contacts) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& p : points) nearest = std::min(nearest, (p - predicted).norm());
      sum += nearest;
    }
    outcome_.contact_error = sum / static_cast<double>(grasp_.contacts.size());
  }

  void lift() {
    const double height = world_.body(kObject).height;
    world_.carry(moved(X_WH_, options_.lift_height * Eigen::Vector3d::UnitZ()), options_.lift_time);
    run(world_, options_.lift_time + 0.5 * options_.hold_time);
    const Eigen::Vector3d halfway = in_hand().translation();
    run(world_, 0.5 * options_.hold_time);
    const RigidTransform X_HB = in_hand();
    outcome_.slip = (X_HB.translation() - X_HB_closed_.translation()).norm();
    outcome_.creep = (X_HB.translation() - halfway).norm();
    outcome_.tilt = Eigen::AngleAxisd(X_HB.linear() * X_HB_closed_.linear().transpose()).angle();
    const RobotBodyReading object = world_.body(kObject);
    if (!object.touches_robot) {
      outcome_.reason = "the object was lost while lifting";
    } else if (object.height - height < kHeldHeight * options_.lift_height) {
      outcome_.reason = fmt::format("the object rose by {:.0f} mm of {:.0f} mm only",
                                    1e3 * (object.height - height), 1e3 * options_.lift_height);
    } else if (outcome_.creep > kMostCreep) {
      outcome_.reason = fmt::format("the object slips: {:.1f} mm in {:.1f} s", 1e3 * outcome_.creep,
                                    0.5 * options_.hold_time);
    } else {
      outcome_.held = true;
      outcome_.reason = "held";
    }
  }

  RigidTransform in_hand() const {
    return world_.X_WH().inverse(Eigen::Isometry) * world_.body(kObject).X_WB;
  }

  const robot::HandModel& hand_;
  const HandGrasp& grasp_;
  const HandGraspOptions& options_;
  const robot::Preshape& shape_;
  RigidTransform X_WH_;
  RobotWorld world_;
  RigidTransform X_WB_start_ = RigidTransform::Identity();
  RigidTransform X_HB_closed_ = RigidTransform::Identity();
  HandGraspOutcome outcome_;
};

}  // namespace

HandGraspOutcome execute_hand_grasp(const robot::HandModel& hand, const HandGrasp& grasp,
                                    const geometry::TriangleMesh& mesh_W,
                                    const HandGraspOptions& options,
                                    const std::vector<geometry::TriangleMesh>& obstacles) {
  check(grasp, options, hand.size());
  return Execution(hand, grasp, options).run_on(mesh_W, obstacles);
}

}  // namespace prehend::simulation
