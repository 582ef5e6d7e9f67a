#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/table.h"

namespace prehend::calibration {

/// A view of the table: a cloud in the optical frame C and where the camera was in the frame A, z
/// up, in which the table is wanted. Without, A is C.
struct TableView {
  std::string name;
  geometry::PointCloud cloud_C;
  std::optional<geometry::RigidTransform> X_AC;
};

struct WorkAreaEdge {
  Eigen::Vector3d from_A = Eigen::Vector3d::Zero(), to_A = Eigen::Vector3d::Zero();  // m, corners
  double rms = 0;       // m, of the outermost points about the line
  bool is_real = true;  // false: the images end there, the table may go on
};

struct TableViewFit {
  std::string name;
  int points = 0;   // on the table
  double mean = 0;  // m, of the points over the common plane
  double rms = 0;   // m, about it
  double tilt = 0;  // rad, of the view's own plane against the common one
};

struct WorkAreaFit {
  geometry::Plane plane_A;            // normal towards the cameras
  std::array<WorkAreaEdge, 4> edges;  // in order, right hand about the normal
  double length = 0, width = 0;       // m, length >= width
  double rms = 0;                     // m, of all points about the plane
  std::vector<TableViewFit> views;
  std::vector<std::string> remarks;
};

struct WorkAreaOptions {
  perception::TableOptions table;
  double most_tilt = 0.02;    // rad, of a view's plane against the common one
  double most_offset = 0.01;  // m, of a view's points on average
};

/// Plane and edges of a rectangular table: each view's table, one plane by
/// least squares over all their points, and for each side of the smallest rectangle round them a
/// line through the outermost points of strips across it (Huber's weights). An edge is moved
/// outward by half the distance of points, as the outermost one lies by that within on average.
/// Where up is known, a view's table is the highest of the level planes (perception::find_tables)
/// with two sides of 0.25 m, as a floor about it may be the larger one; else find_table's.
/// @throws DegenerateData "no views"; "camera's poses missing" for several views of which one has
/// none; "views disagree" when one view's plane is tilted against the
/// common one or beside it (a wrong pose of the camera); geometry::InputError as find_table, with
/// the view's name.
WorkAreaFit calibrate_work_area(const std::vector<TableView>& views,
                                const WorkAreaOptions& options = {});

}  // namespace prehend::calibration
