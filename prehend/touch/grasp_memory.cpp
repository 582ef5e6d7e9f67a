#include "prehend/touch/grasp_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "prehend/touch/pad_touch.h"

namespace prehend::touch {
namespace {

constexpr int kOfPad = 9;
using PadFeatures = Eigen::Matrix<double, kOfPad, 1>;

constexpr double kFarthest = 4;      // times `usual_`: beyond it a grasp says no more
constexpr double kMargin = 1.5;      // of a question's grasps over the own ones
constexpr double kOwnShare = 0.95;   // of own grasps that are within, without the margin
constexpr double kLeastUnit = 0.02;  // of a feature's spread over all grasps: some hardly differ
constexpr int kWeighings = 4;        // of finding the nearest and weighing anew

PadFeatures pad_features(const FeltFrame& frame, const PadTouch& touch) {
  const FeltTexels felt = felt_texels(*frame.pad, frame.counts);
  const contact::PadLayout& layout = frame.pad->layout;
  Eigen::Vector2d square = Eigen::Vector2d::Zero();
  double high = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    high = std::max(high, layout.y[i]);
    if (felt.force[i] <= 0) continue;
    const Eigen::Vector2d d = layout.position(i).head<2>() - touch.center->head<2>();
    square += d.cwiseProduct(d) * (layout.area(i) / touch.area);
  }
  PadFeatures f;
  f << std::sqrt(touch.area), std::sqrt(square.x()), std::sqrt(square.y()),
      high - touch.center->y(), touch.largest_pressure * touch.area / touch.force, 0, 0, 0, 0;
  if (touch.curvature) f.segment<2>(5) << touch.curvature->largest, touch.curvature->smallest;
  if (touch.normal) {
    f.tail<2>() << std::abs(touch.normal->direction.x()), touch.normal->direction.y();
  }
  return f;
}

}  // namespace

Eigen::VectorXd grasp_features(const Eigen::VectorXd& posture,
                               const std::vector<FeltFrame>& frames) {
  std::vector<PadFeatures> pads;
  for (const FeltFrame& frame : frames) {
    const PadTouch touch = pad_touch(*frame.pad, frame.counts);
    if (touch.touched > 0) pads.push_back(pad_features(frame, touch));
  }
  if (pads.empty()) return {};
  PadFeatures mean = PadFeatures::Zero(), low = pads[0], high = pads[0];
  for (const PadFeatures& pad : pads) {
    mean += pad / static_cast<double>(pads.size());
    low = low.cwiseMin(pad);
    high = high.cwiseMax(pad);
  }
  Eigen::VectorXd all(posture.size() + 2 * kOfPad);
  all << posture, mean, high - low;
  return all;
}

void GraspMemory::teach(const std::string& name, const std::vector<Eigen::VectorXd>& grasps) {
  if (grasps.empty()) throw std::invalid_argument("GraspMemory: '" + name + "' without a grasp");
  for (const Eigen::VectorXd& grasp : grasps) {
    const Eigen::Index size = things_.empty() ? grasps[0].size() : unit_.size();
    if (grasp.size() != size || size == 0 || !grasp.allFinite()) {
      throw std::invalid_argument("GraspMemory: a grasp of '" + name +
                                  "' has other features than those that are known");
    }
  }
  things_[name] = grasps;
  weigh();
}

bool GraspMemory::forget(const std::string& name) {
  const bool was_known = things_.erase(name) > 0;
  if (was_known) weigh();
  return was_known;
}

double GraspMemory::squared_distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  return (a - b).cwiseQuotient(unit_).squaredNorm() / static_cast<double>(unit_.size());
}

double GraspMemory::nearest(const Eigen::VectorXd& grasp,
                            const std::vector<Eigen::VectorXd>& grasps,
                            const Eigen::VectorXd* except) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::VectorXd& other : grasps) {
    if (&other != except) least = std::min(least, squared_distance(grasp, other));
  }
  return least;
}

void GraspMemory::weigh() {
  if (things_.empty()) return;
  const Eigen::Index size = things_.begin()->second.front().size();
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(size), square = mean;
  double count = 0;
  for (const auto& [name, grasps] : things_) {
    for (const Eigen::VectorXd& grasp : grasps) {
      mean += grasp;
      square += grasp.cwiseAbs2();
      ++count;
    }
  }
  mean /= count;
  const Eigen::VectorXd spread =
      (square / count - mean.cwiseAbs2()).cwiseMax(0).cwiseSqrt().array() + 1e-12;
  unit_ = spread;
  std::vector<double> distances;
  for (int round = 0; round < kWeighings; ++round) {
    Eigen::VectorXd changed = Eigen::VectorXd::Zero(size);
    distances.clear();
    for (const auto& [name, grasps] : things_) {
      for (const Eigen::VectorXd& grasp : grasps) {
        const Eigen::VectorXd* most_alike = nullptr;
        double least = std::numeric_limits<double>::infinity();
        for (const Eigen::VectorXd& other : grasps) {
          if (&other == &grasp) continue;
          const double distance = squared_distance(grasp, other);
          if (distance < least) {
            least = distance;
            most_alike = &other;
          }
        }
        if (!most_alike) continue;
        changed += (grasp - *most_alike).cwiseAbs2();
        distances.push_back(least);
      }
    }
    if (distances.empty()) return;  // one grasp of each: nothing is known of how they repeat
    unit_ =
        (changed / static_cast<double>(distances.size())).cwiseSqrt().cwiseMax(kLeastUnit * spread);
  }
  const auto at = distances.begin() + static_cast<std::ptrdiff_t>(
                                          kOwnShare * static_cast<double>(distances.size() - 1));
  std::nth_element(distances.begin(), at, distances.end());
  usual_ = std::max(kMargin * *at, 1e-12);
}

Recognised GraspMemory::ask(const std::vector<Eigen::VectorXd>& grasps) const {
  if (grasps.empty()) throw std::invalid_argument("GraspMemory: asked without a grasp");
  Recognised answer;
  if (things_.empty()) {
    answer.reason = "nothing was taught";
    return answer;
  }
  for (const Eigen::VectorXd& grasp : grasps) {
    if (grasp.size() != unit_.size()) {
      throw std::invalid_argument("GraspMemory: asked about other features than those known");
    }
  }
  for (const auto& [name, known] : things_) {
    double sum = 0;
    for (const Eigen::VectorXd& grasp : grasps) {
      sum += std::min(kFarthest, nearest(grasp, known) / usual_);
    }
    answer.candidates.push_back({name, sum / static_cast<double>(grasps.size())});
  }
  std::stable_sort(answer.candidates.begin(), answer.candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.misfit < b.misfit; });
  const Candidate& best = answer.candidates.front();
  if (best.misfit <= 1) {
    answer.name = best.name;
  } else {
    answer.reason = fmt::format("it is likest '{}', but fits {:.1f} times worse than it may",
                                best.name, best.misfit);
  }
  return answer;
}

}  // namespace prehend::touch
