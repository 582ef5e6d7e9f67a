#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "eval/belief/touch_trial.h"
#include "eval/data_sets.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// The true object of a case in the world, and how far a mesh is from it.
class BeliefTruth {
 public:
  /// @param viewpoint_W m, that it was seen from.
  BeliefTruth(const Case& one, const Eigen::Vector3d& viewpoint_W);

  const geometry::MeshQuery& query() const { return query_; }
  bool is_all_seen() const { return unseen_.empty(); }

  /// Fills the step's errors.
  void measure(const geometry::TriangleMesh& mesh_W, std::uint64_t seed, BeliefStep* step) const;

 private:
  geometry::TriangleMesh mesh_;
  geometry::MeshQuery query_;
  std::vector<Eigen::Vector3d> all_, unseen_;
};

}  // namespace prehend::eval
