#pragma once

#include <optional>

#include <Eigen/Core>

namespace prehend::grasp {

/// The x >= 0 that makes `objective`' x largest subject to `equal` x = `right` and `below` x <=
/// `most`; none when no x fulfils these, or none is best. GLPK's simplex method, in rational
/// arithmetic where rounding makes that one fail. For some ten rows and some fifty columns.
/// Reentrant (GLPK's state is of the thread).
/// @throws std::invalid_argument for sizes that do not fit or numbers that are not finite.
struct DenseProgramme {
  Eigen::VectorXd objective;  // n
  Eigen::MatrixXd equal;      // p x n
  Eigen::VectorXd right;      // p
  Eigen::MatrixXd below;      // q x n
  Eigen::VectorXd most;       // q

  std::optional<Eigen::VectorXd> maximise() const;
};

}  // namespace prehend::grasp
