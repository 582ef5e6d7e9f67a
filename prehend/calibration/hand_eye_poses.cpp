#include "prehend/calibration/hand_eye_poses.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "prehend/calibration/hand_eye_refinement.h"
#include "prehend/geometry/errors.h"
#include "prehend/motion/plan_path.h"
#include "prehend/motion/rrt_connect.h"
#include "prehend/robot/inverse_kinematics.h"

namespace prehend::calibration {
namespace {

constexpr double kPriorRotation = 0.2;  // rad, of the guess
constexpr double kPriorPosition = 0.1;  // m
constexpr double kPriorOffset = 0.05;   // rad or m
constexpr double kEdge = 8;             // pixels between the board and the image's edge
constexpr int kTriesPerCandidate = 100;

struct Candidate {
  robot::Positions q;
  geometry::RigidTransform X_BF = geometry::RigidTransform::Identity();
  Eigen::MatrixXd information;
};

Eigen::MatrixXd prior_information(const HandEyeOptions& options) {
  const int offsets = options.chain ? std::max(0, options.chain->size() - 2) : 0;
  Eigen::VectorXd deviations = Eigen::VectorXd::Constant(12 + offsets, kPriorOffset);
  for (const int first : {0, 6}) {
    deviations.segment<3>(first).setConstant(kPriorRotation);
    deviations.segment<3>(first + 3).setConstant(kPriorPosition);
  }
  return deviations.cwiseAbs2().cwiseInverse().asDiagonal();
}

double log_det(const Eigen::MatrixXd& matrix) {
  return 2 * matrix.llt().matrixL().toDenseMatrix().diagonal().array().log().sum();
}

HandEyePose as_pose(const geometry::RigidTransform& X_BF, const robot::Positions& q,
                    const CalibrationBoard& board) {
  HandEyePose pose;
  pose.X_BF = X_BF;
  pose.q = q;
  for (int id = 0; id < board.corners(); ++id) {
    pose.view.ids.push_back(id);
    pose.view.pixels.emplace_back(0, 0);
  }
  return pose;
}

void check(const PoseChoiceOptions& options) {
  if (options.poses < 5 || options.candidates < options.poses) {
    throw std::invalid_argument("choose 5 poses or more, from as many candidates or more");
  }
  if (!(options.most_tilt >= 0 && options.most_tilt <= 1.2)) {
    throw std::invalid_argument("most_tilt must be within 0 and 1.2 rad");
  }
  if (!(options.least_fill > 0 && options.least_fill <= options.most_fill &&
        options.most_fill <= 1)) {
    throw std::invalid_argument("fills must be 0 < least <= most <= 1");
  }
}

// All of the board's outline within the image.
bool is_seen(const geometry::RigidTransform& X_CT, const CalibrationBoard& board,
             const perception::CameraCalibration& camera) {
  const Eigen::Vector2d size = board.size();
  for (const double x : {0.0, 0.5, 1.0}) {
    for (const double y : {0.0, 0.5, 1.0}) {
      const Eigen::Vector3d p = X_CT * Eigen::Vector3d(x * size.x(), y * size.y(), 0);
      if (!(p.z() > 0.02)) return false;
      const Eigen::Vector2d straight(camera.K(0, 0) * p.x() / p.z() + camera.K(0, 2),
                                     camera.K(1, 1) * p.y() / p.z() + camera.K(1, 2));
      const Eigen::Vector2d pixel = project(camera, p);
      for (const Eigen::Vector2d& one : {straight, pixel}) {
        if (!(one.x() > kEdge && one.y() > kEdge && one.x() < camera.width - 1 - kEdge &&
              one.y() < camera.height - 1 - kEdge)) {
          return false;
        }
      }
    }
  }
  return true;
}

class Candidates {
 public:
  Candidates(const robot::KinematicChain& chain, const motion::FreeSpace& space,
             const robot::Positions& start, const HandEyeUnknowns& guess,
             const CalibrationBoard& board, const perception::CameraCalibration& camera,
             const PoseChoiceOptions& options)
      : inverse_(chain),
        space_(space),
        start_(start),
        guess_(guess),
        board_(board),
        camera_(camera),
        options_(options),
        random_(options.seed) {}

  std::vector<Candidate> draw() {
    std::vector<Candidate> found;
    const int most = options_.candidates * kTriesPerCandidate;
    while (static_cast<int>(found.size()) < options_.candidates && tried_ < most) {
      ++tried_;
      const geometry::RigidTransform X_CT = look();
      if (!is_seen(X_CT, board_, camera_)) {
        ++unseen_;
        continue;
      }
      // Where the flange must be for the board to stand there in the camera.
      const geometry::RigidTransform around = guess_.X_PC * X_CT * guess_.X_QT.inverse();
      Candidate one;
      one.X_BF = options_.hand_eye.mount == CameraMount::kHand ? around.inverse() : around;
      const robot::InverseAnswer answer = inverse_.solve(one.X_BF, start_);
      if (answer.solutions.empty()) {
        ++unreached_;
        continue;
      }
      const auto free = std::find_if(answer.solutions.begin(), answer.solutions.end(),
                                     [&](const auto& q) { return space_.is_free(q); });
      if (free == answer.solutions.end()) {
        ++touching_;
        continue;
      }
      one.q = *free;
      one.information = pose_information(as_pose(one.X_BF, one.q, board_), guess_, board_, camera_,
                                         options_.hand_eye);
      found.push_back(std::move(one));
    }
    return found;
  }

  int tried() const { return tried_; }
  std::string losses() const {
    return fmt::format(
        "of {} looks at the board {} were not all in the image, {} out of the arm's "
        "reach, {} touched something",
        tried_, unseen_, unreached_, touching_);
  }

 private:
  double between(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }

  geometry::RigidTransform look() {
    const double side = between(-M_PI, M_PI), roll = between(-M_PI, M_PI);
    const double tilt = between(0, options_.most_tilt);
    geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
    X_CT.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(side), std::sin(side), 0)) *
                     Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
                        .toRotationMatrix();
    const Eigen::Vector2d size = board_.size();
    const double fill = between(options_.least_fill, options_.most_fill);
    const double depth = size.maxCoeff() * std::min(camera_.K(0, 0), camera_.K(1, 1)) /
                         (fill * std::min(camera_.width, camera_.height));
    const Eigen::Vector2d pixel(between(0.25, 0.75) * camera_.width,
                                between(0.25, 0.75) * camera_.height);
    const Eigen::Vector3d middle_C((pixel.x() - camera_.K(0, 2)) / camera_.K(0, 0) * depth,
                                   (pixel.y() - camera_.K(1, 2)) / camera_.K(1, 1) * depth, depth);
    X_CT.translation() =
        middle_C - X_CT.linear() * Eigen::Vector3d(0.5 * size.x(), 0.5 * size.y(), 0);
    return X_CT;
  }

  robot::InverseKinematics inverse_;
  const motion::FreeSpace& space_;
  const robot::Positions& start_;
  const HandEyeUnknowns& guess_;
  const CalibrationBoard& board_;
  const perception::CameraCalibration& camera_;
  const PoseChoiceOptions& options_;
  std::mt19937_64 random_;
  int tried_ = 0, unseen_ = 0, unreached_ = 0, touching_ = 0;
};

}  // namespace

double information_log_det(const std::vector<geometry::RigidTransform>& X_BF,
                           const std::vector<robot::Positions>& q, const HandEyeUnknowns& guess,
                           const CalibrationBoard& board,
                           const perception::CameraCalibration& camera,
                           const HandEyeOptions& options) {
  Eigen::MatrixXd all = prior_information(options);
  for (std::size_t i = 0; i < X_BF.size(); ++i) {
    all += pose_information(as_pose(X_BF[i], q[i], board), guess, board, camera, options);
  }
  return log_det(all);
}

PoseChoice choose_poses(const robot::KinematicChain& chain, const motion::FreeSpace& space,
                        const robot::Positions& start, const HandEyeUnknowns& guess,
                        const CalibrationBoard& board, const perception::CameraCalibration& camera,
                        const PoseChoiceOptions& options) {
  check(options);
  motion::check_positions(space, start, "start");
  if (!space.is_free(start)) {
    throw geometry::InputError("The arm's start is not free: " + space.problem(start),
                               "Move it away, or correct what stands round it");
  }
  Candidates source(chain, space, start, guess, board, camera, options);
  std::vector<Candidate> candidates = source.draw();
  if (static_cast<int>(candidates.size()) < options.poses) {
    throw geometry::InputError(
        fmt::format("There are {} free poses that see the board, {} are wanted: {}",
                    candidates.size(), options.poses, source.losses()),
        "Put the board where the arm can look at it from many sides, or correct the guess of where "
        "camera and board are");
  }
  PoseChoice choice;
  choice.candidates = static_cast<int>(candidates.size());
  choice.tried = source.tried();
  Eigen::MatrixXd all = prior_information(options.hand_eye);
  double now = log_det(all);
  std::vector<ChosenPose> chosen;
  while (static_cast<int>(chosen.size()) < options.poses && !candidates.empty()) {
    std::size_t best = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double then = log_det(all + candidates[i].information);
      if (then <= most) continue;
      most = then;
      best = i;
    }
    const Candidate one = candidates[best];
    candidates.erase(candidates.begin() + static_cast<std::ptrdiff_t>(best));
    // Who is reached from the start is reached from every other one.
    if (!motion::plan_path(space, start, {one.q}, options.path).found()) continue;
    ChosenPose pose;
    pose.q = one.q;
    pose.X_BF = one.X_BF;
    pose.gain = most - now;
    all += one.information;
    now = most;
    chosen.push_back(pose);
  }
  if (static_cast<int>(chosen.size()) < options.poses) {
    throw geometry::InputError(
        fmt::format("There is a free way to {} poses that see the board, {} are wanted",
                    chosen.size(), options.poses),
        "Make room round the arm, or put the board elsewhere");
  }
  choice.log_det = now;
  // Always to the nearest one next.
  robot::Positions at = start;
  while (!chosen.empty()) {
    const auto nearest = std::min_element(
        chosen.begin(), chosen.end(),
        [&](const auto& a, const auto& b) { return (a.q - at).norm() < (b.q - at).norm(); });
    ChosenPose next = *nearest;
    chosen.erase(nearest);
    next.path = motion::plan_path(space, at, {next.q}, options.path);
    if (!next.path.found()) {
      // By way of the start, from which both were reached.
      motion::JointPath back = motion::plan_path(space, at, {start}, options.path);
      const motion::JointPath out = motion::plan_path(space, start, {next.q}, options.path);
      if (!back.found() || !out.found()) {
        throw geometry::InputError("No free way between two poses was found again",
                                   "Give the search more iterations");
      }
      back.waypoints.insert(back.waypoints.end(), out.waypoints.begin() + 1, out.waypoints.end());
      next.path = back;
    }
    at = next.q;
    choice.poses.push_back(std::move(next));
  }
  return choice;
}

}  // namespace prehend::calibration
