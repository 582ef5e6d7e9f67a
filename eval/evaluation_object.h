#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/simulation/texture.h"

namespace prehend::eval {

/// What measures depth.
enum class DepthSensor { kStereo, kStructuredLight };

/// How and among what an object is seen. The defaults are those of the household objects.
struct Viewing {
  /// Others in the scene, in the object's frame: what it stands on, leans on, is hidden by [m].
  std::vector<std::shared_ptr<const geometry::TriangleMesh>> others_B;
  DepthSensor sensor = DepthSensor::kStereo;
  double elevation = 0;  // degrees of the camera over the table; 0: the default camera
  double distance = 0;   // m from the camera to what it looks at; 0: the default camera
  Eigen::Vector2d look_aside = Eigen::Vector2d::Zero();  // of the object, parts of half the image
  double missing = 0;  // part of the object that gives no depth: dark, shiny
  /// Of the object and each of `others_B`; empty: as follows from the object's name.
  std::vector<simulation::Texture> textures;
};

/// A body whose true shape is known.
struct EvaluationObject {
  std::string name;
  /// Standing on z = 0, the middle of its bounds on the z axis, facing outward [m]. One that rests
  /// on another is where it is then.
  std::shared_ptr<const geometry::TriangleMesh> mesh_B;
  bool symmetric = true;  // has a vertical plane of symmetry when it stands (as far as is known)
  bool lies_too = false;  // is also evaluated lying on its side
  Viewing viewing;
};

}  // namespace prehend::eval
