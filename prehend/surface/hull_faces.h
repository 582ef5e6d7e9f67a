#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// The half-spaces whose intersection a convex mesh is, in the mesh's unit.
class HullFaces {
 public:
  /// None for the faces of triangles without area. @pre `hull` is convex.
  explicit HullFaces(const geometry::TriangleMesh& hull);

  bool empty() const { return faces_.empty(); }
  /// Greatest signed distance of `p` to the faces' planes: negative inside.
  float distance(const Eigen::Vector3f& p) const;
  /// The least width of `points` perpendicular to a face.
  float thickness(const std::vector<Eigen::Vector3f>& points) const;
  /// The x between which the rows through (0, y, z), for y = `first`, `first` + 1, ..., are inside
  /// when the faces are moved outward by `shift`: low[i] is greater than high[i] when that one is
  /// not. @pre as many of both as rows.
  void rows(float first, float z, float shift, std::vector<float>& low,
            std::vector<float>& high) const;

 private:
  struct Face {  // outside where normal · p > offset
    Eigen::Vector3f normal;
    float offset;
  };
  std::vector<Face> faces_;
};

}  // namespace prehend::surface
