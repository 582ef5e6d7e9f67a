#include "prehend/grasp/planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/force_closure.h"
#include "prehend/grasp/wrench_hull.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr double kGravity = 9.81;  // m/s^2

// Every way a candidate can be rejected, in words for people.
constexpr const char* kDirection = "approach direction out of the robot's reach";
constexpr const char* kWorkspace = "position outside the workspace";
constexpr const char* kNothing = "a pad would meet nothing";
constexpr const char* kTooWide = "wider than the gripper opens";
constexpr const char* kOffCentre = "section not centred between the fingers";
constexpr const char* kTable = "hand would hit the table";
constexpr const char* kObject = "open hand would hit the object";
constexpr const char* kObstacle = "hand would hit another object";
constexpr const char* kBottomsOut = "contact too small or sharp for the pads";
constexpr const char* kTurns = "closing would turn the object";
constexpr const char* kFinger = "a finger would touch beside its pad";
constexpr const char* kNotClosed = "no force closure";
constexpr const char* kTooHeavy = "too heavy for the grip force";
constexpr const char* kRankedBelow = "ranked below the best";
// In the order of the tests: who fails late was nearly a grasp.
constexpr std::array kStages{kDirection, kNothing,   kTooWide,    kWorkspace, kTable,
                             kObject,    kObstacle,  kBottomsOut, kTurns,     kFinger,
                             kTooHeavy,  kOffCentre, kNotClosed};

void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument("PlannerOptions." + message);
}

// The solid to grasp, with outward triangles.
struct Solid {
  TriangleMesh mesh_W;
  Eigen::Vector3d center_of_mass_W;
  double mass = 0;    // kg
  double radius = 0;  // m, largest distance of the surface to the centre of mass
};

Solid make_solid(const TriangleMesh& mesh_W, double density) {
  const std::string mend = "Complete and mesh the object again";
  if (mesh_W.empty()) throw geometry::InputError("The object's mesh has no triangles", mend);
  const int vertices = static_cast<int>(mesh_W.vertices.size());
  for (const auto& t : mesh_W.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= vertices) {
      throw geometry::InputError("The object's mesh has a triangle with an index out of range",
                                 mend);
    }
  }
  for (const auto& v : mesh_W.vertices) {
    if (!v.allFinite()) {
      throw geometry::InputError("The object's mesh has a vertex with NaN or infinity", mend);
    }
  }
  Solid solid;
  solid.mesh_W = mesh_W;
  geometry::MassProperties properties = geometry::mass_properties(mesh_W);
  if (properties.volume < 0) {
    for (auto& t : solid.mesh_W.triangles) std::swap(t[1], t[2]);
  }
  if (geometry::find_defects(mesh_W).watertight() && properties.volume != 0) {
    properties.volume = std::abs(properties.volume);
  } else {
    properties = geometry::mass_properties(geometry::convex_hull(mesh_W.vertices));
  }
  solid.mass = density * properties.volume;
  solid.center_of_mass_W = properties.center_of_mass;
  for (const auto& v : mesh_W.vertices) {
    solid.radius = std::max(solid.radius, (v - solid.center_of_mass_W).norm());
  }
  return solid;
}

// Turns the candidate about the centroid so that it approaches exactly along `approach_W`.
Candidate snapped(const Candidate& candidate, const Eigen::Vector3d& approach_W,
                  const Eigen::Vector3d& centroid_W) {
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(candidate.approach_W, approach_W);
  Candidate result = candidate;
  result.approach_W = approach_W;
  result.X_WG.linear() = turn * candidate.X_WG.linear();
  result.X_WG.translation() = centroid_W + turn * (candidate.X_WG.translation() - centroid_W);
  return result;
}

class Planner {
 public:
  Planner(Solid solid, const geometry::Plane& table, const Obstacles& obstacles,
          const robot::GripperModel& gripper, const Reachability& reachability,
          const PlannerOptions& options)
      : solid_(std::move(solid)),
        query_(solid_.mesh_W),
        scene_(solid_.mesh_W, table, obstacles, options.collision),
        table_(table),
        gripper_(gripper),
        reachability_(reachability),
        options_(options) {
    largest_force_ =
        options.largest_force > 0
            ? options.largest_force
            : gripper.nominal_current * gripper.force_per_current - gripper.friction_force;
  }

  GraspPlanResult plan();

 private:
  // The reason of the rejection, or nullptr with `grasp` filled in.
  const char* evaluate(Candidate candidate, Grasp* grasp);
  const char* centre(RigidTransform* X_WG);
  const char* find_opening(const RigidTransform& X_WG, double section_width, double* opening) const;
  const char* close(const RigidTransform& X_WG, double opening, ClosedHand* hand, double* force,
                    WrenchHull* hull) const;
  double least_force() const;
  double load_ratio(const ClosedHand& hand, const RigidTransform& X_WG, double force) const;
  double score(const Grasp& grasp, const ClosedHand& hand) const;
  std::string problem(const GraspPlanResult& result) const;

  Solid solid_;
  geometry::MeshQuery query_;
  CollisionScene scene_;
  geometry::Plane table_;
  robot::GripperModel gripper_;
  Reachability reachability_;
  PlannerOptions options_;
  double largest_force_ = 0;                                    // N, per pad
  double narrowest_ = std::numeric_limits<double>::infinity();  // m, outline in reachable views
  double section_width_ = 0;                                    // m, of the last candidate
};

// Shifts the hand along its closing direction to the middle of the section between the pads.
const char* Planner::centre(RigidTransform* X_WG) {
  const SectionExtent section = measure_section(query_, *X_WG, gripper_);
  if (!section.met) return kNothing;
  section_width_ = section.upper - section.lower;
  const double room = gripper_.max_opening - 2 * options_.collision.object_margin;
  double offset = (section.upper + section.lower) / 2;
  if (section_width_ > room) {
    // Perhaps a rim or handle fits between the fingers where they stand.
    const ClosedHand hand =
        close_hand(query_, *X_WG, gripper_.max_opening, least_force(), gripper_, options_.closing);
    if (hand.outcome == ClosingOutcome::kTooWide) return kTooWide;
    if (hand.outcome == ClosingOutcome::kMissed) return kNothing;
    offset = hand.offset;
    section_width_ = hand.opening_at_touch;
  }
  X_WG->translation() += offset * X_WG->linear().col(1);
  return nullptr;
}

// The widest opening that meets nothing on the straight way from the pregrasp.
const char* Planner::find_opening(const RigidTransform& X_WG, double section_width,
                                  double* opening) const {
  const double narrow =
      std::min(gripper_.max_opening, section_width + 2 * options_.opening_clearance);
  const char* reason = nullptr;
  for (double tried : {gripper_.max_opening, narrow}) {
    switch (scene_.check(swept_hand(gripper_, tried, options_.pregrasp_distance), X_WG)) {
      case HandCollision::kNone:
        *opening = tried;
        return nullptr;
      case HandCollision::kTable:
        reason = kTable;
        break;
      case HandCollision::kObject:
        reason = kObject;
        break;
      case HandCollision::kObstacle:
        reason = kObstacle;
        break;
    }
  }
  return reason;
}

double Planner::least_force() const {
  const double weight = solid_.mass * (kGravity + options_.lift_acceleration);
  return std::max(options_.least_force, options_.safety_factor * weight / (2 * options_.friction));
}

// How much of the pads' elliptic limit surface the weight and its torque about the closing
// direction use, times the safety factor; a weight along the closing direction unloads one pad.
double Planner::load_ratio(const ClosedHand& hand, const RigidTransform& X_WG, double force) const {
  const Eigen::Vector3d weight_G = X_WG.linear().transpose() * -table_.normal * solid_.mass *
                                   (kGravity + options_.lift_acceleration);
  const Eigen::Vector3d middle_G = (hand.left.center_G + hand.right.center_G) / 2;
  const Eigen::Vector3d arm_G = X_WG.inverse() * solid_.center_of_mass_W - middle_G;
  const double torque = arm_G.cross(weight_G).y();
  const double tangential = std::hypot(weight_G.x(), weight_G.z());
  const double radius = (hand.left.torsion_radius + hand.right.torsion_radius) / 2;
  const double grip = 2 * options_.friction * force;
  const double slip = std::hypot(tangential / grip, torque / (grip * radius));
  return options_.safety_factor * std::max(slip, std::abs(weight_G.y()) / force);
}

const char* Planner::close(const RigidTransform& X_WG, double opening, ClosedHand* hand,
                           double* force, WrenchHull* hull) const {
  // A second pass with more force when the weight would turn the object between the pads.
  *force = least_force();
  for (int pass = 0; pass < 2; ++pass) {
    if (*force > largest_force_) return kTooHeavy;
    *hand = close_hand(query_, X_WG, opening, *force, gripper_, options_.closing);
    switch (hand->outcome) {
      case ClosingOutcome::kClosed:
        break;
      case ClosingOutcome::kTooWide:
        return kTooWide;
      case ClosingOutcome::kMissed:
        return kNothing;
      case ClosingOutcome::kBottomsOut:
        return kBottomsOut;
      case ClosingOutcome::kTurns:
        return kTurns;
      case ClosingOutcome::kTouchesFinger:
        return kFinger;
    }
    const double ratio = load_ratio(*hand, X_WG, *force);
    if (ratio <= 1 + 1e-9) break;
    if (pass == 1) return kTooHeavy;
    *force *= ratio;
  }
  if (std::abs(hand->offset) > options_.largest_offset) return kOffCentre;
  const auto contact = [this](const ContactPatch& patch) {
    return Contact{patch.center_G, -patch.normal_G, options_.friction, patch.torsion_radius};
  };
  *hull = wrench_hull(primitive_wrenches({contact(hand->left), contact(hand->right)},
                                         X_WG.inverse() * solid_.center_of_mass_W, solid_.radius,
                                         options_.cone_edges));
  return hull->closed ? nullptr : kNotClosed;
}

double Planner::score(const Grasp& grasp, const ClosedHand& hand) const {
  const Eigen::Vector3d center_G = grasp.X_WG.inverse() * solid_.center_of_mass_W;
  const Eigen::Vector3d middle_G = (hand.left.center_G + hand.right.center_G) / 2;
  const Eigen::Vector3d arm_G = center_G - middle_G;
  const double distance = std::hypot(arm_G.x(), arm_G.z());
  const double clearance = scene_.table_clearance(
      swept_hand(gripper_, grasp.pregrasp_opening, grasp.pregrasp_distance), grasp.X_WG);
  const auto& weights = options_.weights;
  const double sum =
      weights.quality * grasp.quality / (grasp.quality + 0.05) +
      weights.centredness * std::exp(-distance / 0.02) +
      weights.area * std::min(1.0, grasp.predicted.contact_area /
                                       (gripper_.pad.length() * gripper_.pad.width())) +
      weights.clearance * std::clamp(clearance / 0.02, 0.0, 1.0);
  return sum / (weights.quality + weights.centredness + weights.area + weights.clearance);
}

const char* Planner::evaluate(Candidate candidate, Grasp* grasp) {
  if (!reachability_.reaches_direction(candidate.approach_W)) return kDirection;
  narrowest_ = std::min(narrowest_, candidate.outline_width);
  if (reachability_.approach_W) {
    candidate = snapped(candidate, *reachability_.approach_W, solid_.center_of_mass_W);
  }
  if (const char* reason = centre(&candidate.X_WG)) return reason;
  const Eigen::Vector3d p_W = candidate.X_WG.translation();
  if (!reachability_.reaches_point(p_W) ||
      !reachability_.reaches_point(p_W - options_.pregrasp_distance * candidate.approach_W)) {
    return kWorkspace;
  }
  double opening = 0;
  if (const char* reason = find_opening(candidate.X_WG, section_width_, &opening)) return reason;
  ClosedHand hand;
  WrenchHull hull;
  double force = 0;
  if (const char* reason = close(candidate.X_WG, opening, &hand, &force, &hull)) return reason;

  grasp->X_WG = candidate.X_WG;
  grasp->approach_W = candidate.approach_W;
  grasp->standoff = candidate.standoff;
  grasp->roll = candidate.roll;
  grasp->pregrasp_opening = opening;
  grasp->pregrasp_distance = options_.pregrasp_distance;
  grasp->grasp_force = force;
  grasp->quality = hull.epsilon;
  grasp->predicted = {hand.opening_at_touch, (hand.left.area + hand.right.area) / 2,
                      (hand.left.force + hand.right.force) / 2, solid_.mass};
  for (const auto& p_G : hand.left.points_G) grasp->left_contacts_W.push_back(grasp->X_WG * p_G);
  for (const auto& p_G : hand.right.points_G) grasp->right_contacts_W.push_back(grasp->X_WG * p_G);
  grasp->score = score(*grasp, hand);
  return nullptr;
}

// The one reason to tell: out of reach, too wide, or the last test that at least a tenth of the
// reachable candidates got to.
std::string Planner::problem(const GraspPlanResult& result) const {
  const auto count = [&result](const char* reason) {
    const auto entry = result.rejections.find(reason);
    return entry == result.rejections.end() ? 0 : entry->second;
  };
  const std::string start = "cannot be grasped: ";
  const int reachable = result.candidates - count(kDirection) - count(kWorkspace);
  if (reachable == 0) return start + "no approach to it is within the robot's reach";

  std::array<char, 200> text{};
  if (narrowest_ > gripper_.max_opening - 2 * options_.collision.object_margin) {
    std::snprintf(text.data(), text.size(),
                  "narrowest width %.0f mm exceeds the gripper's %.0f mm%s", narrowest_ * 1e3,
                  gripper_.max_opening * 1e3,
                  narrowest_ <= gripper_.max_opening ? " less the clearance" : "");
    return start + text.data();
  }
  const char* last = nullptr;
  for (const char* stage : kStages) {
    if (stage != kDirection && stage != kWorkspace && 10 * count(stage) >= reachable) last = stage;
  }
  if (last == kTooHeavy) {
    std::snprintf(text.data(), text.size(),
                  "too heavy for the grip force: %.2f kg need more than %.0f N", solid_.mass,
                  largest_force_);
  } else {
    std::snprintf(text.data(), text.size(), "%s (%d of %d reachable candidates)", last, count(last),
                  reachable);
  }
  return start + text.data();
}

GraspPlanResult Planner::plan() {
  GraspPlanResult result;
  const auto candidates = sample_candidates(solid_.mesh_W, solid_.center_of_mass_W, table_,
                                            gripper_, reachability_, options_.candidates);
  result.candidates = static_cast<int>(candidates.size());
  for (const auto& candidate : candidates) {
    Grasp grasp;
    if (const char* reason = evaluate(candidate, &grasp)) {
      ++result.rejections[reason];
    } else {
      result.grasps.push_back(std::move(grasp));
    }
  }
  std::stable_sort(result.grasps.begin(), result.grasps.end(),
                   [](const Grasp& a, const Grasp& b) { return a.score > b.score; });
  const auto largest = static_cast<std::size_t>(options_.largest_count);
  if (result.grasps.size() > largest) {
    result.rejections[kRankedBelow] = static_cast<int>(result.grasps.size() - largest);
    result.grasps.resize(largest);
  }
  if (result.grasps.empty()) result.problem = problem(result);
  return result;
}

}  // namespace

void PlannerOptions::validate() const {
  candidates.validate();
  closing.validate();
  require(cone_edges >= 3, "cone_edges must be at least 3");
  collision.validate();
  require(density > 0, "density must be positive");
  require(friction > 0, "friction must be positive");
  require(safety_factor >= 1, "safety_factor must be at least 1");
  require(lift_acceleration >= 0, "lift_acceleration must not be negative");
  require(least_force > 0, "least_force must be positive");
  require(largest_force >= 0, "largest_force must not be negative");
  require(pregrasp_distance > 0, "pregrasp_distance must be positive");
  require(opening_clearance >= 0, "opening_clearance must not be negative");
  require(largest_offset >= 0, "largest_offset must not be negative");
  require(largest_count > 0, "largest_count must be positive");
  const auto& w = weights;
  require(w.quality >= 0 && w.centredness >= 0 && w.area >= 0 && w.clearance >= 0 &&
              w.quality + w.centredness + w.area + w.clearance > 0,
          "weights must not be negative, nor all zero");
}

GraspPlanResult plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                            const Obstacles& obstacles, const robot::GripperModel& gripper,
                            const Reachability& reachability, const PlannerOptions& options) {
  options.validate();
  return Planner(make_solid(object.mesh_W, options.density), table, obstacles, gripper,
                 reachability, options)
      .plan();
}

}  // namespace prehend::grasp
