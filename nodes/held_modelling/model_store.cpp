#include "nodes/held_modelling/model_store.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/rotation_between.h"

namespace prehend::nodes {
namespace {

namespace fs = std::filesystem;

constexpr int kMostNames = 100000;

fs::path free_name(const fs::path& folder) {
  for (int i = 1; i < kMostNames; ++i) {
    const fs::path file = folder / fmt::format("object-{}.ply", i);
    if (!fs::exists(file)) return file;
  }
  throw geometry::InputError("'" + folder.string() + "' is full of objects without a name",
                             "Give them names, or name another folder");
}

// Upright as it stood, on the plane z = 0 of its frame, its middle over the origin.
geometry::RigidTransform X_OW_of(const geometry::TriangleMesh& mesh_W,
                                 const geometry::Plane& table_W) {
  geometry::RigidTransform upright = geometry::RigidTransform::Identity();
  upright.linear() =
      geometry::rotation_between(table_W.normal, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::AlignedBox3d box = geometry::bounds(geometry::transformed(mesh_W, upright));
  geometry::RigidTransform X_OW = upright;
  X_OW.translation() = -Eigen::Vector3d(box.center().x(), box.center().y(), box.min().z());
  return X_OW;
}

}  // namespace

ModelStore::ModelStore(fs::path folder, const fs::path& database) : folder_(std::move(folder)) {
  std::error_code problem;
  fs::create_directories(folder_, problem);
  if (!fs::is_directory(folder_)) {
    throw geometry::InputError("The folder '" + folder_.string() +
                                   "' of known objects cannot be made" +
                                   (problem ? ": " + problem.message() : ""),
                               "Name one that can be written");
  }
  if (!database.empty()) database_.emplace(database);
}

fs::path ModelStore::store(const geometry::TriangleMesh& mesh_W, const geometry::Plane& table_W,
                           const std::string& hand, std::vector<Grasp> grasps) {
  const geometry::RigidTransform X_OW = X_OW_of(mesh_W, table_W);
  const fs::path file = free_name(folder_);
  // Whole or not there: whoever reads the folder meanwhile does not read half of it.
  const fs::path whole = folder_ / fmt::format(".{}.part.ply", file.stem().string());
  geometry::write_mesh_file(whole, geometry::transformed(mesh_W, X_OW));
  std::error_code problem;
  fs::rename(whole, file, problem);
  if (problem) {
    throw geometry::InputError("'" + file.string() + "' cannot be written: " + problem.message(),
                               "Look at the folder's permissions");
  }
  if (!database_) return file;
  std::vector<grasp::StoredGrasp> stored;
  for (Grasp& one : grasps) {
    one.stored.X_OG = X_OW * one.X_WG;
    stored.push_back(std::move(one.stored));
  }
  // By what is read again: files keep vertices in single precision.
  database_->add(hand, grasp::content_hash(geometry::read_mesh_file(file)), file.stem().string(),
                 stored);
  return file;
}

}  // namespace prehend::nodes
