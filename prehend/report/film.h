#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::report {

/// A body of a film.
struct FilmBody {
  std::string name;  // bodies of one name are shown and hidden together
  geometry::Rgb color{200, 200, 200};
  double opacity = 1;  // in (0, 1]
  geometry::TriangleMesh mesh_B;
  std::vector<geometry::RigidTransform> X_WB;  // one for each frame, or one for all
};

/// Bodies that move, to be looked at from all sides in a page (Page::add_film()).
struct Film {
  std::vector<double> times;          // s, of the frames, increasing
  std::vector<std::string> captions;  // of the frames: what happens then
  std::vector<FilmBody> bodies;
};

/// The film as web/src/report reads it, without any '<'. Lengths and poses as float32.
/// @throws std::invalid_argument without frames or bodies, for times that do not increase, another
/// number of captions or poses than frames, an opacity out of range, or what is not finite.
std::string film_json(const Film& film);

}  // namespace prehend::report
