#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/household_objects.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/world.h"

namespace prehend::eval {

/// One object in one resting pose: what the paper calls a data set (8 orientations each).
struct DataSet {
  std::string group;  // "household", "scanned" or the folder's name
  std::string name;   // the object's, with "_lying"
  std::shared_ptr<const geometry::TriangleMesh> mesh_B;  // resting on z = 0
  bool symmetric = true;
};

/// One stereo pair of the evaluation.
struct Case {
  const DataSet* data_set = nullptr;
  int orientation = 0;     // degrees, turn about the vertical
  std::uint64_t seed = 1;  // of texture and noise

  /// Unique and fit for a file name.
  std::string name() const;
  /// Pose of the object in the world: turned by the orientation at the table's centre.
  geometry::RigidTransform X_WB() const;
};

/// The objects of a group, each standing and those marked so also lying.
std::vector<DataSet> make_data_sets(const std::string& group,
                                    const std::vector<EvaluationObject>& objects);

/// Every data set in `orientations` equal steps of the full turn from 0.
std::vector<Case> make_cases(const std::vector<DataSet>& data_sets, int orientations,
                             std::uint64_t seed);

/// What differs between renderings of the same body.
struct Appearance {
  double texture_contrast = 0.35;  // of the fine noise on the body, 0..1
  double image_noise = 2;          // grey levels
  double ambient = 0.45;           // 0..1 of the light
};

/// The scene (default camera, table, light) and the body that render_stereo() takes for a case. The
/// colours and the pattern follow from the data set's name.
struct RenderedScene {
  simulation::Scene scene;
  std::vector<simulation::VisibleBody> bodies;
};
RenderedScene scene_of(const Case& one, const Appearance& appearance = {});

}  // namespace prehend::eval
