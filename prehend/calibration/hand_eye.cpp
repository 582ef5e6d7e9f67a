#include "prehend/calibration/hand_eye.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/hand_eye_refinement.h"
#include "prehend/calibration/hand_eye_solvers.h"
#include "prehend/calibration/view_collection.h"

namespace prehend::calibration {
namespace {

constexpr int kLeastPoses = 5;
constexpr double kLeastTurn = 0.05;             // rad, of the arm between two poses
constexpr double kLeastAxisSpread = 0.10;       // rad, of the axes of these turns
constexpr double kConsensus = 3.5;              // robust standard deviations
constexpr double kLeastLimit = 0.5;             // pixels: agrees in any case
constexpr double kMostMiddleError = 0.05;       // of the image's width: less is no agreement
constexpr double kMostOffsetDeviation = 0.002;  // rad or m
constexpr double kDegree = M_PI / 180;
constexpr const char* kCheckSetUp =
    "Check that the board stayed where it was, that images and poses belong together, and that the "
    "camera is mounted as said";

double middle_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Of one pose, in pixels; infinite where the board would be behind the camera.
double reprojection(const HandEyePose& pose, const geometry::RigidTransform& X_CT,
                    const CalibrationBoard& board, const perception::CameraCalibration& camera) {
  double sum = 0;
  for (std::size_t i = 0; i < pose.view.ids.size(); ++i) {
    const Eigen::Vector3d p = X_CT * board.corner_T(pose.view.ids[i]);
    if (!(p.z() > 1e-3)) return std::numeric_limits<double>::infinity();
    // Far outside of the image the lens' polynomial means nothing.
    const Eigen::Vector2d straight(camera.K(0, 0) * p.x() / p.z() + camera.K(0, 2),
                                   camera.K(1, 1) * p.y() / p.z() + camera.K(1, 2));
    const bool outside = straight.x() < -camera.width || straight.x() > 2 * camera.width ||
                         straight.y() < -camera.height || straight.y() > 2 * camera.height;
    const Eigen::Vector2d seen = outside ? straight : project(camera, p);
    sum += (seen - pose.view.pixels[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pose.view.ids.size()));
}

void check(const HandEyeOptions& options, const perception::CameraCalibration& camera) {
  if (!(options.pixel_noise > 0) || !(options.position_noise > 0) ||
      !(options.rotation_noise > 0)) {
    throw std::invalid_argument("noises of a hand-eye calibration must be positive");
  }
  if (options.draws < 1) throw std::invalid_argument("draws must be 1 or more");
  if (camera.distortion.size() > 12) {
    throw std::invalid_argument("a lens with a tilted sensor (14 coefficients) is not supported");
  }
}

std::vector<geometry::RigidTransform> flanges(const std::vector<HandEyePose>& poses,
                                              const std::vector<int>& chosen) {
  std::vector<geometry::RigidTransform> X_BF;
  for (const int i : chosen) X_BF.push_back(poses[static_cast<std::size_t>(i)].X_BF);
  return X_BF;
}

// The search for what most poses agree on.
class Consensus {
 public:
  Consensus(const std::vector<HandEyePose>& poses, const std::vector<int>& usable,
            const CalibrationBoard& board, const perception::CameraCalibration& camera,
            const HandEyeOptions& options)
      : poses_(poses), usable_(usable), board_(board), camera_(camera), options_(options) {
    for (const int i : usable) {
      const HandEyePose& pose = poses[static_cast<std::size_t>(i)];
      pairs_.push_back({pose.X_BF, board_pose(pose.view, board, camera)->X_CT});
    }
  }

  std::vector<double> errors(const HandEyeUnknowns& unknowns) const {
    std::vector<double> errors;
    for (const int i : usable_) {
      const HandEyePose& pose = poses_[static_cast<std::size_t>(i)];
      errors.push_back(reprojection(pose, board_in_camera(options_.mount, unknowns, pose.X_BF),
                                    board_, camera_));
    }
    return errors;
  }

  std::optional<HandEyeUnknowns> search() const {
    std::mt19937_64 random(options_.seed);
    std::optional<HandEyeUnknowns> best;
    double least = std::numeric_limits<double>::infinity();
    std::vector<std::size_t> order(pairs_.size());
    std::iota(order.begin(), order.end(), 0U);
    for (int draw = 0; draw < options_.draws; ++draw) {
      for (std::size_t i = 0; i < 3; ++i) {
        std::uniform_int_distribution<std::size_t> other(i, order.size() - 1);
        std::swap(order[i], order[other(random)]);
      }
      const auto found = solve_hand_eye("park", options_.mount,
                                        {pairs_[order[0]], pairs_[order[1]], pairs_[order[2]]});
      if (!found) continue;
      const double error = middle_of(errors(*found));
      if (error >= least) continue;
      least = error;
      best = found;
    }
    return best;
  }

  const std::vector<PosePair>& pairs() const { return pairs_; }

 private:
  const std::vector<HandEyePose>& poses_;
  const std::vector<int>& usable_;
  const CalibrationBoard& board_;
  const perception::CameraCalibration& camera_;
  const HandEyeOptions& options_;
  std::vector<PosePair> pairs_;
};

// Which of the errors are of the many: within some robust standard deviations of them.
std::vector<bool> agreeing(const std::vector<double>& errors) {
  const double limit = std::max(kLeastLimit, kConsensus * middle_of(errors));
  std::vector<bool> agree;
  for (const double error : errors) agree.push_back(error <= limit);
  return agree;
}

}  // namespace

geometry::RigidTransform board_in_camera(CameraMount mount, const HandEyeUnknowns& unknowns,
                                         const geometry::RigidTransform& X_BF) {
  return unknowns.X_PC.inverse() * (mount == CameraMount::kHand ? X_BF.inverse() : X_BF) *
         unknowns.X_QT;
}

void require_motions(const std::vector<geometry::RigidTransform>& X_BF) {
  if (static_cast<int>(X_BF.size()) < kLeastPoses) {
    throw DegenerateData("too few poses",
                         fmt::format("{} show the board, {} are needed", X_BF.size(), kLeastPoses),
                         "Take 15, turned about different axes");
  }
  // Two different axes give the scatter of all a second eigenvalue.
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double most = 0;
  for (std::size_t i = 0; i < X_BF.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Eigen::AngleAxisd turn(X_BF[k].linear().transpose() * X_BF[i].linear());
      most = std::max(most, turn.angle());
      if (turn.angle() < kLeastTurn) continue;
      scatter += turn.axis() * turn.axis().transpose();
    }
  }
  if (most < kLeastTurn) {
    throw DegenerateData(
        "pure translations",
        fmt::format("the arm turns by {:.1f} degrees at most between its poses", most / kDegree),
        "Turn the flange by 30 degrees and more between poses, about different axes");
  }
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues();
  const double spread = std::sqrt(values(1) / values(2));
  if (spread < kLeastAxisSpread) {
    throw DegenerateData(
        "rotation axes parallel",
        fmt::format("the axes of the arm's turns differ by about {:.1f} degrees",
                    std::atan(spread) / kDegree),
        "Turn the flange about two axes or more: along the parallel one nothing is determined");
  }
}

HandEyeFit calibrate_hand_eye(const std::vector<HandEyePose>& poses, const CalibrationBoard& board,
                              const perception::CameraCalibration& camera,
                              const HandEyeOptions& options) {
  check(options, camera);
  if (board.is_symmetric()) {
    throw DegenerateData(
        "board symmetric", "it looks the same upside down",
        "Use a chessboard with an odd sum of columns and rows, or one with markers");
  }
  HandEyeFit fit;
  std::vector<int> usable;
  bool found_any = false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (options.chain && poses[i].q.size() != options.chain->size()) {
      throw std::invalid_argument("joint offsets need the joints' positions at each pose");
    }
    HandEyePoseFit pose;
    pose.name = poses[i].name;
    found_any = found_any || !poses[i].view.ids.empty();
    if (!poses[i].X_BF.matrix().allFinite()) {
      pose.why_not = "the arm's pose is not finite";
    } else if (poses[i].view.ids.size() < kLeastViewCorners ||
               !board_pose(poses[i].view, board, camera)) {
      pose.why_not = poses[i].view.ids.empty() ? "board not found" : "too few corners";
    } else {
      usable.push_back(static_cast<int>(i));
    }
    fit.poses.push_back(pose);
  }
  if (!found_any) {
    throw DegenerateData("board not found", fmt::format("in none of {} images", poses.size()),
                         "Check the board's file against the board, and that it is in view");
  }
  require_motions(flanges(poses, usable));

  const Consensus consensus(poses, usable, board, camera, options);
  const std::optional<HandEyeUnknowns> rough = consensus.search();
  if (!rough) {
    throw DegenerateData("no consensus", "no three poses give an answer",
                         "Turn the flange about different axes between poses");
  }
  const double middle = middle_of(consensus.errors(*rough));
  if (!(middle < kMostMiddleError * camera.width)) {
    throw DegenerateData("no consensus",
                         fmt::format("half of the poses are {:.0f} pixels off or more", middle),
                         kCheckSetUp);
  }
  std::vector<bool> agree = agreeing(consensus.errors(*rough));

  // All solvers on what agrees; the best of them is where least squares begin.
  HandEyeUnknowns start = *rough;
  double least = std::numeric_limits<double>::infinity();
  std::vector<PosePair> pairs;
  for (std::size_t n = 0; n < usable.size(); ++n) {
    if (agree[n]) pairs.push_back(consensus.pairs()[n]);
  }
  for (const std::string& solver : hand_eye_solvers()) {
    SolverAnswer answer;
    answer.method = solver;
    if (pairs.size() >= 3) answer.unknowns = solve_hand_eye(solver, options.mount, pairs);
    if (answer.unknowns) {
      const std::vector<double> errors = consensus.errors(*answer.unknowns);
      double sum = 0;
      for (std::size_t n = 0; n < errors.size(); ++n) sum += agree[n] ? errors[n] * errors[n] : 0;
      answer.rms = std::sqrt(sum / static_cast<double>(pairs.size()));
      if (answer.rms < least) {
        least = answer.rms;
        start = *answer.unknowns;
      }
    }
    fit.solvers.push_back(answer);
  }

  // Refined, and again as long as the poses that agree change.
  HandEyeRefinement refined;
  std::vector<int> chosen;
  for (int round = 0; round < 6; ++round) {
    chosen.clear();
    for (std::size_t n = 0; n < usable.size(); ++n) {
      if (agree[n]) chosen.push_back(usable[n]);
    }
    if (2 * chosen.size() < usable.size() || static_cast<int>(chosen.size()) < kLeastPoses) {
      throw DegenerateData("no consensus",
                           fmt::format("only {} of {} poses agree", chosen.size(), usable.size()),
                           kCheckSetUp);
    }
    require_motions(flanges(poses, chosen));
    refined = refine_hand_eye(poses, chosen, start, board, camera, options);
    std::vector<double> errors;
    for (const int i : usable) {
      const HandEyePose& pose = poses[static_cast<std::size_t>(i)];
      errors.push_back(reprojection(
          pose,
          board_in_camera(options.mount, refined.unknowns, refined.flange(pose, options.chain)),
          board, camera));
    }
    const std::vector<bool> now = agreeing(errors);
    start = refined.unknowns;
    if (now == agree) break;
    agree = now;
  }

  fit.unknowns = refined.unknowns;
  fit.position_deviation = refined.position_deviation;
  fit.rotation_deviation = refined.rotation_deviation;
  double sum = 0;
  for (std::size_t n = 0; n < usable.size(); ++n) {
    const HandEyePose& pose = poses[static_cast<std::size_t>(usable[n])];
    HandEyePoseFit& of = fit.poses[static_cast<std::size_t>(usable[n])];
    of.used = std::count(chosen.begin(), chosen.end(), usable[n]) > 0;
    const geometry::RigidTransform X_CT =
        board_in_camera(options.mount, fit.unknowns, refined.flange(pose, options.chain));
    of.rms = reprojection(pose, X_CT, board, camera);
    const geometry::RigidTransform& seen = consensus.pairs()[n].X_CT;
    const Eigen::Vector3d center(0.5 * board.size().x(), 0.5 * board.size().y(), 0);
    of.position_error = (seen * center - X_CT * center).norm();
    of.rotation_error = Eigen::AngleAxisd(X_CT.linear().transpose() * seen.linear()).angle();
    if (of.used) {
      sum += of.rms * of.rms;
    } else {
      of.why_not = fmt::format("does not agree: the board is {:.1f} mm and {:.2f} degrees off",
                               1e3 * of.position_error, of.rotation_error / kDegree);
    }
  }
  fit.rms = std::sqrt(sum / static_cast<double>(chosen.size()));
  if (options.chain) {
    for (int j = 0; j < options.chain->size(); ++j) {
      JointOffset offset;
      offset.joint = options.chain->joints()[static_cast<std::size_t>(j)].name;
      offset.is_free = j > 0 && j + 1 < options.chain->size();
      offset.offset = refined.offsets[j];
      offset.deviation = refined.offset_deviations[j];
      if (offset.is_free && !(offset.deviation < kMostOffsetDeviation)) {
        throw DegenerateData("joint offsets not determined",
                             fmt::format("that of joint '{}' has a standard deviation of {:.3g}",
                                         offset.joint, offset.deviation),
                             "Take more poses in which all joints differ much");
      }
      fit.offsets.push_back(offset);
    }
  }
  return fit;
}

}  // namespace prehend::calibration
