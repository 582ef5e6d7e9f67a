#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"

// Where an object can be put down.
namespace prehend::planning {

struct PlaceOptions {
  double distance = 0.15;    // m, > 0: it is put so far away if there is room, else farther ...
  double farthest = 0.4;     // m, >= distance: ... up to this
  double step = 0.08;        // m, > 0, between distances that are tried
  int directions = 12;       // > 0, that are tried at each, from world +y counter-clockwise
  double clearance = 0.015;  // m, >= 0, that must be between what is put down and anything else
  double enough = 0.05;      // m, >= clearance: places with so much room come before others
  /// Where the object's middle is to stand, x and y of the world [m]: this place or none.
  std::optional<Eigen::Vector2d> given_W;
  /// The part of the table in which the object's middle is to stand, along x and y of the world
  /// [m]; its middle is tried first, what is within 3 cm of its edge last, as predictions are off
  /// by so much.
  struct Region {
    std::string name;
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    Eigen::Vector2d size = Eigen::Vector2d::Zero();  // > 0
  };
  std::optional<Region> region_W;  // not with given_W
  /// The object's middle for `given_W` and `region_W`, x and y of the world [m]; unset: of the box
  /// round its outline.
  std::optional<Eigen::Vector2d> middle_W;
  /// Why the object cannot be carried by a displacement [m], in words; empty: it can, as far as is
  /// known. Unset: everywhere.
  std::function<std::string(const Eigen::Vector3d& move_W)> unreachable;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

inline constexpr const char* kPlaceMend = "Give another place, or none to have one chosen";

struct FreePlaces {
  /// Displacements of the object [m], best first: along the table, and down to it where the
  /// object's lowest point is more than 1 cm above, as of what stood on another. Last, unless a
  /// place or a region was given, where it stands now (zero): that is free by then.
  std::vector<Eigen::Vector3d> moves_W;
  /// Why a place or a region that was given cannot be used, in words (kPlaceMend would help); else
  /// empty.
  std::string problem;
};

/// Free places for an object of which the surface's points are `object_W`, among others (points of
/// each) [m]. Places with `enough` room come first, nearest first; then those with less, most room
/// first. Room is the distance of convex outlines on the table, at most 0.2 % less than the true
/// one, negative where they overlap. What was never seen is not known to be in the way.
/// Cost: 0.1 ms and 1 ms for each 100 000 points.
/// @throws std::invalid_argument for options out of range or an object without points.
FreePlaces free_places(const geometry::Plane& table_W, const std::vector<Eigen::Vector3d>& object_W,
                       const std::vector<std::vector<Eigen::Vector3d>>& others_W,
                       const PlaceOptions& options = {});

/// "x,y" [m]; nothing for an empty text. @throws geometry::InputError for anything else.
std::optional<Eigen::Vector2d> read_place(const std::string& text);

}  // namespace prehend::planning
