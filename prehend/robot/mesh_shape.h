#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"

// The meshes that a URDF names as collision shapes.
namespace prehend::robot {

/// The file that `<mesh filename="NAME"/>` of a URDF in `folder` means. NAME is a path, absolute or
/// relative to `folder`, with or without `file://` before it; or `package://PACKAGE/REST` (also
/// `model://`), which is looked for, in this order, as REST in a folder called PACKAGE that is, or
/// lies in, `folder` or one above it, and in or as one of those that the environment's
/// ROS_PACKAGE_PATH lists, parted by colons. What is no file anywhere: the first that was looked
/// for, and `looked` lists all.
/// @throws geometry::InputError for a name that leaves its package: package://a/../../b
std::filesystem::path find_mesh_file(const std::string& name, const std::filesystem::path& folder,
                                     std::vector<std::filesystem::path>* looked = nullptr);

/// A mesh that bounds a solid.
struct SolidMesh {
  std::shared_ptr<const geometry::TriangleMesh> mesh;  // closed, triangles outward, m
  std::string remark;  // what was changed of the file's surface and why; empty: nothing
};

/// The solid that a mesh [m] bounds. Vertices within 1e-6 of its extent become one. A surface
/// closes when each edge is passed as often one way as the other. Holes and cracks in one that does
/// not are closed by flat patches as long as these have less than a quarter of its area; else, or
/// when triangles beside one another are turned opposite ways, its convex hull stands for it.
/// `remark` says either, beginning with `name`.
/// @throws geometry::InputError beginning with `name`: a mesh without volume.
SolidMesh solid_mesh(geometry::TriangleMesh mesh, const std::string& name);

/// Reads a mesh (geometry::read_mesh_file()), times `scale` along each axis; a negative one mirrors
/// it; as solid_mesh(). @throws geometry::InputError naming the file: one that cannot be read; a
/// scale with a 0 or what is no number; a mesh without volume; one longer than 10 m or shorter than
/// 0.1 mm, which is in another unit.
SolidMesh read_solid_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale);

}  // namespace prehend::robot
