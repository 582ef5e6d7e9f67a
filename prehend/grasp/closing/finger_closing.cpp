#include "prehend/grasp/closing/finger_closing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "prehend/geometry/gravity.h"
#include "prehend/grasp/wrench/force_limits.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using Quantity = Miss::Quantity;

using geometry::kGravity;
constexpr double kPrecision = 0.05;  // of epsilon while candidates are compared
constexpr double kPoint = 1e-5;      // m, size of the triangle that stands for a point of a cloud
constexpr double kMeeting =
    1e-3;  // m, by which links' balls may overlap without being said to meet

/// A bound of how far any point of the hand is from its root [m], whatever its joints do.
double radius_of(const HandToClose& hand) {
  const robot::RobotModel& model = hand.hand->model;
  std::vector<double> to_link(model.links.size(), 0);
  for (const robot::Joint& joint : model.joints) {
    const double travel = joint.kind == robot::Joint::Kind::kPrismatic
                              ? std::max(std::abs(joint.lower), std::abs(joint.upper))
                              : 0;
    to_link[static_cast<std::size_t>(joint.child)] =
        to_link[static_cast<std::size_t>(joint.parent)] + joint.X_PJ.translation().norm() + travel;
  }
  double radius = 0;
  for (std::size_t l = 0; l < to_link.size(); ++l) {
    radius = std::max(radius, to_link[l] + hand.balls.links[l].reach);
  }
  return radius;
}

/// Where the hand may be that touches the object, or comes to it [m]: what lies elsewhere is out of
/// its reach, and no part of what distances are measured to, which may not be too large for a grid.
Eigen::AlignedBox3d within_reach(const ClosingTask& task) {
  Eigen::AlignedBox3d box_W = geometry::bounds(task.solid.mesh_W);
  const double reach = 2 * radius_of(task.hand) + task.options.pregrasp_distance +
                       task.options.fingers.closing.farthest_push +
                       task.options.collision.obstacle_margin;
  box_W.min().array() -= reach;
  box_W.max().array() += reach;
  return box_W;
}

/// All obstacles in a box as one mesh to measure distances to.
geometry::TriangleMesh obstacle_mesh(const Obstacles& obstacles, const Eigen::AlignedBox3d& box_W) {
  std::vector<geometry::TriangleMesh> near_W;
  for (const geometry::TriangleMesh& mesh_W : obstacles.meshes_W) {
    if (box_W.intersects(geometry::bounds(mesh_W))) near_W.push_back(mesh_W);
  }
  geometry::TriangleMesh all = geometry::concatenated(near_W);
  for (const auto& point : obstacles.cloud_W.points) {
    if (!point.allFinite() || !box_W.contains(point.cast<double>())) continue;
    const int first = static_cast<int>(all.vertices.size());
    const Vector3d p = point.cast<double>();
    all.vertices.push_back(p);
    all.vertices.push_back(p + kPoint * Vector3d::UnitX());
    all.vertices.push_back(p + kPoint * Vector3d::UnitY());
    all.triangles.emplace_back(first, first + 1, first + 2);
  }
  return all;
}

/// The positions of the motors among those of all joints.
Eigen::VectorXd motors_of(const robot::HandModel& hand, const Eigen::VectorXd& all) {
  Eigen::VectorXd motors(hand.size());
  for (int i = 0; i < hand.size(); ++i) motors[i] = all[hand.actuated[static_cast<std::size_t>(i)]];
  return motors;
}

/// Whether balls of two links overlap by more than kMeeting.
bool overlap(const LinkBalls& a, const RigidTransform& X_WA, const LinkBalls& b,
             const RigidTransform& X_WB, int node_a = 0, int node_b = 0) {
  if (a.nodes.empty() || b.nodes.empty()) return false;
  const auto& na = a.nodes[static_cast<std::size_t>(node_a)];
  const auto& nb = b.nodes[static_cast<std::size_t>(node_b)];
  const double reach = na.radius + nb.radius - kMeeting;
  if (reach <= 0 || (X_WA * na.center - X_WB * nb.center).squaredNorm() >= reach * reach) {
    return false;
  }
  if (na.leaf() && nb.leaf()) {
    for (int i = na.first; i < na.last; ++i) {
      const auto ia = static_cast<std::size_t>(i);
      for (int j = nb.first; j < nb.last; ++j) {
        const auto jb = static_cast<std::size_t>(j);
        const double touch = a.radii[ia] + b.radii[jb] - kMeeting;
        if ((X_WA * a.centers[ia] - X_WB * b.centers[jb]).squaredNorm() < touch * touch) {
          return true;
        }
      }
    }
    return false;
  }
  if (!na.leaf() && (nb.leaf() || na.radius > nb.radius)) {
    return overlap(a, X_WA, b, X_WB, na.first, node_b) ||
           overlap(a, X_WA, b, X_WB, na.right, node_b);
  }
  return overlap(a, X_WA, b, X_WB, node_a, nb.first) || overlap(a, X_WA, b, X_WB, node_a, nb.right);
}

}  // namespace

FingerClosing::FingerClosing(const ClosingTask& task)
    : solid_(task.solid),
      grid_(task.query_W),
      table_(task.table),
      hand_(task.hand),
      reachability_(task.reachability),
      options_(task.options) {
  geometry::TriangleMesh others = obstacle_mesh(task.obstacles, within_reach(task));
  if (others.empty()) return;
  obstacle_query_.emplace(std::move(others));
  obstacle_grid_.emplace(*obstacle_query_);
}

HandReach FingerClosing::reach(const robot::Preshape& preshape) const {
  return hand_reach(hand_, preshape);
}

std::span<const Reason> FingerClosing::stages() const {
  static constexpr Reason kStages[] = {
      Reason::kDirection,  Reason::kTable,     Reason::kObject,      Reason::kObstacle,
      Reason::kWorkspace,  Reason::kArm,       Reason::kFingerTable, Reason::kFingerObstacle,
      Reason::kFewFingers, Reason::kNotClosed, Reason::kFingersMeet, Reason::kTooWeak};
  return kStages;
}

bool FingerClosing::same(const Grasp& a, const Grasp& b) const {
  constexpr double kPosition = 2e-3, kAngle = 0.04;  // m, rad
  return (a.preshape == b.preshape ||
          (a.closed_all - b.closed_all).lpNorm<Eigen::Infinity>() < kAngle) &&
         (a.X_WH.translation() - b.X_WH.translation()).norm() < kPosition &&
         Eigen::AngleAxisd(a.X_WH.linear().transpose() * b.X_WH.linear()).angle() < kAngle;
}

// Moves the open hand in until something is as near as its margin lets it be.
std::optional<Refusal> FingerClosing::approach(const robot::Preshape& preshape, Grasp* grasp,
                                               Advance* advance) const {
  const Eigen::VectorXd open = hand_.hand->all_positions(preshape.open);
  const double way = options_.pregrasp_distance;
  RigidTransform start = grasp->X_WH;
  start.translation() -= way * grasp->approach_W;
  *advance = {way, Touched::kNothing, -1};
  const auto move = [&](const TouchScene& scene, double margin, Touched obstacle) {
    const Advance one =
        advance_hand(hand_, start, open, grasp->approach_W, advance->distance, margin, scene);
    if (one.what == Touched::kNothing) return;
    *advance = one;
    if (obstacle != Touched::kNothing) advance->what = obstacle;
  };
  const auto miss = [&] {
    return Miss{Quantity::kLength, way - advance->distance, options_.fingers.largest_shortfall};
  };
  // The table's margin is kept by a table that much higher, so that both are one way. The table
  // first: it costs next to nothing, and refuses most.
  geometry::Plane higher = table_;
  higher.offset += options_.collision.table_margin - options_.collision.object_margin;
  move({nullptr, higher, nullptr}, options_.collision.object_margin, Touched::kNothing);
  if (miss().value > options_.fingers.largest_shortfall) return Refusal{Reason::kTable, miss()};
  move({&grid_, std::nullopt, nullptr}, options_.collision.object_margin, Touched::kNothing);
  if (miss().value > options_.fingers.largest_shortfall) return Refusal{Reason::kObject, miss()};
  if (obstacle_grid_) {
    move({&*obstacle_grid_, std::nullopt, nullptr}, options_.collision.obstacle_margin,
         Touched::kObstacle);
  }
  const double short_by = way - advance->distance;
  if (advance->what == Touched::kObstacle) {
    return Refusal{Reason::kObstacle, Miss{Quantity::kLength, short_by, 0}};
  }
  grasp->X_WH.translation() -= short_by * grasp->approach_W;
  return std::nullopt;
}

bool FingerClosing::fingers_meet(const Grasp& grasp) const {
  const robot::HandModel& hand = *hand_.hand;
  std::vector<RigidTransform> poses;
  hand.link_poses(grasp.closed_all, poses);
  for (std::size_t a = 0; a < hand.fingers.size(); ++a) {
    for (std::size_t b = a + 1; b < hand.fingers.size(); ++b) {
      for (const int la : hand.fingers[a].links) {
        for (const int lb : hand.fingers[b].links) {
          const auto ia = static_cast<std::size_t>(la), ib = static_cast<std::size_t>(lb);
          if (overlap(hand_.balls.links[ia], poses[ia], hand_.balls.links[ib], poses[ib])) {
            return true;
          }
        }
      }
    }
  }
  return false;
}

// Closes the fingers of a hand that stands where it closes.
std::optional<Refusal> FingerClosing::close(const robot::Preshape& preshape, Touched stopped_by,
                                            Grasp* grasp, Wrenches* wrenches,
                                            double friction) const {
  TouchScene scene{&grid_, table_, obstacle_grid_ ? &*obstacle_grid_ : nullptr};
  ClosedFingers closed =
      close_fingers(hand_, grasp->X_WH, preshape, preshape.open, scene, options_.fingers.closing);
  if (closed.other == Touched::kTable) return Refusal{Reason::kFingerTable, {}};
  if (closed.other == Touched::kObstacle) return Refusal{Reason::kFingerObstacle, {}};
  auto fingers = std::count(closed.finger_touches.begin(), closed.finger_touches.end(), true);
  fingers += std::any_of(closed.contacts.begin(), closed.contacts.end(),
                         [](const GraspContact& contact) { return contact.finger < 0; });
  if (fingers < options_.fingers.least_fingers) {
    // A hand that the object stopped short of its standoff closes before it.
    return Refusal{stopped_by == Touched::kObject ? Reason::kObject : Reason::kFewFingers, {}};
  }
  std::vector<Contact> contacts;
  for (GraspContact& contact : closed.contacts) {
    if (friction > 0) contact.contact_W.friction = friction;
    contacts.push_back(contact.contact_W);
  }
  *wrenches =
      primitive_wrenches(contacts, solid_.center_of_mass_W, solid_.radius, options_.cone_edges);
  const WrenchHull closure = wrench_hull(*wrenches, {.closure_only = true});
  if (!closure.closed) {
    return Refusal{Reason::kNotClosed, Miss{Quantity::kQuality, -closure.distance, 0}};
  }
  // Jaws of one motor push the object to their middle: planned for is a hand that stands there.
  grasp->X_WH.translation() += closed.push_W;
  grasp->closed_all = std::move(closed.all);
  grasp->contacts = std::move(closed.contacts);
  grasp->closed = motors_of(*hand_.hand, grasp->closed_all);
  return std::nullopt;
}

std::optional<Refusal> FingerClosing::evaluate(const Candidate& candidate,
                                               const robot::Preshape& preshape,
                                               ClosedGrasp* closed) const {
  const robot::HandModel& hand = *hand_.hand;
  Grasp* grasp = &closed->grasp;
  if (!reachability_.reaches_direction(candidate.approach_W)) {
    const double angle =
        std::acos(std::clamp(reachability_.approach_W->dot(candidate.approach_W), -1.0, 1.0));
    return Refusal{Reason::kDirection,
                   Miss{Quantity::kAngle, angle, reachability_.approach_tolerance}};
  }
  const RigidTransform X_GH = (hand.X_HP * preshape.X_PG).inverse();
  grasp->preshape = preshape.name;
  grasp->approach_W = candidate.approach_W;
  grasp->standoff = candidate.standoff;
  grasp->roll = candidate.roll;
  grasp->pregrasp_distance = options_.pregrasp_distance;
  grasp->open = preshape.open;
  grasp->X_WH = candidate.X_WG * X_GH;
  Advance advance;
  if (auto refusal = approach(preshape, grasp, &advance)) return refusal;
  grasp->X_WG = grasp->X_WH * X_GH.inverse();
  const Vector3d p_W = grasp->X_WG.translation();
  for (const Vector3d& p : {p_W, Vector3d(p_W - options_.pregrasp_distance * grasp->approach_W)}) {
    if (!reachability_.reaches_point(p)) return Refusal{Reason::kWorkspace, {}};
  }
  if (options_.reaches) {
    RigidTransform pregrasp = grasp->X_WH;
    pregrasp.translation() -= options_.pregrasp_distance * grasp->approach_W;
    if (!options_.reaches(grasp->X_WH) || !options_.reaches(pregrasp)) {
      return Refusal{Reason::kArm, {}};
    }
  }

  Wrenches wrenches;
  if (auto refusal = close(preshape, advance.what, grasp, &wrenches)) return refusal;
  const RigidTransform X_WG = grasp->X_WH * X_GH.inverse();
  const bool pushed = !X_WG.translation().isApprox(grasp->X_WG.translation(), 1e-9);
  if (pushed && options_.reaches && !options_.reaches(grasp->X_WH)) {
    return Refusal{Reason::kArm, {}};
  }
  grasp->X_WG = X_WG;
  if (fingers_meet(*grasp)) return Refusal{Reason::kFingersMeet, {}};
  grasp->quality = wrench_hull(wrenches, {.precision = kPrecision}).epsilon;
  grasp->predicted.lifted_mass = solid_.mass;
  grasp->score = score(*grasp);
  return std::nullopt;
}

HandForces FingerClosing::forces(const Grasp& grasp) const {
  ClosedFingers closed;
  closed.all = grasp.closed_all;
  closed.contacts = grasp.contacts;
  const robot::HandModel& hand = *hand_.hand;
  const Eigen::VectorXd coupled = hand.all_positions(grasp.closed);
  for (const robot::Breakaway& breakaway : hand.breakaways) {
    closed.broken_away.push_back(std::max(
        0.0, std::abs(grasp.closed_all[breakaway.joint] - coupled[breakaway.joint]) - 1e-9));
  }
  return hand_forces(hand, grasp.X_WH, closed, solid_.center_of_mass_W, solid_.radius,
                     options_.cone_edges);
}

Vector6 FingerClosing::load() const {
  Vector6 load = Vector6::Zero();
  load.head<3>() = -solid_.mass * (kGravity + options_.lift_acceleration) * table_.normal;
  return load;
}

std::optional<Refusal> FingerClosing::refine(ClosedGrasp* closed) const {
  Grasp* grasp = &closed->grasp;
  const HandForces forces = this->forces(*grasp);
  const Holding holding = hold(forces, load());
  grasp->effort = options_.safety_factor * holding.share;
  if (!(grasp->effort <= 1)) {
    return Refusal{Reason::kTooWeak, std::isfinite(grasp->effort)
                                         ? std::optional(Miss{Quantity::kQuality, grasp->effort, 1})
                                         : std::nullopt};
  }
  grasp->torques = options_.safety_factor * holding.torques;
  grasp->margin = disturbance_margin(forces, load());
  grasp->quality = wrench_hull(forces.wrenches).epsilon;
  if (options_.fingers.volume) grasp->volume = wrench_volume(forces.wrenches);
  grasp->score = score(*grasp);
  return std::nullopt;
}

bool FingerClosing::holds(const Grasp& grasp, const RigidTransform& X_WG, double friction) const {
  const RigidTransform X_WH = X_WG * (grasp.X_WG.inverse() * grasp.X_WH);
  Grasp tried;
  tried.X_WH = X_WH;
  const robot::Preshape& preshape = hand_.hand->preshape(grasp.preshape);
  const RigidTransform start = geometry::RigidTransform(
      Eigen::Translation3d(-grasp.pregrasp_distance * grasp.approach_W) * X_WH);
  const TouchScene scene{&grid_, table_, obstacle_grid_ ? &*obstacle_grid_ : nullptr};
  const Advance way = advance_hand(hand_, start, hand_.hand->all_positions(grasp.open),
                                   grasp.approach_W, grasp.pregrasp_distance, 0, scene);
  Wrenches wrenches;
  return way.what == Touched::kNothing &&
         !close(preshape, Touched::kNothing, &tried, &wrenches, friction) &&
         hold(forces(tried), load()).share <= 1;
}

Eigen::VectorXd FingerClosing::stops(const Grasp& grasp) const {
  const robot::Preshape& preshape = hand_.hand->preshape(grasp.preshape);
  const TouchScene scene{&grid_, table_, obstacle_grid_ ? &*obstacle_grid_ : nullptr};
  const ClosedFingers closed =
      close_fingers(hand_, grasp.X_WH, preshape, grasp.open, scene, options_.fingers.closing);
  const bool touches = std::find(closed.finger_touches.begin(), closed.finger_touches.end(),
                                 true) != closed.finger_touches.end();
  return touches ? motors_of(*hand_.hand, closed.all) : Eigen::VectorXd();
}

double FingerClosing::score(const Grasp& grasp) const {
  const FingerOptions::Weights& w = options_.fingers.weights;
  Vector3d mean = Vector3d::Zero();
  double on_pads = 0;
  for (const GraspContact& contact : grasp.contacts) {
    mean += contact.contact_W.point / static_cast<double>(grasp.contacts.size());
    const bool on_pad = contact.pad >= 0 || hand_.hand->pads.empty();
    on_pads += (on_pad ? 1.0 : 0.0) / static_cast<double>(grasp.contacts.size());
  }
  const double weight = solid_.mass * kGravity;
  const double sum = w.quality * grasp.quality / (grasp.quality + 0.05) +
                     w.margin * grasp.margin / (grasp.margin + weight) +
                     w.centredness * std::exp(-(mean - solid_.center_of_mass_W).norm() / 0.03) +
                     w.pads * on_pads;
  return sum / (w.quality + w.margin + w.centredness + w.pads);
}

HandReach hand_reach(const HandToClose& hand, const robot::Preshape& preshape) {
  constexpr int kSteps = 16;
  const robot::HandModel& model = *hand.hand;
  const RigidTransform X_GH = (model.X_HP * preshape.X_PG).inverse();
  HandReach reach;
  reach.tip_z = -std::numeric_limits<double>::infinity();
  double inner[2] = {std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity()};  // at +y and -y
  std::vector<RigidTransform> poses;
  Eigen::VectorXd motors = preshape.open;
  for (int step = 0; step <= kSteps; ++step) {
    // Over a right angle of closing, or until a joint is at its limit.
    const Eigen::VectorXd all = model.all_positions(motors);
    if (step > 0 && !model.limit_problem(all).empty()) break;
    model.link_poses(all, poses);
    for (const robot::Finger& finger : model.fingers) {
      for (const int link : finger.links) {
        const LinkBalls& balls = hand.balls.links[static_cast<std::size_t>(link)];
        for (std::size_t b = 0; b < balls.centers.size(); ++b) {
          const Eigen::Vector3d p_G =
              X_GH * (poses[static_cast<std::size_t>(link)] * balls.centers[b]);
          reach.tip_z = std::max(reach.tip_z, p_G.z() + balls.radii[b]);
          if (step > 0 || link != finger.links.back()) continue;
          if (p_G.y() > 0) inner[0] = std::min(inner[0], p_G.y() - balls.radii[b]);
          if (p_G.y() < 0) inner[1] = std::max(inner[1], p_G.y() + balls.radii[b]);
        }
      }
    }
    for (int i = 0; i < model.size(); ++i) {
      const bool turns =
          model.model.joints[static_cast<std::size_t>(model.actuated[static_cast<std::size_t>(i)])]
              .kind == robot::Joint::Kind::kRevolute;
      motors[i] += preshape.closing[static_cast<std::size_t>(i)].rate *
                   (turns ? std::numbers::pi / 2 : 0.1) / kSteps;
    }
  }
  reach.max_opening = std::isfinite(inner[0] - inner[1]) ? std::max(0.0, inner[0] - inner[1]) : 0;
  reach.pad_length = 0.04;
  for (const auto& pad : model.pads) reach.pad_length = std::max(reach.pad_length, pad.length());
  return reach;
}

}  // namespace prehend::grasp
