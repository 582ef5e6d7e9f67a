#include "eval/grasp/seen_object.h"

#include <cstdint>
#include <optional>

#include "eval/case_runner.h"
#include "prehend/geometry/errors.h"
#include "prehend/shape/object_view.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/model.h"

namespace prehend::eval {

SeenObject see_object(const Case& one, const geometry::RigidTransform& X_WB, int look) {
  RenderedScene rendered = scene_of(one);
  rendered.bodies.front().X_WB = X_WB;
  simulation::RenderOptions render;
  render.threads = 1;
  const auto images = simulation::render_stereo(rendered.scene, rendered.bodies,
                                                static_cast<std::uint32_t>(look), render);
  SeenObject seen{seen_scene(rendered, images), 0};
  const std::optional<std::size_t> object = object_of(seen.scene, images.labels);
  if (!object) {
    throw geometry::InputError("The object was not found on the table",
                               "It is out of view or too small");
  }
  seen.index = *object;
  return seen;
}

surface::ObjectModel believed_object(const SeenObject& seen, PlannedOn planned_on,
                                     int alternatives) {
  const perception::SegmentedScene& scene = seen.scene;
  const perception::ObjectHypothesis& object = scene.objects[seen.index];
  if (planned_on == PlannedOn::kDelaunay) {
    surface::ObjectModel model;
    model.mesh_W = surface::delaunay_surface(object.cloud_W, scene.camera, scene.X_WC);
    return model;
  }
  shape::CompletionOptions options;
  options.alternatives = alternatives;
  const shape::CompletedShape shape =
      shape::complete_by_symmetry(shape::view_of(scene, object), options);
  return surface::make_object_model(shape, support_of(scene, object));
}

}  // namespace prehend::eval
