#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "prehend/grasp/known/grasp_memory.h"

namespace prehend::nodes {

/// The database of grasps behind the plans of a node: which object is known, and which of its
/// grasps was executed.
class GraspRecords {
 public:
  /// Opens or makes the file. @throws geometry::InputError as grasp::GraspDatabase.
  explicit GraspRecords(const std::filesystem::path& file) : database_(file) {}

  grasp::GraspDatabase& database() { return database_; }

  /// Where the model is a known object: which, and where it stands.
  static std::optional<grasp::PlacedObject> known(const msgs::ObjectModel& model);

  /// Remembers what was planned, for record().
  void planned(const msgs::ObjectModel& model, const msgs::GraspPlan& plan);

  /// Counts the execution of the grasp that a result is about; `hand` as the plans are stored
  /// under. In words what was recorded; empty when it was not of a known object.
  /// @throws geometry::InputError when it cannot be written, and for an unknown outcome.
  std::string record(const msgs::CycleResult& result, const std::string& hand);

 private:
  struct Plan {
    grasp::PlacedObject placed;
    std::vector<geometry::RigidTransform> X_WG;
  };

  grasp::GraspDatabase database_;
  std::map<std::uint32_t, Plan> plans_;  // the last of each object, by its id
};

}  // namespace prehend::nodes
