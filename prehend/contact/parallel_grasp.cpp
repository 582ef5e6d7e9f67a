#include "prehend/contact/parallel_grasp.h"

#include <stdexcept>

namespace prehend::contact {

GraspModel parallel_grasp(const ParallelGraspOptions& options) {
  if (!(options.opening > 0)) {
    throw std::invalid_argument("ParallelGraspOptions::opening must be positive");
  }
  GraspModel model;
  model.shape = Shape::box(options.box_size);
  model.mass = options.mass;
  model.inertia = box_inertia(options.mass, options.box_size);
  if (options.on_ground) {
    const Eigen::Vector3d h = 0.5 * options.box_size;
    model.X_WB.translation().z() = h.z();
    model.ground = stiff_ground(options.mass, options.ground_friction,
                                {{-h.x(), -h.y(), -h.z()},
                                 {h.x(), -h.y(), -h.z()},
                                 {-h.x(), h.y(), -h.z()},
                                 {h.x(), h.y(), -h.z()}});
  }
  const PadLayout layout = PadLayout::flat(options.pad);
  for (const int side : {1, -1}) {
    PadMount mount{layout, options.law, {}, 0, {}};
    // The pad's normal towards the other one, its rows along +z.
    mount.X_GP = geometry::RigidTransform::Identity();
    mount.X_GP.linear().col(2) = Eigen::Vector3d(0, -side, 0);
    mount.X_GP.linear().col(1) = Eigen::Vector3d::UnitZ();
    mount.X_GP.linear().col(0) = mount.X_GP.linear().col(1).cross(mount.X_GP.linear().col(2));
    mount.X_GP.translation() = Eigen::Vector3d(0, side * 0.5 * options.opening, 0);
    mount.direction_G = Eigen::Vector3d(0, -side * (options.coupled ? 0.5 : 1.0), 0);
    mount.slide = options.coupled || side > 0 ? 0 : 1;
    model.pads.push_back(mount);
  }
  SlideModel slide;
  slide.mass = options.coupled ? 0.5 * options.jaw_mass : options.jaw_mass;
  model.slides.assign(options.coupled ? 1 : 2, slide);
  return model;
}

}  // namespace prehend::contact
