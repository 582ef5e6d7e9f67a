#include "prehend/surface/vertex_origin.h"

#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/shape/symmetry.h"
#include "prehend/surface/model.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::surface {
namespace {

TEST(VertexOrigin, NearestPointDecides) {
  shape::CompletedShape shape;
  shape.cloud_W.points = {{0, 0, 0}, {0.1f, 0, 0}};
  shape.origin = {shape::PointOrigin::kSeen, shape::PointOrigin::kMirrored};
  shape.point_confidence = {0.95f, 0.7f};
  shape.confidence = 0.8;
  geometry::TriangleMesh mesh;
  mesh.vertices = {{0.001, 0, 0}, {0.0985, 0, 0}, {0.05, 0, 0}, {1e9, 0, 0}, {-1e9, 0, 0}};
  const std::vector<SurfaceOrigin> expected{SurfaceOrigin::kSeen, SurfaceOrigin::kPredicted,
                                            SurfaceOrigin::kAssumed, SurfaceOrigin::kAssumed,
                                            SurfaceOrigin::kAssumed};
  const VertexBasis basis = vertex_basis(mesh, shape, 0.005);
  EXPECT_EQ(basis.origin, expected);
  EXPECT_EQ(basis.confidence, (std::vector<float>{0.95f, 0.7f, 0.4f, 0.4f, 0.4f}));
  EXPECT_THROW(vertex_basis(mesh, shape, 0), std::invalid_argument);
  EXPECT_THROW(vertex_basis(mesh, shape, 1e-9), std::invalid_argument);
  shape.point_confidence.clear();
  EXPECT_THROW(vertex_basis(mesh, shape, 0.005), std::invalid_argument);
}

TEST(VertexOrigin, OfAPredictedBoxTellsFrontFromBackFromBottom) {
  const auto truth = shape::standing(geometry::make_box({0.06, 0.09, 0.12}), 0.5);
  const shape::SyntheticView view = shape::synthetic_view(truth, {});
  const ObjectModel model =
      make_object_model(shape::complete_by_symmetry(view.view()), view.table_W);
  ASSERT_EQ(model.vertex_origin.size(), model.mesh_W.vertices.size());
  ASSERT_EQ(model.vertex_confidence.size(), model.mesh_W.vertices.size());
  // By rays from the camera: what it sees of the mesh is seen, the rest is not, but for the rims.
  const geometry::MeshQuery query(model.mesh_W);
  const Eigen::Vector3d eye = view.X_WC.translation();
  int right = 0;
  int assumed_above = 0;
  for (std::size_t i = 0; i < model.mesh_W.vertices.size(); ++i) {
    const Eigen::Vector3d& p = model.mesh_W.vertices[i];
    const auto hit = query.cast_ray(eye, (p - eye).normalized());
    const bool visible = hit && hit->distance > (p - eye).norm() - 0.002;
    right += visible == (model.vertex_origin[i] == SurfaceOrigin::kSeen);
    assumed_above += model.vertex_origin[i] == SurfaceOrigin::kAssumed && p.z() > 0.01;
  }
  EXPECT_GT(right, 0.9 * model.mesh_W.vertices.size());
  EXPECT_LT(assumed_above, 0.02 * model.mesh_W.vertices.size());
  // The bottom and two of the sides were not seen.
  const double unseen =
      (0.06 * 0.09 + 0.06 * 0.12 + 0.09 * 0.12) / (2 * (0.06 * 0.09 + 0.06 * 0.12 + 0.09 * 0.12));
  EXPECT_NEAR(model.guessed_area, unseen, 0.06);
}

TEST(VertexOrigin, ABowlSeenFromAboveIsAClosedMeshThatStaysHollow) {
  // A bowl: a beaker 80 mm wide and 40 mm high, looked into from steeply above.
  const auto bowl = geometry::make_revolution(
      {{0, 0}, {0.03, 0}, {0.042, 0.04}, {0.038, 0.04}, {0.027, 0.005}, {0, 0.005}}, 96);
  const shape::SyntheticView view =
      shape::synthetic_view(shape::standing(bowl, 0), {.elevation = 1.2});
  const ObjectModel model =
      make_object_model(shape::complete_by_symmetry(view.view()), view.table_W);
  EXPECT_TRUE(model.defects.watertight()) << model.defects.to_string();
  const geometry::MeshQuery query(model.mesh_W);
  EXPECT_FALSE(query.contains({0, 0, 0.012}));
  EXPECT_FALSE(query.contains({0, 0, 0.03}));
  EXPECT_TRUE(query.contains({0, 0, 0.0025}));
  EXPECT_LT(model.seen_deviation, 0.001);
  EXPECT_GT(model.guessed_area, 0.2);  // its outside
}

}  // namespace
}  // namespace prehend::surface
