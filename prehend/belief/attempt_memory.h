#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/belief/attempt.h"
#include "prehend/belief/load_belief.h"
#include "prehend/belief/object_belief.h"
#include "prehend/belief/probe.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/model.h"

namespace prehend::belief {

/// What of the evidence is used: each with those before it.
enum class EvidenceUse {
  kNone,
  kContacts,    // where something was touched
  kEmptySpace,  // what the hand went through
  kLooks,       // what was seen in looks before
};

struct AttemptMemoryOptions {
  EvidenceUse use = EvidenceUse::kLooks;
  BeliefOptions belief;
  LoadBeliefOptions load;
  surface::ModelOptions model{0};  // all detail: of several looks more is known than of one
  double tolerance = 0.004;        // m, > 0, of a seen point on the surface that it was on before
  double least_explained = 0.8;    // share of the seen points, in (0, 1], for it to be that object
  double largest_motion = 0.12;    // m, > 0, of an object between two looks
  double placement = 0.001;        // m, >= 0, standard: of the object's estimated motion, ...
  double turn = 0.02;              // rad, >= 0, ... about the table's normal
  double seen_deviation = 0.0015;  // m, > 0, standard, of a point that was seen before
  int most_looks_points = 48;      // >= 0, of the looks before, that add to the present one
  int probes = 0;                  // >= 0, of Recollection::probes at most
  ProbeOptions probe;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// A predicted object, corrected by what attempts at it found out.
struct Recollection {
  surface::ObjectModel model;  // alternatives: the less likely shapes
  std::vector<BelievedShape> before, after;
  geometry::RigidTransform X_moved = geometry::RigidTransform::Identity();  // since the last look
  double explained = 0;           // share of what is seen now that is on what was believed then
  std::vector<Contact> contacts;  // as the object lies now
  int looks = 0;                  // before this one
  double change = 0;              // m, mean distance of its surface from what was predicted
  std::vector<Probe> probes;      // by which most would be learnt, best first
  grasp::LoadBounds load;         // of what it weighs, and how it rubs
  std::string load_problem;       // why what was known of its load is forgotten; empty: it is not
};

/// What attempts found out about the objects of a scene, for when they are seen again.
///
/// An object is found again by its surface: what is seen now is laid onto what was believed then
/// (grasp::refined_pose()), and what was felt, swept and seen of it goes along. It is forgotten
/// where nothing seen fits any more, as an object that fell over, and where it contradicts the new
/// look (ObjectBelief::contradicted()): the belief starts again from the look then. One that
/// nothing has touched (add_look()) is found where it stood, as another side of it may not be what
/// was believed: as long as neither look sees through what the other one saw.
///
/// Not thread-safe.
class AttemptMemory {
 public:
  /// @param hand that the attempts are made with. @throws as HandEvidence and
  /// AttemptMemoryOptions::validate().
  explicit AttemptMemory(robot::HandModel hand, const AttemptMemoryOptions& options = {});

  /// The attempt was at the object that had been completed so and was believed to have this
  /// surface. Contacts with the table, and those nearer to one of its neighbours, are none of its.
  /// Nothing happens for an attempt that found nothing out.
  void add(Attempt attempt, const shape::CompletedShape& shape, const geometry::Plane& table_W,
           const geometry::TriangleMesh& believed_W,
           const std::vector<geometry::TriangleMesh>& neighbours_W = {});

  /// Nothing has touched the object since it was completed so; it is looked at from elsewhere next.
  void add_look(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                const geometry::TriangleMesh& believed_W);

  /// The same of what a hold of it told of its load.
  /// @throws std::invalid_argument for evidence that is not finite or negative.
  void add_load(const LoadEvidence& load, const shape::CompletedShape& shape,
                const geometry::Plane& table_W, const geometry::TriangleMesh& believed_W);

  /// What is believed of an object that is seen now, of a shape with its other methods. Unset:
  /// nothing is known of it but this look; problem() says why, where something was.
  /// @throws geometry::InputError as ObjectBelief.
  std::optional<Recollection> recall(const shape::CompletedShape& shape,
                                     const geometry::Plane& table_W);
  const std::string& problem() const { return problem_; }  // of the last recall(), in words

  bool empty() const { return objects_.empty(); }
  void clear() { objects_.clear(); }

 private:
  /// One look at an object, and the attempts after it, as the object lies now.
  struct Look {
    geometry::PointCloud seen_W;  // with normals
    shape::SeenSpace seen_space;
    std::vector<Attempt> attempts;
    bool stood = true;  // nothing has touched the object since it
  };
  struct Object {
    geometry::TriangleMesh believed_W;
    std::vector<Look> looks;
    std::vector<LoadEvidence> loads;
    bool stands = false;  // nothing has touched it since its last look
  };
  struct Found {
    std::size_t object = 0;
    geometry::RigidTransform X_moved;
    double explained = 0;
  };
  std::optional<Found> find(const Look& now) const;
  /// The worse of the shares of what one look saw that the other one does not see through; 0 for
  /// what is beside the object.
  double agreement(const Object& object, const Look& now) const;
  /// The object that was believed to have this surface, with this look as its last.
  Object& seen_as(Look look, const geometry::TriangleMesh& believed_W);
  geometry::PointCloud seen_of(const shape::CompletedShape& shape,
                               const geometry::Plane& table_W) const;
  void tell(const Object& object, const geometry::PointCloud& seen_W, ObjectBelief* belief) const;

  HandEvidence evidence_;
  AttemptMemoryOptions options_;
  std::vector<Object> objects_;
  std::string problem_;
};

}  // namespace prehend::belief
