#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/closing/distance_block.h"

namespace prehend::grasp {

/// Unsigned distance to a mesh, on a grid that is filled where it is asked for, a block of nodes at
/// a time: many near queries of one mesh cost some 10 ns each instead of a microsecond. Needs
/// neither a closed mesh nor outward triangles. Made for balls that touch the mesh from outside: at
/// a ball's centre the distance is smooth even where the mesh is a needle or an edge.
///
/// Reentrant: const calls may run at once (each node is filled with the same value by whoever comes
/// first), and answers do not depend on their order.
class DistanceGrid {
 public:
  /// Nodes `cell` [m] apart up to `margin` [m] round the mesh; both > 0. Memory is taken where
  /// nodes are filled alone, so that a mesh may be of things far apart; one so large that it takes
  /// more than 100 million nodes (a metre in each direction) is asked directly instead. Keeps a
  /// reference to `mesh`.
  /// @throws std::invalid_argument for a cell or a margin that is not positive and finite.
  explicit DistanceGrid(const geometry::SurfaceQuery& mesh, double cell = 0.0025,
                        double margin = 0.03);

  /// Distance [m] within kNear of the mesh, by linear interpolation: wrong by at most cell^2 / (4
  /// d), and exact beside flat faces. Farther away a lower bound of it, larger than kNear.
  double distance(const Eigen::Vector3d& p) const;
  /// Direction away from the mesh, of unit length but where it is undefined (0).
  Eigen::Vector3d away(const Eigen::Vector3d& p) const;

  const geometry::SurfaceQuery& mesh() const { return *mesh_; }

  static constexpr double kNear = 0.0125;  // m, above the largest balls' radius and 2 mm

 private:
  /// A cell of the grid, by its lowest node, and where in it a point is: 0 to 1.
  struct Cell {
    int x, y, z;
    double part_x, part_y, part_z;
  };
  bool find_cell(const Eigen::Vector3d& p, Cell& cell) const;
  /// Numbers that are NaN at first. Theirs is memory that the system has zeroed and does not
  /// provide before it is written to, so they are kept with all bits inverted. Calls may run at
  /// once.
  class LazyFloats {
   public:
    LazyFloats() = default;
    explicit LazyFloats(std::size_t count);
    explicit operator bool() const { return bits_ != nullptr; }
    float operator[](std::size_t i) const;
    void set(std::size_t i, float value) const;

   private:
    struct Free {
      void operator()(std::uint32_t* memory) const { std::free(memory); }
    };
    std::unique_ptr<std::uint32_t[], Free> bits_;
  };

  double coarse_node(int x, int y, int z) const;
  double node(int x, int y, int z) const;
  void fill_block(const Eigen::Vector3i& block) const;
  /// Distances at a cell's corners; x changes fastest.
  void corners(const Cell& cell, double (&values)[8]) const;

  const geometry::SurfaceQuery* mesh_;
  std::optional<DistanceBlocks> blocks_;  // none: too many nodes
  Eigen::AlignedBox3d box_;               // of the mesh
  Eigen::Vector3d origin_;                // of the nodes
  double cell_, per_cell_;                // m and its inverse
  Eigen::Vector3i count_, coarse_count_;
  // NaN: not filled; none: too many. The coarse ones are apart: they stay in the fastest cache.
  LazyFloats nodes_, coarse_nodes_;
};

}  // namespace prehend::grasp
