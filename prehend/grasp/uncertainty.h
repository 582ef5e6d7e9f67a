#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/surface/object_model.h"

namespace prehend::grasp {

/// What may be otherwise than predicted, for the robustness of grasps.
struct UncertaintyOptions {
  int samples = 16;  // >= 0, for each listed grasp; 0: robustness is not assessed
  double position_deviation =
      0.003;  // m, >= 0, standard, of the hand in the object, along each axis
  double rotation_deviation = 0.03;  // rad, >= 0, standard, about each axis
  double least_friction = 0.5;       // > 0; friction is uniform between these
  double largest_friction = 0.8;
  std::uint64_t seed = 1;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// One way in which it may be otherwise.
struct Disturbance {
  geometry::RigidTransform X_GD = geometry::RigidTransform::Identity();  // where the hand comes to
  double friction = 0;
};

/// What to tell people of a grasp whose robustness is not known: there were no samples, no time, or
/// enough better ones.
inline constexpr const char* kNotAssessed = "robustness not assessed";

/// Appends `more` to a remark.
void add_remark(const std::string& more, std::string* remark);

/// `options.samples` of them, the same for every grasp, so that grasps differ by what they are.
std::vector<Disturbance> disturbances(const UncertaintyOptions& options);

/// ObjectModel::shape_weights, of all its shapes, of all 1, also where they are all alike.
/// @throws geometry::InputError for weights that are not of these shapes, negative or not finite.
std::vector<double> shape_weights(const surface::ObjectModel& object);

/// The share of the samples [first, first + count) that held, of each of so many shapes, which take
/// turns; NaN of a shape without sample; empty when one was not assessed.
std::vector<double> shares_held(const std::vector<std::optional<bool>>& held, std::size_t first,
                                std::size_t count, std::size_t shapes);

/// The mean of those that are no NaN by their weights; none without any.
std::optional<double> mean_share(const std::vector<double>& shares,
                                 const std::vector<double>& weights);

}  // namespace prehend::grasp
