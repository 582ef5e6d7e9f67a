#include "prehend/grasp/closing/pad_closing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/gravity.h"
#include "prehend/geometry/rotation_between.h"
#include "prehend/grasp/wrench/force_closure.h"
#include "prehend/text/told_apart.h"

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using Quantity = Miss::Quantity;

using geometry::kGravity;

// Turns the candidate about the centroid so that it approaches exactly along `approach_W`.
Candidate snapped(const Candidate& candidate, const Eigen::Vector3d& approach_W,
                  const Eigen::Vector3d& centroid_W) {
  const Eigen::Quaterniond turn = geometry::rotation_between(candidate.approach_W, approach_W);
  Candidate result = candidate;
  result.approach_W = approach_W;
  result.X_WG.linear() = turn * candidate.X_WG.linear();
  result.X_WG.translation() = centroid_W + turn * (candidate.X_WG.translation() - centroid_W);
  return result;
}

// The motor of a parallel gripper moves half of the opening [m].
Eigen::VectorXd jaws_at(double opening) { return Eigen::VectorXd::Constant(1, opening / 2); }

// The largest of the distances by which a point is outside the box along an axis, as a miss.
Miss outside(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p) {
  const Eigen::Vector3d beyond = (p - box.max()).cwiseMax(box.min() - p).cwiseMax(0.0);
  return {Quantity::kLength, beyond.maxCoeff(), 0};
}

}  // namespace

/// Of an accepted candidate.
struct PadClosing::Kept {
  ClosedHand hand;
  double clearance = 0;  // m, of the hand over the table
};

PadClosing::PadClosing(const ClosingTask& task)
    : solid_(task.solid),
      query_W_(task.query_W),
      scene_(&task.query_W, task.table, task.obstacles, task.options.collision),
      table_(task.table),
      hand_(*task.hand.hand),
      gripper_(*hand_.gripper),
      largest_opening_(gripper_.max_opening),
      reachability_(task.reachability),
      options_(task.options),
      nominal_force_(gripper_.nominal_current * gripper_.force_per_current -
                     gripper_.friction_force),
      largest_force_(options_.pads.largest_force > 0 ? options_.pads.largest_force
                                                     : nominal_force_) {
  gripper_.max_opening += options_.pads.width_tolerance;
}

HandReach PadClosing::reach(const robot::Preshape& /*preshape*/) const {
  return hand_reach(*hand_.gripper);
}

std::span<const Reason> PadClosing::stages() const {
  static constexpr Reason kStages[] = {Reason::kDirection, Reason::kNothing,  Reason::kTooWide,
                                       Reason::kWorkspace, Reason::kArm,      Reason::kTable,
                                       Reason::kObject,    Reason::kObstacle, Reason::kBottomsOut,
                                       Reason::kTurns,     Reason::kFinger,   Reason::kTooHeavy,
                                       Reason::kOffCentre, Reason::kNotClosed};
  return kStages;
}

std::string PadClosing::too_wide(double narrowest) const {
  if (narrowest <= room() + options_.pads.width_tolerance) return "";
  const auto [width, opening] = text::told_apart(narrowest * 1e3, largest_opening_ * 1e3, 0);
  return fmt::format("narrowest width {} mm exceeds the gripper's {} mm{}", width, opening,
                     narrowest <= largest_opening_ ? " less the clearance" : "");
}

std::string PadClosing::explain(Reason reason) const {
  if (reason != Reason::kTooHeavy) return "";
  return fmt::format("too heavy for the grip force: {:.2f} kg need more than {:.0f} N", solid_.mass,
                     largest_force_);
}

double PadClosing::room() const { return largest_opening_ - 2 * options_.collision.object_margin; }

std::optional<Refusal> PadClosing::reach_pose(const Eigen::Vector3d& approach_W,
                                              const RigidTransform& X_GH,
                                              RigidTransform* X_WG) const {
  if (!options_.reaches) return std::nullopt;
  // The two fingers are the same, the arm's ways to hold them are not.
  RigidTransform turned = *X_WG;
  turned.linear().leftCols<2>() *= -1;
  for (const RigidTransform& X : {*X_WG, turned}) {
    RigidTransform pregrasp = X;
    pregrasp.translation() -= options_.pregrasp_distance * approach_W;
    if (!options_.reaches(X * X_GH) || !options_.reaches(pregrasp * X_GH)) continue;
    *X_WG = X;
    return std::nullopt;
  }
  return Refusal{Reason::kArm, {}};
}

// The table where it is in the way of the closed hand already, wherever along its closing direction
// the object puts it: known before the object is looked at.
std::optional<Refusal> PadClosing::meets_table_anyway(const RigidTransform& X_WG) const {
  const Eigen::Vector3d closing_W = X_WG.linear().col(1);
  const Eigen::AlignedBox3d& box = query_W_.box();
  const double farthest = std::abs(closing_W.dot(box.center() - X_WG.translation())) +
                          closing_W.cwiseAbs().dot(box.sizes()) / 2;
  const auto hand = swept_hand(gripper_, 0, options_.pregrasp_distance);
  const double most =
      scene_.table_clearance(hand, X_WG) + std::abs(table_.normal.dot(closing_W)) * farthest;
  if (most >= options_.collision.table_margin) return std::nullopt;
  return Refusal{Reason::kTable, Miss{Quantity::kLength, most, options_.collision.table_margin}};
}

// Shifts the hand along its closing direction to the middle of the section between the pads.
std::optional<Refusal> PadClosing::centre(RigidTransform* X_WG, double* section_width,
                                          SectionExtent* section) const {
  const double limit = room() + options_.pads.width_tolerance;
  double offset = 0;
  *section = {};
  *section_width = least_section_width(query_W_, *X_WG, gripper_);
  if (*section_width <= limit) {
    if (auto refusal = meets_table_anyway(*X_WG)) return refusal;
    *section = measure_section(query_W_, *X_WG, gripper_);
    if (!section->met) return Refusal{Reason::kNothing, {}};
    *section_width = section->upper - section->lower;
    offset = (section->upper + section->lower) / 2;
  }
  if (*section_width > limit) {
    // Perhaps a rim or handle fits between the fingers where they stand.
    const ClosedHand hand = close_hand(query_W_, *X_WG, gripper_.max_opening, least_force(),
                                       gripper_, options_.pads.closing);
    if (hand.outcome == ClosingOutcome::kTooWide) {
      return Refusal{Reason::kTooWide, Miss{Quantity::kLength, *section_width, room()}};
    }
    if (hand.outcome == ClosingOutcome::kMissed) return Refusal{Reason::kNothing, {}};
    offset = hand.offset;
    *section_width = hand.opening_at_touch;
    *section = {};  // it is of more than what is between the fingers
  }
  X_WG->translation() += offset * X_WG->linear().col(1);
  section->shift_hand(offset);
  return std::nullopt;
}

// The widest opening that meets nothing on the straight way from the pregrasp.
std::optional<Refusal> PadClosing::find_opening(const RigidTransform& X_WG, double section_width,
                                                double* opening) const {
  const double narrow =
      std::min(gripper_.max_opening, section_width + 2 * options_.pads.opening_clearance);
  std::optional<Refusal> refusal;
  for (double tried : {gripper_.max_opening, narrow}) {
    const auto hand = swept_hand(gripper_, tried, options_.pregrasp_distance);
    switch (scene_.check(hand, X_WG)) {
      case HandCollision::kNone:
        *opening = tried;
        return std::nullopt;
      case HandCollision::kTable:
        refusal =
            Refusal{Reason::kTable, Miss{Quantity::kLength, scene_.table_clearance(hand, X_WG),
                                         options_.collision.table_margin}};
        break;
      case HandCollision::kObject:
        refusal = Refusal{Reason::kObject, {}};
        break;
      case HandCollision::kObstacle:
        refusal = Refusal{Reason::kObstacle, {}};
        break;
    }
  }
  return refusal;
}

double PadClosing::least_force() const {
  const double weight = solid_.mass * (kGravity + options_.lift_acceleration);
  return std::max(options_.pads.least_force,
                  options_.safety_factor * weight / (2 * options_.pads.friction));
}

// How much of the pads' elliptic limit surface the weight and its torque about the closing
// direction use; a weight along the closing direction unloads one pad.
double PadClosing::load_ratio(const ClosedHand& hand, const RigidTransform& X_WG, double force,
                              double friction) const {
  const Eigen::Vector3d weight_G = X_WG.linear().transpose() * -table_.normal * solid_.mass *
                                   (kGravity + options_.lift_acceleration);
  const Eigen::Vector3d middle_G = (hand.left.center_G + hand.right.center_G) / 2;
  const Eigen::Vector3d arm_G = X_WG.inverse() * solid_.center_of_mass_W - middle_G;
  const double torque = arm_G.cross(weight_G).y();
  const double tangential = std::hypot(weight_G.x(), weight_G.z());
  const double radius = (hand.left.torsion_radius + hand.right.torsion_radius) / 2;
  const double grip = 2 * friction * force;
  const double slip = std::hypot(tangential / grip, torque / (grip * radius));
  return std::max(slip, std::abs(weight_G.y()) / force);
}

Wrenches PadClosing::wrenches_of(const ClosedHand& hand, const RigidTransform& X_WG,
                                 double friction) const {
  const auto contact = [friction](const ContactPatch& patch) {
    return Contact{patch.center_G, -patch.normal_G, friction, patch.torsion_radius};
  };
  return primitive_wrenches({contact(hand.left), contact(hand.right)},
                            X_WG.inverse() * solid_.center_of_mass_W, solid_.radius,
                            options_.cone_edges);
}

std::optional<Refusal> PadClosing::close(const RigidTransform& X_WG, double opening,
                                         const SectionExtent& section, ClosedHand* hand,
                                         double* force, double* quality) const {
  // More force, and again, while the weight would turn the object between the pads.
  constexpr int kPasses = 4;
  *force = least_force();
  for (int pass = 0;; ++pass) {
    if (*force > largest_force_) {
      return Refusal{Reason::kTooHeavy, Miss{Quantity::kForce, *force, largest_force_}};
    }
    *hand = close_hand(query_W_, X_WG, opening, *force, gripper_, options_.pads.closing, &section);
    switch (hand->outcome) {
      case ClosingOutcome::kClosed:
        break;
      case ClosingOutcome::kTooWide:
        return Refusal{Reason::kTooWide, {}};
      case ClosingOutcome::kMissed:
        return Refusal{Reason::kNothing, {}};
      case ClosingOutcome::kBottomsOut:
        return Refusal{Reason::kBottomsOut,
                       Miss{Quantity::kLength, std::max(hand->left.depth, hand->right.depth),
                            gripper_.pad.thickness}};
      case ClosingOutcome::kTurns:
        return Refusal{Reason::kTurns, hand->turn > options_.pads.closing.largest_turn
                                           ? std::optional(Miss{Quantity::kAngle, hand->turn,
                                                                options_.pads.closing.largest_turn})
                                           : std::nullopt};
      case ClosingOutcome::kTouchesFinger:
        return Refusal{Reason::kFinger, {}};
    }
    const double ratio =
        options_.safety_factor * load_ratio(*hand, X_WG, *force, options_.pads.friction);
    if (ratio <= 1 + 1e-9) break;
    if (pass + 1 == kPasses) return Refusal{Reason::kTooHeavy, {}};
    *force *= ratio;
  }
  if (std::abs(hand->offset) > options_.pads.largest_offset) {
    return Refusal{Reason::kOffCentre,
                   Miss{Quantity::kLength, std::abs(hand->offset), options_.pads.largest_offset}};
  }
  const Wrenches wrenches = wrenches_of(*hand, X_WG, options_.pads.friction);
  const WrenchHull hull = wrench_hull(wrenches, {.closure_only = true});
  if (!hull.closed) {
    return Refusal{Reason::kNotClosed, Miss{Quantity::kQuality, -hull.distance, 0}};
  }
  *quality = epsilon_bound(wrenches);
  return std::nullopt;
}

double PadClosing::score(const Grasp& grasp, const Kept& kept) const {
  const ClosedHand& hand = kept.hand;
  const Eigen::Vector3d center_G = grasp.X_WG.inverse() * solid_.center_of_mass_W;
  const Eigen::Vector3d middle_G = (hand.left.center_G + hand.right.center_G) / 2;
  const Eigen::Vector3d arm_G = center_G - middle_G;
  const double distance = std::hypot(arm_G.x(), arm_G.z());
  const PadOptions::Weights& weights = options_.pads.weights;
  const double sum =
      weights.quality * grasp.quality / (grasp.quality + 0.05) +
      weights.centredness * std::exp(-distance / 0.02) +
      weights.area * std::min(1.0, grasp.predicted.contact_area /
                                       (gripper_.pad.length() * gripper_.pad.width())) +
      weights.clearance * std::clamp(kept.clearance / 0.02, 0.0, 1.0);
  return sum / (weights.quality + weights.centredness + weights.area + weights.clearance);
}

std::optional<Refusal> PadClosing::evaluate(const Candidate& sampled,
                                            const robot::Preshape& preshape,
                                            ClosedGrasp* closed) const {
  Candidate candidate = sampled;
  if (!reachability_.reaches_direction(candidate.approach_W)) {
    const double angle = std::atan2(reachability_.approach_W->cross(candidate.approach_W).norm(),
                                    reachability_.approach_W->dot(candidate.approach_W));
    return Refusal{Reason::kDirection,
                   Miss{Quantity::kAngle, angle, reachability_.approach_tolerance}};
  }
  if (reachability_.approach_W) {
    candidate = snapped(candidate, *reachability_.approach_W, solid_.center_of_mass_W);
  }
  double section_width = 0;
  SectionExtent section;
  if (auto refusal = centre(&candidate.X_WG, &section_width, &section)) return refusal;
  const Eigen::Vector3d p_W = candidate.X_WG.translation();
  for (const Eigen::Vector3d& p :
       {p_W, Eigen::Vector3d(p_W - options_.pregrasp_distance * candidate.approach_W)}) {
    if (!reachability_.reaches_point(p)) {
      return Refusal{Reason::kWorkspace, outside(reachability_.workspace_W, p)};
    }
  }
  const Eigen::Vector3d closing_W = candidate.X_WG.linear().col(1);
  const RigidTransform X_GH = (hand_.X_HP * preshape.X_PG).inverse();
  if (auto refusal = reach_pose(candidate.approach_W, X_GH, &candidate.X_WG)) return refusal;
  // What was measured of the section is of the hand before it was turned.
  const bool turned = closing_W.dot(candidate.X_WG.linear().col(1)) < 0;
  double opening = 0;
  if (auto refusal = find_opening(candidate.X_WG, section_width, &opening)) return refusal;
  auto kept = std::make_shared<Kept>();
  ClosedHand& hand = kept->hand;
  double force = 0, quality = 0;
  if (turned) section = measure_section(query_W_, candidate.X_WG, gripper_);
  if (auto refusal = close(candidate.X_WG, opening, section, &hand, &force, &quality)) {
    return refusal;
  }

  Grasp& grasp = closed->grasp;
  grasp.X_WG = candidate.X_WG;
  grasp.X_WH = candidate.X_WG * X_GH;
  grasp.approach_W = candidate.approach_W;
  grasp.standoff = candidate.standoff;
  grasp.roll = candidate.roll;
  grasp.preshape = preshape.name;
  opening = std::min(opening, largest_opening_);
  grasp.open = jaws_at(opening);
  grasp.closed = jaws_at(hand.opening_at_touch);
  grasp.pregrasp_distance = options_.pregrasp_distance;
  grasp.force = force;
  grasp.effort = force / nominal_force_;
  grasp.quality = quality;
  grasp.predicted = {hand.opening_at_touch, (hand.left.area + hand.right.area) / 2,
                     (hand.left.force + hand.right.force) / 2, solid_.mass};
  kept->clearance =
      scene_.table_clearance(swept_hand(gripper_, opening, grasp.pregrasp_distance), grasp.X_WG);
  grasp.score = score(grasp, *kept);
  if (section_width > room()) {
    closed->too_wide = Miss{Quantity::kLength, section_width, room()};
    const auto [width, fits] = text::told_apart(section_width * 1e3, room() * 1e3, 1);
    grasp.remark = fmt::format(
        "{} mm wide by the prediction where {} mm would fit: tried in case it is narrower", width,
        fits);
  }
  closed->kept = std::move(kept);
  return std::nullopt;
}

std::optional<Refusal> PadClosing::refine(ClosedGrasp* closed) const {
  Grasp& grasp = closed->grasp;
  const Kept& kept = *static_cast<const Kept*>(closed->kept.get());
  grasp.quality = wrench_hull(wrenches_of(kept.hand, grasp.X_WG, options_.pads.friction)).epsilon;
  grasp.closed_all = hand_.all_positions(grasp.closed);
  grasp.score = score(grasp, kept);
  int pad = 0;
  for (const ContactPatch* patch : {&kept.hand.left, &kept.hand.right}) {
    for (std::size_t i = 0; i < patch->points_G.size(); ++i) {
      GraspContact contact;
      contact.contact_W = {grasp.X_WG * patch->points_G[i],
                           -(grasp.X_WG.linear() * patch->normals_G[i]), options_.pads.friction, 0};
      contact.finger = contact.pad = pad;
      contact.force = patch->forces[i];
      grasp.contacts.push_back(contact);
    }
    ++pad;
  }
  return std::nullopt;
}

bool PadClosing::holds(const Grasp& grasp, const RigidTransform& X_WG, double friction) const {
  // The table is where it is: what is disturbed is the object in the hand.
  const auto way = swept_hand(gripper_, pregrasp_opening(grasp), grasp.pregrasp_distance);
  if (scene_.touches_object(way, X_WG)) return false;
  const ClosedHand hand = close_hand(query_W_, X_WG, pregrasp_opening(grasp), grasp.force, gripper_,
                                     options_.pads.closing);
  return hand.outcome == ClosingOutcome::kClosed &&
         load_ratio(hand, X_WG, grasp.force, friction) <= 1 &&
         wrench_hull(wrenches_of(hand, X_WG, friction), {.closure_only = true}).closed;
}

Eigen::VectorXd PadClosing::stops(const Grasp& grasp) const {
  const ClosedHand hand = close_hand(query_W_, grasp.X_WG, pregrasp_opening(grasp), grasp.force,
                                     gripper_, options_.pads.closing);
  if (hand.outcome == ClosingOutcome::kTooWide || hand.outcome == ClosingOutcome::kMissed)
    return {};
  return jaws_at(hand.opening_at_touch);
}

}  // namespace prehend::grasp
