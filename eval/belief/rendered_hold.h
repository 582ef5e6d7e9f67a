#pragma once

#include <memory>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "eval/data_sets.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

// What a camera measures of a thing that a hand holds.
namespace prehend::eval {

/// Off by so much, standard [m, rad], about `middle`.
geometry::RigidTransform disturbance(double along, double turn, const Eigen::Vector3d& middle,
                                     std::mt19937_64* random);

/// Adds a robot's links to what is rendered.
void add_links(const std::vector<geometry::TriangleMesh>& links_W, RenderedScene* rendered);

/// The depth that the scene's camera measures of a body at X_WB, with the texture of the scene's
/// first, and of the robot's links. @param look which of this scene, for the noise.
geometry::DepthImage seen_hold(RenderedScene rendered,
                               std::shared_ptr<const geometry::TriangleMesh> mesh_B,
                               const geometry::RigidTransform& X_WB,
                               const std::vector<geometry::TriangleMesh>& links_W, int look);

}  // namespace prehend::eval
