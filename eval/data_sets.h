#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "eval/evaluation_object.h"
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
  Viewing viewing;
  std::uint32_t content = 0;  // of mesh and viewing: changes with them
};

/// One stereo pair of the evaluation.
struct Case {
  const DataSet* data_set = nullptr;
  int orientation = 0;     // degrees, turn about the vertical
  std::uint64_t seed = 1;  // of texture and noise

  /// Unique and fit for a file name.
  std::string name() const;
  /// The same for a file with its result, which another mesh or viewing of that name has not.
  std::string result_name() const;
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

/// The scene (default table and light, camera as the viewing says) and the bodies that
/// render_stereo() takes for a case. Colours and patterns follow from the data set's name, unless
/// the viewing has its own.
struct RenderedScene {
  simulation::Scene scene;
  std::vector<simulation::VisibleBody> bodies;  // the case's first
  DepthSensor sensor = DepthSensor::kStereo;
  double missing = 0;  // part of the first body without depth
};
RenderedScene scene_of(const Case& one, const Appearance& appearance = {});

}  // namespace prehend::eval
