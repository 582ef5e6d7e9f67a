#pragma once

#include <cstdint>
#include <memory>
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
  const geometry::MeshQuery& query_W;  // the object's surface, triangles outward
  Eigen::Vector3d centroid_W = Eigen::Vector3d::Zero();
  geometry::Plane table;
  HandReach hand;
  Reachability reachability;
  /// approach_views() of it with the options of "circles"; null: made anew.
  const std::vector<ApproachView>* views = nullptr;
};

/// One way to make candidates. Adding one: a file in generators/ and a line in generator.cpp.
class CandidateGenerator {
 public:
  virtual ~CandidateGenerator() = default;
  /// Hand poses in a fixed order; the same target gives the same ones, bit by bit.
  virtual std::vector<Candidate> generate(const GraspTarget& target) const = 0;
};

/// How many candidates the generators make. CandidateOptions has what "circles" needs.
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

/// Names for make_generator(), each with its source:
/// - "circles": sample_candidates() in candidates.h: two circles of approach directions round the
///   centroid (Bohg et al., "Mind the gap", ICRA 2011, section IV, the UJI platform).
/// - "segments": circles of approach directions round the line between two points of the surface
///   that face each other across the middle of the object (the same, the KTH platform), at several
///   stations of its longest axis.
/// - "boxes": rays from the sides of the object's box inwards; the hand approaches against the
///   surface normal where a ray hits (R. Diankov, "Automated construction of robotic manipulation
///   programs", PhD thesis, CMU 2010, section 4.1: OpenRAVE's approach rays).
/// - "antipodal": surface points by area, each with the point opposite along its normal; kept where
///   the line between them is in both friction cones (I-M. Chen and J. W. Burdick, "Finding
///   antipodal point grasps on irregularly shaped objects", IEEE T-RA 9(4), 1993).
/// - "medial_axis": balls that touch the surface at opposite sides from inside; the hand closes
///   along the line between the points of touch (Przybylski, Asfour and Dillmann, "Planning grasps
///   for robotic hands using a novel object representation based on the medial axis transform",
///   IROS 2011; balls by shrinking: Ma, Bae and Choi, "3D medial axis point approximation using
///   nearest neighbors and the normal field", The Visual Computer 28(1), 2012).
std::vector<std::string> generator_names();

/// The generator of candidates that were given to a planner instead, as told in its results.
inline constexpr const char* kGiven = "given";

/// @throws std::invalid_argument for an unknown name (with the nearest) or a bad option.
std::unique_ptr<CandidateGenerator> make_generator(const std::string& name,
                                                   const GeneratorOptions& options = {});

}  // namespace prehend::grasp
