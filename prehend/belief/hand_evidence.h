#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/evidence.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/swept_space.h"
#include "prehend/grasp/closing/hand_balls.h"
#include "prehend/robot/hand_model.h"
#include "prehend/touch/hand_touch.h"

namespace prehend::belief {

struct HandEvidenceOptions {
  int most_contacts = 12;          // of a pad, > 0
  double contact_spacing = 0.004;  // m, >= 0, between contacts of a pad
  double placement = 0.0005;       // m, > 0, standard: where a pad's face is along its normal
                                   // (hand's pose, joints), common to all of its contacts
  double foam = 0.1;               // >= 0, standard, of the foam's depth: creep, gains of texels
  double slope = 0.25;    // >= 0, of the surface to a texel's face where the pad cannot tell it
  double margin = 0.001;  // m, >= 0, that swept space keeps from the hand's surface

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Where a hand is at one moment.
struct HandSample {
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();  // of its root
  /// rad or m, of all joints of the model; HandModel::all_positions() of the motors' unless a
  /// coupling broke away.
  Eigen::VectorXd joints;
};

/// What a hand with pads finds out about an object: where it touches it, and where it went through
/// without touching it. Of any hand; what differs is in its model.
///
/// A touched texel says that the surface is as far behind its face as its force presses the foam in
/// (touch::rest_depth()). A full one says that it is at least so far, and no farther than the foam
/// is thick. A pad's normal is that of what it touches to some 15 degrees; where enough texels are
/// touched, the surface fitted to them (touch::fit_contact()) tells better. A texel that says
/// nothing readable is left out.
///
/// A finger that was stopped without a pad that touches has met something somewhere on its links:
/// nothing says where, and no contact is made of it.
class HandEvidence {
 public:
  /// @throws std::invalid_argument for options out of range, geometry::InputError for a link whose
  /// shape has no volume.
  explicit HandEvidence(robot::HandModel hand, const HandEvidenceOptions& options = {});

  const robot::HandModel& hand() const { return hand_; }

  /// Of the pads that touch, thinned: each pad's texel with the greatest force, then always the one
  /// farthest from those taken. Whoever takes contacts in takes their errors to be independent: the
  /// deviation of each of n contacts has sqrt(n) times the placement's, so that the mean of all has
  /// what is common to them.
  /// @throws std::invalid_argument in words: a pose or positions that are not finite, another
  /// number of positions than joints, a pad that the hand has not, another number of counts than
  /// its texels.
  std::vector<Contact> contacts(const HandSample& at,
                                const std::vector<touch::PadFrame>& frames) const;

  /// By how much the foam of each pad that touches gives way at most [m], by the pad's name.
  /// @throws std::invalid_argument as contacts() for the frames.
  using PadDepths = std::map<std::string, double>;
  PadDepths depths(const std::vector<touch::PadFrame>& frames) const;

  /// Adds to `space` what the hand's links sweep from the first to the last sample, in straight
  /// motion of root and joints from each to the next: balls beneath their surface
  /// (grasp::HandBalls), smaller by the margin, in steps no longer than a ball's radius. What the
  /// hand then touches is behind the face of a pad by as far as the foam gives way: the balls of a
  /// pad are set back by that. Takes 0.1 to 0.4 s of a hand of three fingers in half a million
  /// voxels.
  /// @param depths at the last sample; a pad that is not named touches nothing.
  /// @throws as contacts(); std::invalid_argument without a sample, for a depth that is negative
  /// or not finite.
  void sweep(const std::vector<HandSample>& way, const PadDepths& depths,
             geometry::SweptSpace* space) const;

 private:
  void check(const HandSample& sample) const;
  const robot::HandPad& pad_named(const std::string& name) const;
  const robot::HandPad& pad_of(const touch::PadFrame& frame) const;
  std::vector<std::vector<Eigen::Vector3d>> centers_behind_foam(const PadDepths& depths) const;
  int steps_between(const HandSample& from, const HandSample& to, double least_step) const;
  std::vector<geometry::RigidTransform> link_poses(const HandSample& sample) const;  // X_WL

  robot::HandModel hand_;
  HandEvidenceOptions options_;
  grasp::HandBalls balls_;
};

}  // namespace prehend::belief
