#include "prehend/robot/learning/hand_part.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/uniform_inertial.h"
#include "prehend/robot/learning/hand_shapes.h"
#include "prehend/robot/learning/joint_offsets.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot::learning {
namespace {

using formats::JointDescription;
using formats::LinkDescription;
using formats::RobotDescription;
using formats::Shape;
using geometry::InputError;
using Kind = JointDescription::Kind;

constexpr double kAssumedForce = 10;                // N at the fingertip
constexpr double kAssumedSpeed = 1;                 // rad/s
constexpr double kAssumedSlide = 0.05;              // m/s
constexpr double kLargestForce = 1000;              // N: beyond, it is no finger's
constexpr double kFastest = 50, kFastestSlide = 5;  // rad/s, m/s
constexpr double kCork = 100, kGold = 20000;        // kg/m^3
constexpr double kQuarter = std::numbers::pi / 2;   // rad

bool moves(const JointDescription& joint) {
  return joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
}

/// The robot as a tree of links.
class LinkTree {
 public:
  explicit LinkTree(const RobotDescription& robot) : robot_(robot) {
    for (const JointDescription& joint : robot.joints) {
      below_[joint.parent].push_back(&joint);
      above_[joint.child] = &joint;
    }
    root_ = tree_order(robot).front();
  }

  const std::string& root() const { return root_; }
  const JointDescription* above(const std::string& link) const {
    const auto found = above_.find(link);
    return found == above_.end() ? nullptr : found->second;
  }
  const std::vector<const JointDescription*>& below(const std::string& link) const {
    static const std::vector<const JointDescription*> kNone;
    const auto found = below_.find(link);
    return found == below_.end() ? kNone : found->second;
  }
  /// Whether something moves by this joint or beneath it; what is free does not count.
  bool is_moving(const JointDescription& joint) const {
    if (joint.kind == Kind::kFloating) return false;
    if (moves(joint)) return true;
    const auto& children = below(joint.child);
    return std::any_of(children.begin(), children.end(),
                       [&](const auto* one) { return is_moving(*one); });
  }
  std::vector<const JointDescription*> branches(const std::string& link) const {
    std::vector<const JointDescription*> result;
    for (const auto* joint : below(link)) {
      if (is_moving(*joint)) result.push_back(joint);
    }
    return result;
  }
  /// The link, at or beneath this one, where branches part; empty: a chain to its end.
  /// @param joints that move on the way there
  std::string parting(std::string link, int* joints) const {
    for (;;) {
      const auto ways = branches(link);
      if (ways.size() > 1) return link;
      if (ways.empty()) return {};
      if (moves(*ways.front())) ++*joints;
      link = ways.front()->child;
    }
  }
  void collect(const std::string& link, std::set<std::string>& all) const {
    all.insert(link);
    for (const auto* joint : below(link)) {
      if (joint->kind != Kind::kFloating) collect(joint->child, all);
    }
  }
  bool has_moving_above(const std::string& link) const {
    for (const auto* joint = above(link); joint != nullptr; joint = above(joint->parent)) {
      if (joint->kind != Kind::kFixed) return true;
    }
    return false;
  }

 private:
  const RobotDescription& robot_;
  std::string root_;
  std::map<std::string, std::vector<const JointDescription*>> below_;
  std::map<std::string, const JointDescription*> above_;
};

/// All palms: partings at the ends of arms, or this one where no arm leads on.
void find_palms(const LinkTree& tree, const std::string& from, std::vector<std::string>& palms) {
  constexpr int kArm = 3;  // joints at least
  int ignored = 0;
  const std::string parting = tree.parting(from, &ignored);
  if (parting.empty()) return;
  const std::size_t before = palms.size();
  for (const auto* branch : tree.branches(parting)) {
    int joints = moves(*branch) ? 1 : 0;
    const std::string next = tree.parting(branch->child, &joints);
    if (!next.empty() && joints >= kArm) find_palms(tree, next, palms);
  }
  if (palms.size() == before) palms.push_back(parting);
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "'" : ", '") + word + "'";
  return all;
}

class Cutter {
 public:
  Cutter(const RobotDescription& robot, formats::ShapeMeshes& meshes)
      : given_(robot), tree_(robot), meshes_(meshes) {}

  HandPart cut(const std::string& palm) {
    part_.palm = palm.empty() ? found_palm() : named_palm(palm);
    take_links();
    complete_shapes(part_.robot, meshes_, part_.said);
    complete_joints();
    fold_offsets(part_.robot);
    complete_masses();
    return std::move(part_);
  }

 private:
  void say(const std::string& about, const std::string& what, double sure) {
    part_.said.push_back({about, what, sure});
  }

  std::string found_palm() {
    std::vector<std::string> palms;
    find_palms(tree_, tree_.root(), palms);
    if (palms.empty()) {
      throw InputError("'" + given_.name + "' has no link where two moving fingers part",
                       "A hand has two fingers at least; one with a single chain of joints closes "
                       "on nothing");
    }
    if (palms.size() > 1) {
      throw InputError("'" + given_.name + "' has " + std::to_string(palms.size()) + " hands",
                       "Name the palm of one, one of " + joined(palms));
    }
    say("palm", "'" + palms.front() + "': all moving chains meet there", 0.95);
    return palms.front();
  }

  std::string named_palm(const std::string& palm) {
    if (given_.link(palm) == nullptr) {
      std::vector<std::string> names;
      for (const LinkDescription& link : given_.links) names.push_back(link.name);
      throw InputError("'" + given_.name + "' has no link '" + palm + "'",
                       text::nearest_match_mend(palm, names));
    }
    if (tree_.branches(palm).size() < 2) {
      throw InputError("From '" + palm + "' less than two moving fingers part",
                       "Name the link that the fingers are at");
    }
    say("palm", "'" + palm + "', as given", 1);
    return palm;
  }

  void take_links() {
    const bool on_arm = tree_.has_moving_above(part_.palm);
    std::set<std::string> kept;
    tree_.collect(on_arm ? part_.palm : tree_.root(), kept);
    RobotDescription& robot = part_.robot;
    robot.name = given_.name;
    for (const std::string& name : tree_order(given_)) {
      if (kept.count(name) != 0) robot.links.push_back(*given_.link(name));
    }
    for (const JointDescription& joint : given_.joints) {
      if (kept.count(joint.parent) != 0 && kept.count(joint.child) != 0) {
        robot.joints.push_back(joint);
      }
    }
    for (const auto& pair : given_.disabled_collisions) {
      if (kept.count(pair.first) != 0 && kept.count(pair.second) != 0) {
        robot.disabled_collisions.push_back(pair);
      }
    }
    for (const formats::Actuator& actuator : given_.actuators) {
      if (robot.joint(actuator.joint) != nullptr) robot.actuators.push_back(actuator);
    }
    for (const formats::Sensor& sensor : given_.sensors) {
      if (kept.count(sensor.link) != 0) robot.sensors.push_back(sensor);
    }
    if (on_arm) {
      say("arm",
          fmt::format("left out: {} of {} links are the hand's", robot.links.size(),
                      given_.links.size()),
          0.95);
    }
    if (!given_.loops.empty()) {
      say("loops",
          "closed loops are left open: couplings over them are to be written as joints "
          "that follow",
          0.2);
    }
  }

  void fix(JointDescription& joint, const std::string& why, double sure) {
    const double at = std::clamp(0.0, joint.lower.value_or(0), joint.upper.value_or(0));
    if (joint.kind == Kind::kRevolute) joint.X_PJ.rotate(Eigen::AngleAxisd(at, joint.axis_J));
    if (joint.kind == Kind::kPrismatic) joint.X_PJ.translate(at * joint.axis_J);
    joint.kind = Kind::kFixed;
    joint.follows.reset();
    say("joint '" + joint.name + "'", "stands still: " + why, sure);
  }

  void complete_joints() {
    std::set<std::string> driven;
    for (const formats::Actuator& actuator : part_.robot.actuators) driven.insert(actuator.joint);
    // One that pulls at a tendon may move any of them.
    if (std::any_of(given_.actuators.begin(), given_.actuators.end(),
                    [](const auto& actuator) { return actuator.joint.empty(); })) {
      driven.clear();
    }
    for (JointDescription& joint : part_.robot.joints) {
      if (joint.kind == Kind::kFixed) continue;
      if (!moves(joint)) {
        fix(joint, "it is neither hinge nor slide", 0.5);
        continue;
      }
      if (joint.lower && joint.upper && !(*joint.upper - *joint.lower > 1e-9)) {
        fix(joint, "its limits leave it no way", 1);
        continue;
      }
      const auto* leader = joint.follows ? part_.robot.joint(joint.follows->joint) : nullptr;
      if (leader != nullptr && !joint.follows->is_linear()) {
        // The planner's robots have lines alone.
        const formats::CouplingLine coupling = formats::coupling_line(part_.robot, joint);
        say("joint '" + joint.name + "'",
            "follows '" + leader->name + "' by a polynomial: taken as " +
                formats::words_of_line(coupling, joint),
            0.8);
        joint.follows = coupling.line;
      }
      if (joint.follows && (leader == nullptr || joint.follows->multiplier() == 0)) {
        joint.follows.reset();
        say("joint '" + joint.name + "'", "moves by itself: what it follows is no part of the hand",
            0.5);
      }
      complete_limits(joint);
      const bool is_driven = driven.empty() || driven.count(joint.name) != 0;
      if (!joint.follows && (joint.passive || !is_driven)) {
        follow_above(joint);
      }
    }
    widen_followers();
    assume_efforts();
  }

  /// What follows gets to where its leader takes it, whatever limits it has.
  void widen_followers() {
    for (JointDescription& joint : part_.robot.joints) {
      double multiplier = 1, offset = 0;
      const JointDescription* leader = &joint;
      for (std::size_t steps = 0; leader != nullptr && leader->follows; ++steps) {
        if (steps > part_.robot.joints.size()) return;  // in a ring, which read_urdf() refuses
        offset += multiplier * leader->follows->offset();
        multiplier *= leader->follows->multiplier();
        leader = part_.robot.joint(leader->follows->joint);
      }
      if (leader == nullptr || leader == &joint || !leader->lower || !leader->upper) continue;
      const double one = multiplier * *leader->lower + offset,
                   other = multiplier * *leader->upper + offset;
      constexpr double kRounding = 1e-6;
      const bool fits = std::min(one, other) >= *joint.lower - kRounding &&
                        std::max(one, other) <= *joint.upper + kRounding;
      joint.lower = std::min({*joint.lower, one, other});
      joint.upper = std::max({*joint.upper, one, other});
      if (fits) continue;
      say("joint '" + joint.name + "'",
          "has limits that do not let it follow '" + leader->name + "': they are widened", 0.7);
    }
  }

  void complete_limits(JointDescription& joint) {
    if (joint.lower && joint.upper) return;
    const double way = joint.kind == Kind::kRevolute ? kQuarter : 0.05;
    if (!joint.lower) joint.lower = joint.upper ? std::min(-way, *joint.upper - way) : -way;
    if (!joint.upper) joint.upper = std::max(way, *joint.lower + way);
    say("joint '" + joint.name + "'",
        fmt::format("limits are assumed: {:.3g} to {:.3g}", *joint.lower, *joint.upper), 0.2);
  }

  /// A hinge that nothing drives: as of an underactuated finger, it goes with the one above.
  void follow_above(JointDescription& joint) {
    const JointDescription* above = part_.robot.joint_above(joint.parent);
    while (above != nullptr && above->kind == Kind::kFixed) {
      above = part_.robot.joint_above(above->parent);
    }
    if (above == nullptr || above->kind != Kind::kRevolute || joint.kind != Kind::kRevolute) {
      fix(joint, "the file has no actuator for it", 0.3);
      return;
    }
    joint.follows = formats::Follows{above->name, 1, 0};
    say("joint '" + joint.name + "'",
        "is passive: taken to follow '" + above->name + "' at the same angle", 0.3);
  }

  void assume_efforts() {
    // The reach of what hangs on a joint, by the shapes' boxes, with all joints at 0.
    const auto poses = formats::link_poses(part_.robot, {});
    int efforts = 0, speeds = 0;
    for (JointDescription& joint : part_.robot.joints) {
      if (!moves(joint)) continue;
      const bool slides = joint.kind == Kind::kPrismatic;
      const double reach = slides ? 1 : reach_below(joint, poses);
      if (joint.effort && *joint.effort > kLargestForce * reach) {
        say("joint '" + joint.name + "'",
            fmt::format("its effort of {:g} would press {:.0f} N at the fingertip: not believed",
                        *joint.effort, *joint.effort / reach),
            0.6);
        joint.effort.reset();
      }
      const double fastest = slides ? kFastestSlide : kFastest;
      if (joint.velocity && *joint.velocity > fastest) {
        say("joint '" + joint.name + "'",
            fmt::format("its speed of {:g} is not believed", *joint.velocity), 0.6);
        joint.velocity.reset();
      }
      if (!joint.effort || !(*joint.effort > 0) || !std::isfinite(*joint.effort)) {
        joint.effort = slides ? 2 * kAssumedForce : kAssumedForce * reach;
        ++efforts;
      }
      if (!joint.velocity || !(*joint.velocity > 0) || !std::isfinite(*joint.velocity)) {
        joint.velocity = slides ? kAssumedSlide : kAssumedSpeed;
        ++speeds;
      }
    }
    if (efforts > 0) {
      say("efforts",
          fmt::format("of {} joints are assumed, {} N at the fingertip", efforts, kAssumedForce),
          0.2);
    }
    if (speeds > 0) {
      say("speeds",
          fmt::format("of {} joints are assumed, {} rad/s or {} m/s", speeds, kAssumedSpeed,
                      kAssumedSlide),
          0.2);
    }
  }

  double reach_below(const JointDescription& joint,
                     const std::map<std::string, geometry::RigidTransform>& poses) {
    double reach = 0.02;  // m
    const Eigen::Vector3d p = poses.at(joint.child).translation();
    const std::function<void(const std::string&)> visit = [&](const std::string& name) {
      for (const Shape& shape : part_.robot.link(name)->collisions) {
        for (const Eigen::Vector3d& vertex : meshes_.of(shape).vertices) {
          reach = std::max(reach, (poses.at(name) * shape.X_LS * vertex - p).norm());
        }
      }
      for (const JointDescription& one : part_.robot.joints) {
        if (one.parent == name) visit(one.child);
      }
    };
    visit(joint.child);
    return reach;
  }

  void complete_masses() {
    int assumed = 0, implausible = 0, inertias = 0;
    for (LinkDescription& link : part_.robot.links) {
      const auto uniform = formats::uniform_inertial(link, meshes_);
      if (!uniform) {
        if (link.inertial && !is_body(*link.inertial)) link.inertial.reset();
        continue;
      }
      if (!link.inertial || !(link.inertial->mass > 0)) {
        link.inertial = uniform;
        ++assumed;
        continue;
      }
      const double density = 1000 * link.inertial->mass / uniform->mass;
      if (density > kGold || density < kCork) {
        link.inertial = uniform;
        ++implausible;
      } else if (!is_body(*link.inertial)) {
        link.inertial->inertia = uniform->inertia * (link.inertial->mass / uniform->mass);
        link.inertial->X_LI = uniform->X_LI;
        ++inertias;
      }
    }
    if (assumed > 0) {
      say("masses", fmt::format("of {} links are assumed, 1000 kg/m^3", assumed), 0.4);
    }
    if (implausible > 0) {
      say("masses",
          fmt::format("of {} links are not believed (lighter than cork, heavier than gold), and "
                      "taken as 1000 kg/m^3",
                      implausible),
          0.4);
    }
    if (inertias > 0) {
      say("inertias", fmt::format("of {} links are of their shapes", inertias), 0.6);
    }
  }

  static bool is_body(const formats::Inertial& inertial) {
    if (!(inertial.mass > 0) || !inertial.inertia.allFinite()) return false;
    const Eigen::Vector3d principal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertial.inertia, Eigen::EigenvaluesOnly)
            .eigenvalues();
    return principal[0] > 0 && principal[2] <= (1 + 1e-6) * (principal[0] + principal[1]);
  }

  const RobotDescription& given_;
  LinkTree tree_;
  formats::ShapeMeshes& meshes_;
  HandPart part_;
};

}  // namespace

HandPart hand_part(const RobotDescription& robot, const std::string& palm,
                   formats::ShapeMeshes& meshes) {
  return Cutter(robot, meshes).cut(palm);
}

}  // namespace prehend::robot::learning
