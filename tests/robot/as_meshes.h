#pragma once

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::robot {

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A URDF's text with every box, cylinder and sphere written into `folder` as a mesh file, of the
/// formats by turns, and named instead. Round ones have 48 segments.
inline std::string with_meshes(std::string text, const std::filesystem::path& folder,
                               const std::string& prefix = "shape") {
  static const std::regex kShape(
      R"re(<(?:box size="([^ ]+) ([^ ]+) ([^ "]+)"|cylinder radius="([^"]+)" length="([^"]+)"|sphere radius="([^"]+)")/>)re");
  const std::vector<std::string> formats{"stl", "obj", "ply"};
  std::string result;
  int count = 0;
  for (std::smatch found; std::regex_search(text, found, kShape); text = found.suffix()) {
    geometry::TriangleMesh mesh;
    if (found[1].matched) {
      mesh = geometry::make_box({std::stod(found[1]), std::stod(found[2]), std::stod(found[3])});
    } else if (found[4].matched) {
      const double radius = std::stod(found[4]), half = std::stod(found[5]) / 2;
      mesh = geometry::make_revolution({{radius, -half}, {radius, half}}, 48);
    } else {
      mesh = geometry::make_sphere(std::stod(found[6]), 48);
    }
    const std::string name =
        prefix + "_" + std::to_string(count) + "." + formats[static_cast<std::size_t>(count) % 3];
    ++count;
    geometry::write_mesh_file(folder / name, mesh);
    result += found.prefix().str() + "<mesh filename=\"" + name + "\"/>";
  }
  return result + text;
}

/// Writes `folder`/NAME of config/robots with meshes for its shapes.
inline std::filesystem::path write_with_meshes(const std::string& name,
                                               const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / name) << with_meshes(text_of("config/robots/" + name), folder, name);
  return folder / name;
}

}  // namespace prehend::robot
