#include "prehend/report/figure_data.h"

#include <cstring>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/report/base64.h"
#include "prehend/text/require.h"
#include "prehend/text/tree_file.h"

namespace prehend::report {
namespace {

template <class Number>
std::string bytes_as_base64(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  if (!numbers.empty()) std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return base64(bytes);
}

// Without vertices of no triangle.
geometry::TriangleMesh compact(const geometry::TriangleMesh& mesh) {
  geometry::TriangleMesh used;
  std::vector<int> place(mesh.vertices.size(), -1);
  for (Eigen::Vector3i corners : mesh.triangles) {
    for (int& v : corners) {
      int& at = place[static_cast<std::size_t>(v)];
      if (at < 0) {
        at = static_cast<int>(used.vertices.size());
        used.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
      }
      v = at;
    }
    used.triangles.push_back(corners);
  }
  return used;
}

void check(const geometry::TriangleMesh& mesh, const std::string& what) {
  const text::Require require{what};
  const auto vertices = static_cast<int>(mesh.vertices.size());
  for (const auto& p : mesh.vertices) require(p.allFinite(), "a vertex is not finite");
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    require(corners.minCoeff() >= 0 && corners.maxCoeff() < vertices,
            "a triangle has no such corner");
  }
}

}  // namespace

std::string color_text(const geometry::Rgb& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

std::string packed(const std::vector<float>& numbers) { return bytes_as_base64(numbers); }
std::string packed(const std::vector<std::uint32_t>& numbers) { return bytes_as_base64(numbers); }

void set_mesh(text::Json& object, const geometry::TriangleMesh& mesh, const std::string& what) {
  check(mesh, what);
  const geometry::TriangleMesh used = compact(mesh);
  std::vector<float> vertices;
  for (const Eigen::Vector3d& p : used.vertices) {
    for (int k = 0; k < 3; ++k) vertices.push_back(static_cast<float>(p[k]));
  }
  std::vector<std::uint32_t> triangles;
  for (const Eigen::Vector3i& corners : used.triangles) {
    for (int k = 0; k < 3; ++k) triangles.push_back(static_cast<std::uint32_t>(corners[k]));
  }
  object.set("vertices", packed(vertices));
  object.set("triangles", packed(triangles));
}

std::string for_script(const text::Json& json) {
  std::string out;
  for (const char c : json.text()) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

std::string figure_program() {
  const std::string file = text::tree_file("web/dist/report.js");
  std::ifstream in(file, std::ios::binary);
  std::string program(std::istreambuf_iterator<char>(in), {});
  if (!in || program.empty()) {
    throw geometry::InputError("Nothing is drawn in three dimensions: " + file + " is not there",
                               "Install prehend's programs, or set PREHEND_ROOT to its tree");
  }
  return program;
}

}  // namespace prehend::report
