#pragma once

#include <string>

#include <Eigen/Core>

namespace prehend::testing {

/// A PCD file with colours: what a camera 30 mm over a red box of `size` [m] (across the view,
/// along it, high) sees of it, 0.8 m away: front and top, and no table.
std::string image_of_a_box(const Eigen::Vector3d& size);

}  // namespace prehend::testing
