#include "prehend/planning/known_models.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/known/grasp_database.h"
#include "tests/grasp/seen_object.h"
#include "tests/launch/child_program.h"

namespace prehend::planning {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Models : public ::testing::Test {
 protected:
  void write(const std::string& name, const geometry::TriangleMesh& mesh) const {
    geometry::write_mesh_file(folder_.path(name), mesh);
  }
  std::string error_of_reading() const {
    try {
      KnownModels models(folder_.path());
    } catch (const geometry::InputError& error) {
      return error.what();
    }
    return "";
  }
  testing::ScratchDirectory folder_;
};

TEST_F(Models, GiveTheWholeSolidWhereTheObjectStands) {
  const auto mesh = grasp::angle_iron();
  write("angle_iron.ply", mesh);
  write("can.ply", grasp::can());
  folder_.write("readme.txt", "no mesh");
  const KnownModels models(folder_.path());
  EXPECT_EQ(models.size(), 2u);
  const auto X_WO = grasp::standing(mesh, 0.7, {0.1, -0.05});
  const auto seen = grasp::view_of(mesh, X_WO, {-0.35, -0.1, 0.4});
  const perception::SegmentedScene scene{seen.camera, seen.X_WC, seen.depth, *seen.table_W, {}};
  const auto found = models.recognise(scene, {0, seen.cloud_W, {}, false, 0});
  ASSERT_TRUE(found.best.accepted) << found.best.reason;
  EXPECT_EQ(found.best.name, "angle_iron");
  // Files keep vertices in single precision.
  EXPECT_EQ(found.best.hash,
            grasp::content_hash(geometry::read_mesh_file(folder_.path("angle_iron.ply"))));
  const geometry::MeshQuery truth_W(geometry::transformed(mesh, X_WO));
  for (const auto& p_W : found.model_W.mesh_W.vertices) {
    EXPECT_LT(truth_W.nearest(p_W)->distance, 0.006);
  }
  EXPECT_FALSE(found.model_W.convex_pieces_W.empty());
  EXPECT_LT((found.model_W.mass_properties.center_of_mass -
             X_WO * geometry::mass_properties(mesh).center_of_mass)
                .norm(),
            0.006);

  const auto other = grasp::view_of(grasp::bottle(), grasp::standing(grasp::bottle(), 0, {0, 0}),
                                    {-0.35, -0.1, 0.4});
  const auto missed = models.recognise({other.camera, other.X_WC, other.depth, *other.table_W, {}},
                                       {0, other.cloud_W, {}, false, 0});
  EXPECT_FALSE(missed.best.accepted);
  EXPECT_FALSE(missed.best.reason.empty());
}

// Who turns objects before a camera fills it.
TEST_F(Models, AFolderMayBeEmptyYet) {
  folder_.write(".object-1.part.ply", "not yet whole");
  const KnownModels models(folder_.path());
  EXPECT_EQ(models.size(), 0u);
  EXPECT_TRUE(known_model_files(folder_.path()).empty());
  const auto seen = grasp::view_of(grasp::bottle(), grasp::standing(grasp::bottle(), 0, {0, 0}),
                                   {-0.35, -0.1, 0.4});
  perception::SegmentedScene scene;
  scene.camera = seen.camera;
  scene.X_WC = seen.X_WC;
  scene.depth = seen.depth;
  scene.table_W = *seen.table_W;
  perception::ObjectHypothesis object;
  object.cloud_W = seen.cloud_W;
  const auto found = models.recognise(scene, object);
  EXPECT_FALSE(found.best.accepted);
  EXPECT_FALSE(found.best.reason.empty());
}

TEST_F(Models, FoldersThatAreNoneAreNamed) {
  folder_.write("broken.ply", "ply\nnonsense\n");
  EXPECT_THAT(error_of_reading(), HasSubstr("broken.ply"));
  EXPECT_THROW(KnownModels(folder_.path("missing")), geometry::InputError);
}

TEST_F(Models, ASheetWithoutVolumeIsNamed) {
  geometry::TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0.1, 0.1, 0}};
  sheet.triangles = {{0, 1, 2}, {2, 1, 3}};
  write("sheet.ply", sheet);
  EXPECT_THAT(error_of_reading(), AllOf(HasSubstr("sheet.ply"), HasSubstr("coplanar")));
}

}  // namespace
}  // namespace prehend::planning
