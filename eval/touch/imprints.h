#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

// Blocks with holes of many shapes, for recognition by touch.
namespace prehend::eval::touch {

/// A hole in a face: whether p [m], from the hole's middle, is in it.
struct Hole {
  std::string name;
  bool (*contains)(const Eigen::Vector2d& p);
};

/// Ten shapes, 17 to 28 mm: cross, square, disc, triangle, bar, angle, ring, tee, two discs, half a
/// disc. Pads are 20 mm wide: no press shows the larger ones whole.
const std::vector<Hole>& holes();
/// Ten others of like sizes, on which a recogniser's choices are made: hexagon, ellipse, rectangle,
/// zed, channel, aitch, star, three discs, quarter of a disc, chevron.
const std::vector<Hole>& holes_to_choose_on();

/// One side of a block: what hole it has, and where its middle is [m].
struct BlockSide {
  const Hole* hole = nullptr;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
};

/// A block of `size` [m] centred at the origin with a hole 8 mm deep in its face at +y and one in
/// that at -y. (x, z) on the faces; cells of 0.5 mm.
geometry::TriangleMesh perforated_block(const Eigen::Vector3d& size, const BlockSide& plus_y,
                                        const BlockSide& minus_y);

}  // namespace prehend::eval::touch
