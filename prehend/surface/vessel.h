#pragma once

#include <optional>
#include <vector>

#include "prehend/geometry/image.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/surface/table_grid.h"

namespace prehend::surface {

/// The hollow of an open vessel: where water would stand in what the points enclose.
struct Basin {
  TableGrid grid;
  geometry::Image<float> level;  // of the water over each cell [m over the table]; 0: none
  geometry::Image<float> floor;  // under it; <= 0: nothing is known of it
  std::vector<bool> lines;       // one per point: it lines the hollow, and is not outside
  double rim = 0;                // height over the table at which the deepest water runs over [m]
  double depth = 0;              // of the water at its deepest [m]
  double area = 0;               // of the water's surface [m^2]
};

/// Fills what `cloud` (with normals, standing on `table`) encloses up to where it runs over, on a
/// map of the highest points in cells of 3 `spacing` [m] (the distance between points): priority
/// flood, Barnes et al., "Priority-flood: An optimal depression-filling and watershed-labeling
/// algorithm for digital elevation models", 2014. Gaps of a cell in a rim, and enclosed cells
/// without points, are no drains. None when the water is less deep than 8 mm or a tenth of the
/// height, or covers less than a tenth of the footprint: a dent is no vessel. O(n log n).
std::optional<Basin> find_basin(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                double spacing);

/// What is known of a vessel's wall.
struct VesselWall {
  double thickness = 0;   // [m]
  bool measured = false;  // from places where both sides are known; else assumed
};

/// Gives the wall of a vessel two sides that are one thickness apart. Of most of a wall only one
/// side is seen; the other is either not known at all, and then what is below would be solid, or it
/// is predicted (mirrored), with an error as large as the wall is thick. So each seen point on a
/// wall gets a partner, behind it by the thickness, with the opposite normal, and predicted points
/// on the other side near it go. Where neither side was seen, as that of walls along the line of
/// sight, an upright wall joins the rim and the floor; a floor that is hidden is one thickness over
/// the table. The thickness is the median of the distances between points of both sides in the
/// upper half of the hollow (of those within twice the lower quartile: others face what is no
/// wall), at least `least_thickness` [m] (what the surface can resolve); 4 mm where less than a
/// fifth of the points has such a partner.
/// @param seen one per point of `cloud`; resized with it.
VesselWall add_vessel_walls(geometry::PointCloud& cloud, std::vector<bool>& seen,
                            const Basin& basin, double spacing, double least_thickness);

}  // namespace prehend::surface
