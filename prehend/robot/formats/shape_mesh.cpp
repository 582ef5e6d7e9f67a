#include "prehend/robot/formats/shape_mesh.h"

#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/robot/formats/inventor_mesh.h"
#include "prehend/robot/mesh_shape.h"

namespace prehend::robot::formats {
namespace {

namespace fs = std::filesystem;

geometry::TriangleMesh capsule(double radius, double length) {
  constexpr int kRings = 8;  // of each half ball
  std::vector<Eigen::Vector2d> profile;
  for (int half : {-1, 1}) {
    for (int i = 0; i <= kRings; ++i) {
      const double angle = half * std::numbers::pi / 2 * (half < 0 ? kRings - i : i) / kRings;
      const bool is_pole = (half < 0 && i == 0) || (half > 0 && i == kRings);
      profile.emplace_back(is_pole ? 0 : radius * std::cos(angle),
                           half * length / 2 + radius * std::sin(angle));
    }
  }
  return geometry::make_revolution(profile, 24);
}

bool has_file(const Shape& shape) { return shape.kind == Shape::Kind::kMesh && !shape.surface; }

/// Shapes of one file have one mesh.
void load_meshes(RobotDescription& robot, ShapeMeshes& meshes, LossReport& loss) {
  std::map<std::string, std::shared_ptr<const geometry::TriangleMesh>> loaded;
  for (LinkDescription& link : robot.links) {
    for (auto* shapes : {&link.visuals, &link.collisions}) {
      for (Shape& shape : *shapes) {
        if (!has_file(shape)) continue;
        auto& mesh = loaded[shape.mesh];
        if (!mesh) {
          try {
            mesh = std::make_shared<const geometry::TriangleMesh>(meshes.read(shape.mesh));
          } catch (const geometry::InputError& error) {
            loss.drop("link '" + link.name + "'", "mesh '" + shape.mesh + "'", error.problem());
            continue;
          }
          const std::string ending = fs::path(shape.mesh).extension().string();
          if (ending != ".stl" && ending != ".STL") {  // which have none
            loss.approximate("link '" + link.name + "'", "mesh '" + shape.mesh + "'",
                             "its surface, without colours and textures of its own");
          }
        }
        shape.surface = mesh;
      }
    }
  }
}

/// A file's name of words that may have any sign in them.
std::string plain(const std::string& words) {
  std::string name;
  for (const char c : words) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    name += is_plain ? c : '_';
  }
  return name.empty() ? "mesh" : name.substr(0, 80);
}

}  // namespace

bool has_no_size(const Shape& shape) {
  switch (shape.kind) {
    case Shape::Kind::kBox:
      return !(shape.size.minCoeff() > 0);
    case Shape::Kind::kSphere:
      return !(shape.radius > 0);
    case Shape::Kind::kCylinder:
      return !(shape.radius > 0 && shape.length > 0);
    case Shape::Kind::kCapsule:
      return !(shape.radius > 0 && shape.length >= 0);
    default:
      return false;
  }
}

geometry::TriangleMesh ShapeMeshes::of(const Shape& shape) {
  if (has_no_size(shape)) {
    throw geometry::InputError("a shape of the robot has no size", "Give it one, above 0 m");
  }
  switch (shape.kind) {
    case Shape::Kind::kBox:
      return geometry::make_box(shape.size);
    case Shape::Kind::kSphere:
      return geometry::make_sphere(shape.radius, 24);
    case Shape::Kind::kCylinder:
      return geometry::make_revolution(
          {{shape.radius, -shape.length / 2}, {shape.radius, shape.length / 2}}, 32);
    case Shape::Kind::kCapsule:
      return capsule(shape.radius, shape.length);
    case Shape::Kind::kPlane:
      return {};
    case Shape::Kind::kMesh:
      break;
  }
  geometry::TriangleMesh mesh = shape.surface ? *shape.surface : read(shape.mesh);
  for (Eigen::Vector3d& p : mesh.vertices) p = p.cwiseProduct(shape.scale);
  if (shape.scale.prod() < 0) {
    for (Eigen::Vector3i& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

const geometry::TriangleMesh& ShapeMeshes::read(const std::string& name) {
  const fs::path file = find_mesh_file(name, folder_);
  // However it is called: ./a.stl is a.stl.
  std::error_code error;
  const std::string key = fs::weakly_canonical(file, error).string();
  const auto known = read_.find(key);
  if (known != read_.end()) return known->second;
  return read_
      .emplace(key,
               is_inventor_file(file) ? read_inventor_mesh(file) : geometry::read_mesh_file(file))
      .first->second;
}

std::vector<MeshFile> take_out_meshes(RobotDescription& robot, const fs::path& from,
                                      const std::string& name, LossReport& loss,
                                      TakenMeshes taken) {
  std::vector<MeshFile> result;
  ShapeMeshes meshes(from);
  const std::string folder = plain(name) + "_meshes";
  std::set<std::string> used;
  if (taken == TakenMeshes::kEmbedded) {
    load_meshes(robot, meshes, loss);
    return result;
  }
  std::map<std::pair<std::string, const void*>, std::string> written;
  for (LinkDescription& link : robot.links) {
    for (auto* shapes : {&link.visuals, &link.collisions}) {
      for (Shape& shape : *shapes) {
        if (shape.kind != Shape::Kind::kMesh) continue;
        if (taken == TakenMeshes::kForeign && has_file(shape) && !is_inventor_file(shape.mesh)) {
          continue;
        }
        const std::string place = "link '" + link.name + "'";
        auto& file = written[{shape.mesh, shape.surface.get()}];
        if (file.empty()) {
          geometry::TriangleMesh mesh;
          try {
            mesh = shape.surface ? *shape.surface : meshes.read(shape.mesh);
          } catch (const geometry::InputError& error) {
            loss.drop(place, "mesh '" + shape.mesh + "'", error.problem());
            written.erase({shape.mesh, shape.surface.get()});
            continue;
          }
          const std::string stem =
              plain(has_file(shape) ? fs::path(shape.mesh).stem().string() : shape.mesh);
          std::string one = stem;
          for (int i = 2; !used.insert(one).second; ++i) one = fmt::format("{}_{}", stem, i);
          file = folder + "/" + one + ".stl";
          result.push_back({file, std::move(mesh)});
          loss.approximate(place, has_file(shape) ? "mesh '" + shape.mesh + "'" : "mesh within it",
                           "written as STL, without colours");
        }
        shape.mesh = file;
        shape.surface.reset();
      }
    }
  }
  return result;
}

void write_meshes(const std::vector<MeshFile>& meshes, const fs::path& folder) {
  for (const MeshFile& one : meshes) {
    std::error_code ignored;  // the file that cannot be written says it
    fs::create_directories((folder / one.file).parent_path(), ignored);
    geometry::write_mesh_file(folder / one.file, one.mesh);
  }
}

}  // namespace prehend::robot::formats
