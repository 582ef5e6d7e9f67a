#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_layout.h"
#include "prehend/geometry/mesh_region.h"
#include "prehend/robot/hand_model.h"

// Tactile pads on a link's surface, whatever its shape.
namespace prehend::robot {

/// Cells where a grid in P, projected along P's z onto the link's shapes, meets them first. Rays
/// begin half the grid's longer side above its plane and reach as far below. The cells' face stands
/// `raised` [m] over the shapes, along z. Cells of `left_out` (row, column) are not there. @throws
/// std::invalid_argument (contact::PadLayout::bent), also when the link has no shapes.
contact::PadLayout lay_on_link(const Link& link, const geometry::RigidTransform& X_LP,
                               const contact::PadGrid& grid, double raised = 0,
                               const std::vector<Eigen::Vector2i>& left_out = {});

/// A region of a mesh, in the link's frame.
struct PadRegion {
  std::filesystem::path file;
  geometry::MeshRegion region;
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  // m per unit of the file; negative: mirrored
  geometry::RigidTransform X_LS = geometry::RigidTransform::Identity();  // the file's frame
};

/// Cells at the region's vertices (contact::PadLayout::curved); those at one place are one.
/// @throws geometry::InputError (geometry::read_mesh_region) naming the file, also for a region
/// that is longer than 1 m, as of a file in millimetres; std::invalid_argument for one without area
/// or a vertex without a mean normal, and a thickness [m] that is not positive.
contact::PadLayout cells_of_region(const PadRegion& region, double thickness);

/// The first two pads of one link that have cells at one place, whose foam would count twice, in
/// words: "'a' and 'b' overlap at ..."; empty: none.
std::string overlap(const HandPad& a, const HandPad& b);

}  // namespace prehend::robot
