#pragma once

#include <utility>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"

namespace prehend::surface {

/// Square cells on a table, with axes in it.
struct TableGrid {
  geometry::Plane table;
  Eigen::Vector3d x, y;  // unit, in the table
  Eigen::Vector2d low;   // corner of cell (0, 0) along x and y [m]
  double cell = 0;       // side [m]
  int width = 0, height = 0;

  Eigen::Vector2d on_table(const Eigen::Vector3f& p) const {
    return {x.dot(p.cast<double>()), y.dot(p.cast<double>())};
  }
  double height_of(const Eigen::Vector3f& p) const {
    return table.signed_distance(p.cast<double>());
  }
  std::pair<int, int> cell_of(const Eigen::Vector3f& p) const {
    const Eigen::Vector2d q = (on_table(p) - low) / cell;
    return {static_cast<int>(q.x()), static_cast<int>(q.y())};
  }
  Eigen::Vector2d middle(int u, int v) const {
    return low + cell * Eigen::Vector2d(u + 0.5, v + 0.5);
  }
  Eigen::Vector3f point(const Eigen::Vector2d& at, double over_table) const {
    return (at.x() * x + at.y() * y + (table.offset + over_table) * table.normal).cast<float>();
  }
  Eigen::Vector3f across(const Eigen::Vector2d& direction) const {
    return (direction.x() * x + direction.y() * y).cast<float>();
  }
};

}  // namespace prehend::surface
