#include "prehend/planning/known_models.h"

#include <algorithm>
#include <cctype>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/grasp/known/grasp_database.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> mesh_files_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (entry.path().filename().string().starts_with(".")) continue;  // not yet whole
    if (ending == ".ply" || ending == ".obj" || ending == ".stl") files.push_back(entry.path());
  }
  if (error) {
    throw geometry::InputError("'" + folder.string() + "' has no meshes: " + error.message(),
                               "Name a folder with .ply, .obj or .stl files of the known objects");
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

KnownModels::KnownModels(const fs::path& folder, double scale,
                         const grasp::RecognitionOptions& options)
    : objects_(options) {
  for (const fs::path& file : mesh_files_of(folder)) {
    geometry::TriangleMesh mesh_O = geometry::read_mesh_file(file, scale);
    try {
      objects_.add(file.stem().string(), mesh_O);
      std::string hash = grasp::content_hash(mesh_O);
      models_.push_back({std::move(hash), surface::model_of_mesh(std::move(mesh_O))});
    } catch (const std::exception& problem) {
      throw geometry::InputError(
          "'" + file.string() + "' cannot be a known object: " + problem.what(),
          "Or take it out of the folder");
    }
  }
}

std::vector<std::string> known_model_files(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::path& file : mesh_files_of(folder)) names.push_back(file.filename().string());
  return names;
}

KnownModels::Found KnownModels::recognise(const perception::SegmentedScene& scene,
                                          const perception::ObjectHypothesis& object) const {
  if (models_.empty()) {
    Found none;
    none.best.reason = "no object is known yet";
    return none;
  }
  const auto all =
      objects_.recognise({object.cloud_W, scene.camera, scene.X_WC, scene.depth, scene.table_W});
  Found found{all.front(), {}};
  if (!found.best.accepted) return found;
  const auto model = std::find_if(models_.begin(), models_.end(),
                                  [&](const Model& m) { return m.hash == found.best.hash; });
  found.model_W = surface::moved(model->model_O, found.best.X_WO);
  return found;
}

}  // namespace prehend::planning
