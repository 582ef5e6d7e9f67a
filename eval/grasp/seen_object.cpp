#include "eval/grasp/seen_object.h"

#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "eval/case_runner.h"
#include "prehend/geometry/errors.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/model.h"

namespace prehend::eval {
namespace {

using Shapes = std::vector<shape::SceneShape>;

// As the node that plans takes them: what has no shape is no obstacle.
planning::Neighbours neighbours_of(const SeenObject& seen, const Shapes& shapes,
                                   const surface::ModelOptions& options) {
  planning::Neighbours others;
  for (std::size_t i = 0; i < seen.scene.objects.size(); ++i) {
    if (i == seen.index) continue;
    try {
      const geometry::Plane& support = support_of(seen.scene, seen.scene.objects[i]);
      surface::ObjectModel model = surface::make_object_model(shapes[i].get(), support, options);
      others.meshes_W.push_back(std::move(model.mesh_W));
      std::move(model.convex_pieces_W.begin(), model.convex_pieces_W.end(),
                std::back_inserter(others.pieces_W));
    } catch (const geometry::InputError&) {
      continue;
    }
  }
  return others;
}

SeenObject object_in(perception::SegmentedScene scene, const simulation::StereoImages& images) {
  SeenObject seen{std::move(scene), 0};
  const std::optional<std::size_t> object = object_of(seen.scene, images.labels);
  if (!object) {
    throw geometry::InputError("The object was not found on the table",
                               "It is out of view or too small");
  }
  seen.index = *object;
  return seen;
}

}  // namespace

SeenObject see_object(const Case& one, const geometry::RigidTransform& X_WB, int look,
                      const fidelity::SeeingOptions& options) {
  RenderedScene rendered = scene_of(one);
  rendered.bodies.front().X_WB = X_WB;
  const geometry::RigidTransform X_WC = rendered.scene.camera.X_WC();
  return see_object(std::move(rendered), X_WC, look, options);
}

SeenObject see_object(RenderedScene rendered, const geometry::RigidTransform& X_WC, int look,
                      const fidelity::SeeingOptions& options) {
  simulation::RenderOptions render;
  render.threads = 1;
  const auto images = simulation::render_stereo(rendered.scene, rendered.bodies,
                                                static_cast<std::uint32_t>(look), render);
  rendered.scene.camera.carried = X_WC;
  return see_object(rendered, images, options);
}

SeenObject see_object(const RenderedScene& rendered, const simulation::StereoImages& images,
                      const fidelity::SeeingOptions& options) {
  return object_in(seen_scene(rendered, images, options), images);
}

SeenObject see_object(const RenderedScene& rendered, const simulation::StereoImages& images,
                      const geometry::PointCloud& cloud_C, const fidelity::SeeingOptions& options) {
  return object_in(seen_scene(rendered, cloud_C, options), images);
}

Belief believed_object(const Case& one, const SeenObject& seen, PlannedOn planned_on,
                       fidelity::ShapeOptions options) {
  const perception::SegmentedScene& scene = seen.scene;
  const perception::ObjectHypothesis& object = scene.objects[seen.index];
  options.completion.other_methods = planned_on == PlannedOn::kPredicted;
  const bool has_others = !one.data_set->viewing.others_B.empty();
  Shapes shapes;
  if (has_others || planned_on != PlannedOn::kDelaunay) {
    shapes = shape::complete_scene(scene, options.completion, {}, seen.index);
  }
  Belief belief;
  if (planned_on == PlannedOn::kDelaunay) {
    belief = belief_of(surface::delaunay_surface(object.cloud_W, scene.camera, scene.X_WC), {});
  } else {
    belief.support_W = support_of(scene, object);
    belief.shape = shapes[seen.index].get();
    belief.object = surface::make_object_model(*belief.shape, belief.support_W, options.model);
  }
  if (has_others) belief.others = neighbours_of(seen, shapes, options.model);
  return belief;
}

}  // namespace prehend::eval
