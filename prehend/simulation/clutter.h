#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

// Heaps of things on a table, as they come to rest.
namespace prehend::simulation {

/// A solid that may be put on the table, as often as is drawn.
struct ClutterSolid {
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> mesh_B;  // closed [m]; upright with z up
  double mass = 0;                                       // kg
  double friction = 0.7;
};

/// How a body is put beside those that are there already.
enum class ClutterPlacing {
  kApart,     // `gap` away from all others
  kTouching,  // pushed against one
  kStacked,   // lowered onto one
  kLeaning,   // tilted, let fall against one
  kHidden,    // behind one, as seen from the eye
};
std::string to_string(ClutterPlacing placing);

/// Shares are probabilities for each body but the first; what they leave over stands apart.
struct ClutterOptions {
  int count = 6;                   // bodies, 1 to 12
  Eigen::Vector2d center{0, 0};    // m, of the part of the table that they are put on
  Eigen::Vector2d size{0.4, 0.4};  // m, its sides
  double touching = 0, stacked = 0, leaning = 0, hidden = 0;
  double tumbled = 0;                 // share that is dropped in any orientation, not upright
  double gap = 0.03;                  // m, between the circles round two that stand apart
  Eigen::Vector3d eye{0.54, 0, 0.5};  // m, of the camera
  double table_friction = 0.5;
  std::uint64_t seed = 1;

  /// @throws std::invalid_argument naming the field.
  void validate() const;
};

struct ClutterBody {
  std::string name;       // of the solid, numbered
  std::size_t solid = 0;  // which
  ClutterPlacing placing = ClutterPlacing::kApart;
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();  // at rest
};

/// Puts one after the other down, lets it go a millimetre above whatever bears it, and waits until
/// all that it moved is at rest (World). One that rolls off `size` by more than 0.1 m, does not
/// come to rest in six seconds, or takes another one along is taken away, and others are tried; a
/// body for which no place is found in 40 tries ends it, so that there may be fewer than `count`.
/// Same solids and options, same result. Cost: about a second a body.
/// @param progress called with how many bodies lie; may be empty.
/// @throws std::invalid_argument for options, or no solids; geometry::InputError for a mesh that is
/// no solid or larger than `size`.
std::vector<ClutterBody> drop_clutter(const std::vector<ClutterSolid>& solids,
                                      const ClutterOptions& options,
                                      const std::function<void(int)>& progress = {});

}  // namespace prehend::simulation
