#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "prehend/grasp/closing/closing.h"
#include "prehend/grasp/uncertainty.h"

namespace prehend::grasp {

/// A candidate on which the hand has closed.
struct Listed {
  ClosedGrasp closed;
  std::size_t order = 0;  // of the candidate, among all
  Grasp& grasp() { return closed.grasp; }
  const Grasp& grasp() const { return closed.grasp; }
  bool is_too_wide() const { return closed.too_wide.has_value(); }
};

/// What takes longest to know of grasps. Each is asked once: who is listed again, by the order of
/// its candidate, is told what is known.
class RefinedGrasps {
 public:
  /// Fills in what Closing::refine() does, of all at once.
  void refine(const std::vector<Listed*>& listed, const Closing& closing, int threads);
  /// Why it is no grasp. @pre It was refined.
  const std::optional<Refusal>& refusal(const Listed& listed) const;

  /// Fills in the share of the disturbed trials in which a grasp holds, and on each shape. Trials
  /// take turns on the shapes, the object's first, which have these weights; what there is no time
  /// for counts for nothing. @pre They were refined.
  void assess(const std::vector<Listed*>& listed, const std::vector<const Closing*>& on_shapes,
              const std::vector<double>& weights, const std::vector<Disturbance>& disturbances,
              int threads, const std::function<bool()>& time_is_up);

 private:
  struct Robustness {
    std::vector<double> held_on_shapes;
    std::vector<Eigen::VectorXd> stops_on_shapes;
    double mean = 0;
  };
  struct Known {
    std::optional<Refusal> refusal;
    ClosedGrasp closed;
    std::optional<Robustness> robustness;
  };
  std::map<std::size_t, Known> known_;  // by Listed::order
};

}  // namespace prehend::grasp
