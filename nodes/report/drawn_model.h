#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "prehend/geometry/camera_model.h"
#include "prehend/report/pictures.h"
#include "prehend/surface/object_model.h"

namespace prehend::nodes {

constexpr geometry::Rgb kSeenColor{40, 110, 190};
constexpr geometry::Rgb kMirroredColor{235, 130, 40};
constexpr geometry::Rgb kAssumedColor{170, 170, 175};
constexpr geometry::Rgb kTouchedColor{60, 160, 80};
constexpr geometry::Rgb kObjectColor{215, 190, 150};

/// Of the page's pictures of objects.
geometry::PinholeCamera object_camera();

/// Poses from which object_camera() shows all of `box`: from the azimuth [rad], and from behind.
std::vector<geometry::RigidTransform> two_views(const Eigen::AlignedBox3d& box, double azimuth);

/// The mesh in the colours of what its parts rest on; in one colour when the sender did not say.
std::vector<report::ColoredMesh> by_origin(const surface::ObjectModel& model);

}  // namespace prehend::nodes
