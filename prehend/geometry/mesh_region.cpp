#include "prehend/geometry/mesh_region.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/ply_mesh.h"
#include "prehend/text/nearest_match.h"

namespace prehend::geometry {
namespace {

constexpr int kSameColor = 2;          // of 255
constexpr std::size_t kMostNamed = 6;  // colours in an error

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what,
                         const std::string& mend) {
  throw InputError('\'' + path.string() + "' " + what, mend);
}

std::string color_text(const std::array<int, 3>& color) {
  return "[" + std::to_string(color[0]) + ", " + std::to_string(color[1]) + ", " +
         std::to_string(color[2]) + "]";
}

// Leaves the vertices that triangles use.
TriangleMesh without_unused(const TriangleMesh& mesh) {
  TriangleMesh used;
  std::vector<int> place(mesh.vertices.size(), -1);
  for (Eigen::Vector3i t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      int& at = place[static_cast<std::size_t>(t[k])];
      if (at < 0) {
        at = static_cast<int>(used.vertices.size());
        used.vertices.push_back(mesh.vertices[static_cast<std::size_t>(t[k])]);
      }
      t[k] = at;
    }
    used.triangles.push_back(t);
  }
  return used;
}

void add_name(const std::string& name, std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// Our own because Assimp does not tell which of a file's groups a triangle was in, and splits
// vertices that groups share.
TriangleMesh read_obj_region(const std::filesystem::path& path, const MeshRegion& region) {
  const bool by_group = !region.group.empty();
  const std::string& wanted = by_group ? region.group : region.material;
  std::ifstream stream(path);
  TriangleMesh mesh;
  std::vector<std::string> names;
  bool inside = false, in_object = false;
  std::string line, word;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto fail = [&](const std::string& what) {
      refuse(path, "is damaged in line " + std::to_string(number) + ": " + what,
             "Export the file again");
    };
    std::istringstream words(line);
    words >> word;
    if (!words) continue;
    if (word == "v") {
      Eigen::Vector3d p;
      if (!(words >> p.x() >> p.y() >> p.z()) || !p.allFinite()) fail("a vertex is no point");
      mesh.vertices.push_back(p);
    } else if (by_group && (word == "g" || word == "o")) {
      // An object holds groups; a file that names one means all of them.
      bool named = false;
      for (std::string name; words >> name;) {
        add_name(name, names);
        named = named || name == wanted;
      }
      if (word == "o") in_object = named;
      inside = named || in_object;
    } else if (!by_group && word == "usemtl") {
      std::string name;
      words >> name;
      add_name(name, names);
      inside = name == wanted;
    } else if (word == "f" && inside) {
      std::vector<int> polygon;
      for (std::string corner; words >> corner;) {
        const int index = std::atoi(corner.c_str());
        const int count = static_cast<int>(mesh.vertices.size());
        const int at = index < 0 ? count + index : index - 1;
        if (at < 0 || at >= count) fail("a face names the vertex " + corner);
        polygon.push_back(at);
      }
      if (polygon.size() < 3) fail("a face has fewer than three corners");
      for (std::size_t k = 2; k < polygon.size(); ++k) {
        mesh.triangles.emplace_back(polygon[0], polygon[k - 1], polygon[k]);
      }
    }
  }
  if (std::find(names.begin(), names.end(), wanted) == names.end()) {
    refuse(
        path,
        std::string("has no ") + (by_group ? "group or object" : "material") + " '" + wanted + "'",
        text::nearest_match_mend(wanted, names));
  }
  if (mesh.triangles.empty()) {
    refuse(path,
           std::string("has no face in ") + (by_group ? "group" : "material") + " '" + wanted + "'",
           "Give it faces, or name another");
  }
  return mesh;
}

TriangleMesh read_painted(const std::filesystem::path& path, const std::array<int, 3>& color) {
  PlyColors colors;
  TriangleMesh mesh = read_ply_mesh(path, 1, &colors);
  const bool of_faces = !colors.triangles.empty();
  if (!of_faces && colors.vertices.empty()) {
    refuse(path, "has neither faces nor vertices with colours",
           "Paint it and export it with its colours, or name another region");
  }
  const auto is_painted = [&color](const std::array<int, 3>& other) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs(other[k] - color[k]) > kSameColor) return false;
    }
    return true;
  };
  std::vector<Eigen::Vector3i> painted;
  std::map<std::array<int, 3>, std::size_t> seen;
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    if (t.minCoeff() < 0 || t.maxCoeff() >= count) {
      refuse(path, "has a triangle with a vertex that does not exist", "Export the file again");
    }
    bool all = true;
    for (int k = 0; k < 3; ++k) {
      const auto& own =
          of_faces ? colors.triangles[i] : colors.vertices[static_cast<std::size_t>(t[k])];
      ++seen[own];
      all = all && is_painted(own);
    }
    if (all) painted.push_back(t);
  }
  if (painted.empty()) {
    std::vector<std::pair<std::size_t, std::array<int, 3>>> most;
    for (const auto& [one, times] : seen) most.emplace_back(times, one);
    std::sort(most.rbegin(), most.rend());
    std::string known;
    for (std::size_t i = 0; i < std::min(kMostNamed, most.size()); ++i) {
      known += (known.empty() ? "" : ", ") + color_text(most[i].second);
    }
    refuse(path, "has no face painted " + color_text(color),
           "Its most frequent colours are " + known);
  }
  mesh.triangles = std::move(painted);
  return mesh;
}

}  // namespace

TriangleMesh read_mesh_region(const std::filesystem::path& path, const MeshRegion& region) {
  if (region.is_all()) return read_mesh_file(path);
  checked_file_size(path);
  const std::string extension = lower_case_extension(path);
  if (region.color) {
    if (extension != ".ply") {
      refuse(path, "is no PLY, and only its faces' colours are read", "Export it as one");
    }
    return without_unused(read_painted(path, *region.color));
  }
  if (extension != ".obj") {
    refuse(path, "is no OBJ, and only its groups and materials have names", "Export it as one");
  }
  return without_unused(read_obj_region(path, region));
}

}  // namespace prehend::geometry
