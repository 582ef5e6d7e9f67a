#include "prehend/robot/mesh_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"

namespace prehend::robot {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;

constexpr double kRounding = 1e-6;     // of the extent: vertices nearer to one another are one
constexpr double kLargest = 10;        // m, of a link
constexpr double kSmallest = 1e-4;     // m
constexpr double kMostHoles = 0.25;    // of the surface's area, that may be closed by patches
constexpr double kLeastVolume = 1e-9;  // of the extent's cube

/// What stands behind `prefix`; none when it does not begin with it.
std::optional<std::string> after(const std::string& name, const std::string& prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  return name.substr(prefix.size());
}

/// `package://` and `model://` name what is in a package, and nothing beside it.
void refuse_outside(const std::string& name, const std::string& package,
                    const std::filesystem::path& rest) {
  const std::filesystem::path normal = rest.lexically_normal();
  const bool leaves = rest.is_absolute() || (!normal.empty() && *normal.begin() == "..");
  if (!leaves && !package.empty() && package != "." && package != "..") return;
  throw InputError("'" + name + "' leaves its package",
                   "Name a file in the package, or one by its path");
}

/// Where a package's file may lie.
std::vector<std::filesystem::path> package_places(const std::string& package,
                                                  const std::filesystem::path& rest,
                                                  const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> places;
  const auto in_or_as = [&](const std::filesystem::path& place) {
    if (place.filename() == package) places.push_back(place / rest);
    places.push_back(place / package / rest);
  };
  // The folder of "robot.urdf" is empty, of which none would be absolute.
  std::filesystem::path up =
      std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal();
  if (!up.has_filename()) up = up.parent_path();  // of "folder/"
  for (; up.has_relative_path(); up = up.parent_path()) in_or_as(up);
  const char* listed = std::getenv("ROS_PACKAGE_PATH");
  std::istringstream path(listed ? listed : "");
  for (std::string place; std::getline(path, place, ':');) {
    if (!place.empty()) in_or_as(std::filesystem::path(place).lexically_normal());
  }
  return places;
}

/// Edges (from, to) that the triangles of a mesh pass more often that way than back: those where
/// its surface ends. Shells that touch along an edge pass it twice either way, which find_defects()
/// counts as a defect; they bound a solid.
std::vector<std::pair<int, int>> open_edges(const TriangleMesh& mesh) {
  std::vector<std::pair<int, int>> there, back, open;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      there.emplace_back(t[k], t[(k + 1) % 3]);
      back.emplace_back(t[(k + 1) % 3], t[k]);
    }
  }
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  std::set_difference(there.begin(), there.end(), back.begin(), back.end(),
                      std::back_inserter(open));
  return open;
}

/// Closes the holes along `open` by a fan each, about the middle of its rim. How many there were.
/// As many open edges end at a vertex as begin there, so that every walk along them comes back.
int close_holes(const std::vector<std::pair<int, int>>& open, TriangleMesh& mesh) {
  std::multimap<int, int> on;  // the way round a hole is against the triangles'
  for (const auto& [from, to] : open) on.emplace(to, from);
  int holes = 0;
  for (; !on.empty(); ++holes) {
    std::vector<int> rim{on.begin()->first};
    do {
      const auto next = on.find(rim.back());
      rim.push_back(next->second);
      on.erase(next);
    } while (rim.back() != rim.front());
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t i = 1; i < rim.size(); ++i) middle += mesh.vertices[rim[i]];
    const int hub = static_cast<int>(mesh.vertices.size());
    mesh.vertices.emplace_back(middle / static_cast<double>(rim.size() - 1));
    for (std::size_t i = 1; i < rim.size(); ++i) {
      mesh.triangles.emplace_back(rim[i - 1], rim[i], hub);
    }
  }
  return holes;
}

/// Makes a solid of a surface with holes; the remark on it.
std::string make_closed(TriangleMesh& mesh, const std::string& name) {
  const std::vector<std::pair<int, int>> open = open_edges(mesh);
  if (open.empty()) return "";
  // An edge that is open twice has triangles of opposite orientation beside it.
  const bool oriented = std::adjacent_find(open.begin(), open.end()) == open.end();
  TriangleMesh closed = mesh;
  const int holes = close_holes(open, closed);
  const double area = geometry::surface_area(mesh);
  if (oriented && geometry::surface_area(closed) - area < kMostHoles * area) {
    mesh = std::move(closed);
    return name + " has " + std::to_string(holes) + " holes or cracks: closed";
  }
  mesh = geometry::convex_hull(mesh.vertices);
  return name + " does not close: its convex hull stands for it";
}

void turn_over(TriangleMesh& mesh) {
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
}

std::string in_words(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g m", length);
  return text.data();
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what,
                         const std::string& mend) {
  throw InputError("'" + file.string() + "' " + what, mend);
}

}  // namespace

std::filesystem::path find_mesh_file(const std::string& name, const std::filesystem::path& folder,
                                     std::vector<std::filesystem::path>* looked) {
  std::vector<std::filesystem::path> places;
  std::optional<std::string> packed = after(name, "package://");
  if (!packed) packed = after(name, "model://");
  if (packed) {
    const std::size_t end = std::min(packed->find('/'), packed->size());
    const std::string rest = packed->substr(std::min(end + 1, packed->size()));
    const std::string package = packed->substr(0, end);
    refuse_outside(name, package, rest);
    places = package_places(package, rest, folder);
  } else {
    places.push_back(folder / after(name, "file://").value_or(name));
  }
  if (looked) *looked = places;
  std::error_code ignored;
  for (const std::filesystem::path& place : places) {
    if (std::filesystem::is_regular_file(place, ignored)) return place;
  }
  return places.empty() ? std::filesystem::path(name) : places.front();
}

SolidMesh read_solid_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale) {
  if (!scale.allFinite() || !(scale.cwiseAbs().minCoeff() > 0)) {
    refuse(file, "has a scale that is 0 or no number", "Write scale=\"1 1 1\", or leave it out");
  }
  TriangleMesh mesh = geometry::read_mesh_file(file);
  for (Eigen::Vector3d& p : mesh.vertices) p = p.cwiseProduct(scale);
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  if (!(extent >= kSmallest && extent <= kLargest)) {
    refuse(file, "is " + in_words(extent) + " long at its scale",
           "URDF is in metres: of a mesh in millimetres write scale=\"0.001 0.001 0.001\"");
  }
  if (scale.prod() < 0) turn_over(mesh);
  return solid_mesh(std::move(mesh), "'" + file.string() + "'");
}

SolidMesh solid_mesh(TriangleMesh mesh, const std::string& name) {
  const double extent = mesh.vertices.empty() ? 0 : geometry::bounds(mesh).sizes().maxCoeff();
  if (!(extent > 0 && std::isfinite(extent))) {
    throw InputError(name + " has no size", "Give a mesh with volume");
  }
  mesh = geometry::with_merged_vertices(mesh, kRounding * extent);
  SolidMesh result;
  try {
    result.remark = make_closed(mesh, name);
  } catch (const InputError&) {
    throw InputError(name + " is flat", "Give a mesh with volume");
  }
  const double volume = geometry::mass_properties(mesh).volume;
  if (!(std::abs(volume) > kLeastVolume * extent * extent * extent)) {
    throw InputError(name + " encloses no volume", "Give a mesh of a solid");
  }
  if (volume < 0) turn_over(mesh);
  result.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return result;
}

}  // namespace prehend::robot
