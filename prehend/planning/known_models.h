#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "prehend/grasp/known/known_objects.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/surface/object_model.h"

namespace prehend::planning {

/// Names of the meshes in a folder of known objects, sorted. @throws geometry::InputError naming a
/// folder that is not there.
std::vector<std::string> known_model_files(const std::filesystem::path& folder);

/// Objects of which the meshes are in a folder, to be found in what a camera sees.
class KnownModels {
 public:
  /// Reads all meshes of `folder` (.ply, .obj, .stl), by name, which may be none yet; `scale`:
  /// metres per unit of the files. Some 0.1 s for each.
  /// @throws geometry::InputError naming a folder that is not there, or the file that is no solid;
  /// std::invalid_argument as grasp::RecognitionOptions::validate().
  explicit KnownModels(const std::filesystem::path& folder, double scale = 1,
                       const grasp::RecognitionOptions& options = {});

  std::size_t size() const { return models_.size(); }

  struct Found {
    grasp::Recognition best;       // accepted, or the nearest miss with its reason
    surface::ObjectModel model_W;  // where `best.accepted`
  };
  /// Which of them `object` of `scene` is, if any. @throws as grasp::KnownObjects::recognise().
  Found recognise(const perception::SegmentedScene& scene,
                  const perception::ObjectHypothesis& object) const;

 private:
  struct Model {
    std::string hash;
    surface::ObjectModel model_O;
  };
  std::vector<Model> models_;
  grasp::KnownObjects objects_;
};

}  // namespace prehend::planning
