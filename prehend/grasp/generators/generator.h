#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/generators/candidates.h"

namespace prehend::robot {
struct GripperModel;
}

namespace prehend::grasp {

/// What a generator must know of a hand. Its frame G: z the approach direction, y the closing
/// direction, as in robot/gripper_model.h; the fingertips are at z = tip_z.
struct HandReach {
  double tip_z = 0;        // m, from G's origin to the fingertips
  double pad_length = 0;   // m, along the fingers: how deep the fingers may engage locally
  double max_opening = 0;  // m
};
HandReach hand_reach(const robot::GripperModel& gripper);

/// An object to make candidates for.
struct GraspTarget {
  const geometry::SurfaceQuery& query_W;  // the object's surface, triangles outward
  Eigen::Vector3d centroid_W = Eigen::Vector3d::Zero();
  geometry::Plane table;
  HandReach hand;
  Reachability reachability;
  /// approach_views() of it with the options of "circles"; null: made anew.
  const std::vector<ApproachView>* views = nullptr;
};

/// How many candidates generators make. CandidateOptions has what "circles" needs.
struct GeneratorOptions {
  CandidateOptions circles;
  int samples = 120;   // > 0, of the surface: antipodal points, medial balls, rays of each box side
  int approaches = 8;  // > 0, directions round the line between two contacts
  int rolls = 4;       // > 0, over half a turn, where the contacts do not give it
  int standoffs = 3;   // > 0, from a fingertip's hold to the pad's whole length
  double least_engagement = 0.012;  // m, > 0, of the fingertips beyond the contact
  double table_clearance = 0.005;   // m, >= 0, that the fingertips keep to the table
  double friction = 0.6;            // > 0: how far contacts of "antipodal" may be from opposite
  std::uint64_t seed = 1;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// One way to make candidates. Recipe for another one: README.md of prehend/grasp. Pure virtual, so
/// that generators in shared libraries need nothing of prehend linked to them.
class CandidateGenerator {
 public:
  virtual ~CandidateGenerator() = default;
  virtual std::string name() const = 0;  // by which it is chosen: "circles"
  /// Hand poses in a fixed order; the same target and options give the same ones, bit by bit.
  virtual std::vector<Candidate> generate(const GraspTarget& target,
                                          const GeneratorOptions& options) const = 0;
};

/// The generator of candidates that were given to a planner instead, as told in its results.
inline constexpr const char* kGiven = "given";

/// Of CandidateGenerator and what it is given: a plug-in that was built for another one is not
/// loaded.
constexpr int kGeneratorInterface = 1;

}  // namespace prehend::grasp
