#include "prehend/control/balance.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/SVD>

namespace prehend::control {
namespace {

constexpr double kAtEnd = 0.02;      // rad or m, from where a motor was sent: nothing stopped it
constexpr double kLeastShare = 0.3;  // of the largest singular value: what fingers tell less of,
                                     // as those that are nearly parallel, counts as not told
constexpr double kLeastWay = 0.005;  // m for each rad of closing: a fingertip that closes

}  // namespace

Eigen::Vector3d displacement_felt(const Eigen::VectorXd& closing_rate,
                                  const Eigen::VectorXd& predicted, const Eigen::VectorXd& stopped,
                                  const Eigen::VectorXd& sent,
                                  const robot::FingertipWays& fingertips) {
  // Of one finger: how it closes [m for each rad], and how far it has gone beyond the prediction.
  struct Felt {
    Eigen::Vector3d closes = Eigen::Vector3d::Zero(), beyond = Eigen::Vector3d::Zero();
    bool stopped = false;
  };
  std::map<int, Felt> fingers;
  for (Eigen::Index i = 0; i < stopped.size(); ++i) {
    const int finger = fingertips.finger[static_cast<std::size_t>(i)];
    if (finger < 0 || closing_rate[i] == 0) continue;
    Felt& felt = fingers[finger];
    felt.closes += closing_rate[i] * fingertips.ways.col(i);
    felt.beyond += (stopped[i] - predicted[i]) * fingertips.ways.col(i);
    felt.stopped = felt.stopped || std::abs(stopped[i] - sent[i]) > kAtEnd;
  }
  // Rows: way beyond, along how it closes = that direction . displacement + common advance.
  Eigen::MatrixX4d equations(fingers.size(), 4);
  Eigen::VectorXd ways(fingers.size());
  Eigen::Index rows = 0;
  for (const auto& [finger, felt] : fingers) {
    if (!felt.stopped || felt.closes.norm() < kLeastWay) continue;
    const Eigen::Vector3d direction = felt.closes.normalized();
    equations.row(rows) << direction.transpose(), 1;
    ways[rows++] = direction.dot(felt.beyond);
  }
  if (rows < 2) return Eigen::Vector3d::Zero();
  Eigen::JacobiSVD<Eigen::MatrixXd> decomposition(equations.topRows(rows),
                                                  Eigen::ComputeThinU | Eigen::ComputeThinV);
  decomposition.setThreshold(kLeastShare);
  return decomposition.solve(ways.head(rows)).head<3>();
}

FollowedShift followed(const Eigen::Vector3d& displacement_W,
                       const std::vector<HandShift>& shifts) {
  FollowedShift result;
  for (const HandShift& shift : shifts) {
    const double length = shift.way_W.norm();
    if (length <= 0) continue;
    const double share = std::clamp(displacement_W.dot(shift.way_W) / (length * length), 0.0, 1.0);
    if (share <= 0) continue;
    result.way_W += share * shift.way_W;
    result.offsets.resize(shift.offsets.size());
    for (std::size_t k = 0; k < shift.offsets.size(); ++k) {
      result.offsets[k] += share * shift.offsets[k];
    }
  }
  return result;
}

}  // namespace prehend::control
