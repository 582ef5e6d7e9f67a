#include "eval/grasp/trial_setup.h"

#include <iterator>
#include <utility>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/plan_settings.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/planning/chain_motion.h"
#include "prehend/surface/convex_pieces.h"

namespace prehend::eval {
namespace {

std::vector<geometry::TriangleMesh> pieces_of(const geometry::TriangleMesh& mesh_W) {
  const bool solid =
      geometry::find_defects(mesh_W).watertight() && geometry::mass_properties(mesh_W).volume > 0;
  return solid ? surface::convex_pieces(mesh_W).pieces
               : std::vector{geometry::convex_hull(mesh_W.vertices)};
}

}  // namespace

PlanChange change_by(const fidelity::Front& chains, const fidelity::Setting& setting) {
  return [chains, setting](planning::PlatformPlanOptions* options) {
    fidelity::apply_plan_setting(stage_setting(chains, setting, fidelity::Stage::kPlan),
                                 &options->grasps);
    planning::apply_motion_setting(chains, setting, options);
  };
}

Belief belief_of(const geometry::TriangleMesh& mesh_W,
                 const std::vector<geometry::TriangleMesh>& others_W) {
  Belief belief;
  belief.object.mesh_W = mesh_W;
  belief.object.convex_pieces_W = pieces_of(mesh_W);
  belief.others.meshes_W = others_W;
  for (const geometry::TriangleMesh& other_W : others_W) {
    std::vector<geometry::TriangleMesh> pieces = pieces_of(other_W);
    std::move(pieces.begin(), pieces.end(), std::back_inserter(belief.others.pieces_W));
  }
  return belief;
}

}  // namespace prehend::eval
