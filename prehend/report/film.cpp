#include "prehend/report/film.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/report/base64.h"
#include "prehend/text/json.h"
#include "prehend/text/require.h"
#include "prehend/text/tree_file.h"

namespace prehend::report {
namespace {

using text::Json;

template <class Number>
std::string packed(const std::vector<Number>& numbers) {
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

std::string vertices_of(const geometry::TriangleMesh& mesh) {
  std::vector<float> numbers;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    for (int k = 0; k < 3; ++k) numbers.push_back(static_cast<float>(p[k]));
  }
  return packed(numbers);
}

std::string triangles_of(const geometry::TriangleMesh& mesh) {
  std::vector<std::uint32_t> numbers;
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    for (int k = 0; k < 3; ++k) numbers.push_back(static_cast<std::uint32_t>(corners[k]));
  }
  return packed(numbers);
}

std::string poses_of(const std::vector<geometry::RigidTransform>& poses) {
  std::vector<float> numbers;
  for (const geometry::RigidTransform& X : poses) {
    const Eigen::Quaterniond q(X.linear());
    for (int k = 0; k < 3; ++k) numbers.push_back(static_cast<float>(X.translation()[k]));
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) {
      numbers.push_back(static_cast<float>(part));
    }
  }
  return packed(numbers);
}

void check(const Film& film) {
  const text::Require require{"Film: "};
  require(!film.times.empty() && !film.bodies.empty(), "there must be frames and bodies");
  require(film.captions.size() == film.times.size(), "each frame needs a caption");
  for (std::size_t i = 0; i < film.times.size(); ++i) {
    require(std::isfinite(film.times[i]) && (i == 0 || film.times[i] > film.times[i - 1]),
            "times must increase");
  }
  for (const FilmBody& body : film.bodies) {
    const std::string name = "body '" + body.name + "': ";
    require(body.X_WB.size() == 1 || body.X_WB.size() == film.times.size(),
            name + "it needs one pose, or one for each frame");
    require(body.opacity > 0 && body.opacity <= 1, name + "opacity must be above 0, at most 1");
    for (const auto& X : body.X_WB) require(X.matrix().allFinite(), name + "a pose is not finite");
    const auto vertices = static_cast<int>(body.mesh_B.vertices.size());
    for (const auto& p : body.mesh_B.vertices) {
      require(p.allFinite(), name + "a vertex is not finite");
    }
    for (const Eigen::Vector3i& corners : body.mesh_B.triangles) {
      require(corners.minCoeff() >= 0 && corners.maxCoeff() < vertices,
              name + "a triangle has no such corner");
    }
  }
}

}  // namespace

std::string film_json(const Film& film) {
  check(film);
  Json times = Json::array(), bodies = Json::array();
  for (const double time : film.times) times.add(time);
  for (const FilmBody& body : film.bodies) {
    const geometry::TriangleMesh mesh = compact(body.mesh_B);
    Json one = Json::object();
    one.set("name", body.name);
    one.set("color",
            fmt::format("#{:02x}{:02x}{:02x}", body.color[0], body.color[1], body.color[2]));
    one.set("opacity", body.opacity);
    one.set("vertices", vertices_of(mesh));
    one.set("triangles", triangles_of(mesh));
    one.set("poses", poses_of(body.X_WB));
    bodies.add(one);
  }
  Json all = Json::object();
  all.set("times", times);
  all.set("captions", Json(film.captions));
  all.set("bodies", bodies);
  // Only texts can have one; in a page it might end the script that it stands in.
  std::string out;
  for (const char c : all.text()) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

std::string film_program() {
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
