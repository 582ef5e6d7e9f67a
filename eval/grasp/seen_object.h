#pragma once

#include "eval/data_sets.h"
#include "eval/grasp/grasp_case.h"
#include "eval/grasp/trial_setup.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/simulation/stereo_renderer.h"

namespace prehend::eval {

/// A rendered look at a case's object, segmented.
struct SeenObject {
  perception::SegmentedScene scene;
  std::size_t index = 0;  // of the object in the scene
};

/// Renders the object at X_WB (the `look`th stereo pair of the case, from 0) and segments it.
/// @throws geometry::InputError when it is not found on the table.
SeenObject see_object(const Case& one, const geometry::RigidTransform& X_WB, int look,
                      const fidelity::SeeingOptions& options = {});

/// The same of what is rendered, by a camera that is said to be at `X_WC`.
SeenObject see_object(RenderedScene rendered, const geometry::RigidTransform& X_WC, int look,
                      const fidelity::SeeingOptions& options = {});

/// The same of images of it, as `options` say.
SeenObject see_object(const RenderedScene& rendered, const simulation::StereoImages& images,
                      const fidelity::SeeingOptions& options);

/// The same of the cloud that the camera sees, see seen_cloud().
SeenObject see_object(const RenderedScene& rendered, const simulation::StereoImages& images,
                      const geometry::PointCloud& cloud_C, const fidelity::SeeingOptions& options);

/// What that gives to plan on, a prediction by `options`. Of a case with other bodies, whatever
/// else was seen is predicted, too, and is an obstacle.
/// @pre not kTruth, which nobody sees
/// @throws geometry::InputError when no shape of the object is predicted.
Belief believed_object(const Case& one, const SeenObject& seen, PlannedOn planned_on,
                       fidelity::ShapeOptions options = {});

}  // namespace prehend::eval
