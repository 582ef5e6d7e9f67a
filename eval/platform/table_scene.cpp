#include "eval/platform/table_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "eval/resting_pose.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/simulation/clutter_scene.h"
#include "prehend/simulation/scene.h"

namespace prehend::eval {
namespace {

using geometry::TriangleMesh;

constexpr double kLargest = 0.3;  // m
constexpr double kGap = 0.05;     // m, between the circles round two bodies
constexpr double kReachX = 0.12;  // m, of the bodies' middles from the table's
constexpr double kReachY = 0.2;   // m
constexpr int kMostBodies = 4;
constexpr int kTries = 200;  // of a place for a body

// m, of the circle round its footprint
double radius_of(const PlacedBody& body) {
  return geometry::bounds(*body.mesh_B).sizes().head<2>().norm() / 2;
}

}  // namespace

PlacedBody resting_body(const DataSet& set) {
  PlacedBody body;
  body.name = set.name;
  body.mass = simulation::mass_of_volume(geometry::mass_properties(*set.mesh_B).volume);
  auto mesh = std::make_shared<TriangleMesh>(geometry::transformed(
      *set.mesh_B, resting_pose(*set.mesh_B, geometry::RigidTransform::Identity(), body.mass)));
  const Eigen::AlignedBox3d box = geometry::bounds(*mesh);
  for (Eigen::Vector3d& p : mesh->vertices) {
    p -= Eigen::Vector3d(box.center().x(), box.center().y(), box.min().z());
  }
  body.mesh_B = std::move(mesh);
  return body;
}

std::vector<TableScene> make_table_scenes(const std::vector<DataSet>& sets, int count,
                                          std::uint64_t seed) {
  std::vector<const DataSet*> alone;
  for (const DataSet& set : sets) {
    const bool fits = geometry::bounds(*set.mesh_B).sizes().maxCoeff() <= kLargest;
    if (fits && set.viewing.others_B.empty()) alone.push_back(&set);
  }
  if (alone.empty()) {
    throw geometry::InputError(
        "No body of the chosen groups stands alone and is at most 0.3 m large",
        "Choose other --groups or --meshes");
  }
  std::map<std::size_t, PlacedBody> known;
  std::mt19937_64 random(seed);
  const auto within = [&random](double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random);
  };
  std::vector<TableScene> scenes;
  for (int i = 0; i < count; ++i) {
    TableScene& scene = scenes.emplace_back();
    scene.name = fmt::format("scene_{:03}-seed{}", i, seed);
    std::vector<double> radii;
    const int bodies = 1 + i % kMostBodies;
    for (int b = 0; b < bodies; ++b) {
      const std::size_t which =
          std::uniform_int_distribution<std::size_t>(0, alone.size() - 1)(random);
      auto found = known.find(which);
      if (found == known.end()) found = known.emplace(which, resting_body(*alone[which])).first;
      const PlacedBody& body = found->second;
      const double radius = radius_of(body);
      for (int t = 0; t < kTries; ++t) {
        const double x = within(kReachX), y = within(kReachY);
        bool is_free = true;
        for (std::size_t k = 0; k < radii.size(); ++k) {
          const PlacedBody& other = scene.bodies[k];
          is_free = is_free && std::hypot(x - other.x, y - other.y) > radii[k] + radius + kGap;
        }
        if (!is_free) continue;
        scene.bodies.push_back({fmt::format("{}_{}", body.name, b), body.mesh_B, body.mass, x, y,
                                within(std::numbers::pi)});
        radii.push_back(radius);
        break;
      }
    }
  }
  return scenes;
}

std::filesystem::path write_scene(const TableScene& scene, const std::filesystem::path& folder) {
  make_folder(folder);
  static const Eigen::Vector3d kColors[] = {
      {0.75, 0.25, 0.2}, {0.2, 0.45, 0.75}, {0.3, 0.6, 0.3}, {0.8, 0.65, 0.2}};
  simulation::Scene written;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const PlacedBody& body = scene.bodies[i];
    simulation::SceneObject& object = written.objects.emplace_back();
    object.name = body.name;
    object.shape = "mesh";
    object.file = folder / (body.name + ".ply");
    object.mass = body.mass;
    object.x = body.x;
    object.y = body.y;
    object.yaw = body.yaw;
    object.texture.color = kColors[i % std::size(kColors)];
    object.texture.second_color = {0.9, 0.88, 0.82};
    object.texture.seed = static_cast<std::uint32_t>(i + 1);
    geometry::write_mesh_file(object.file, *body.mesh_B);
  }
  const std::filesystem::path file = folder / "scene.yaml";
  simulation::write_scene(file, written, "Made by eval_platform.");
  return file;
}

}  // namespace prehend::eval
