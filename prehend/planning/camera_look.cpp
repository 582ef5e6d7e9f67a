#include "prehend/planning/camera_look.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/motion/plan_path.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/robot/placed_links.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;
using geometry::MeshQuery;
using geometry::RigidTransform;
using geometry::TriangleMesh;
using robot::Positions;
using std::chrono::steady_clock;

constexpr int kLookDirections = 128;          // round the object
constexpr double kLowest = 0.2;               // of a direction's height over the table: 12 degrees
constexpr int kLookSpins = 12;                // about the line of sight
constexpr double kFarther[] = {0, 0.1, 0.2};  // m, beyond the nearest place
constexpr std::size_t kMostLookGoals = 8;     // positions that a path may lead to
constexpr double kMostHidden = 0.2;           // of the surface, behind the hand
constexpr double kHiddenStep = 0.05;          // of it: as little as can be, in such steps
constexpr double kAim = 0.08;                 // rad, between places in the picture, ...
constexpr int kAims = 4;                      // ... so many to each side
constexpr double kAbove = 0.9;                // of a direction's height: it is "from above"

/// From where, as who looks from `before_W` sees it; both towards the camera, unit.
std::string side_of(const Vector3d& direction_W, const RigidTransform& X_WC_before,
                    const Vector3d& middle_W, const Vector3d& up_W) {
  if (direction_W.dot(up_W) > kAbove) return "above";
  const auto level = [&](const Vector3d& v) -> Vector3d { return v - v.dot(up_W) * up_W; };
  const Vector3d now = level(direction_W), before = level(X_WC_before.translation() - middle_W);
  if (before.norm() < 1e-6) return "the side";
  const double towards = now.dot(before.normalized());
  const double right = now.dot(up_W.cross(before.normalized()));
  if (std::abs(right) > std::abs(towards)) return right > 0 ? "the right" : "the left";
  return towards > 0 ? "the same side" : "behind";
}

class LookPlanner {
 public:
  LookPlanner(const robot::Platform& platform, const Positions& start,
              const geometry::StereoCamera& camera, const surface::ObjectModel& object,
              const PlatformScene& scene, const PlatformPickOptions& arm,
              const ViewOptions& options)
      : platform_(platform),
        start_(start),
        camera_(camera),
        object_(object),
        arm_(arm),
        options_(options),
        up_W_(scene.table_W.normal),
        open_(platform.hand.preshapes.front().open),
        robot_(robot_in(world_of(platform, scene), platform, open_, arm.margin,
                        arm.sphere_resolution, motion::CheckerRegistry().create(arm.checker))),
        inverse_(platform.arm_chain()),
        patches_(surface_patches(object)),
        surface_(object.mesh_W) {
    const TriangleMesh others = geometry::concatenated(scene.obstacle_pieces_W);
    if (!others.triangles.empty()) neighbours_.emplace(others);
    Eigen::AlignedBox3d box;
    for (const SurfacePatch& patch : patches_) box.extend(patch.p_W);
    middle_W_ = box.center();
    for (const SurfacePatch& patch : patches_) {
      radius_ = std::max(radius_, (patch.p_W - middle_W_).norm());
    }
    find_hand();
    for (const double farther : kFarther) {
      const double distance = options.nearest + radius_ + farther;
      if (const auto aim = aim_beside_hand(distance)) aims_.push_back({distance, *aim});
    }
  }

  PlannedLook plan() {
    PlannedLook look;
    const std::vector<Vector3d> directions = ranked_directions();
    if (directions.empty()) {
      look.problem = "no side of it that a camera sees would be new";
      return look;
    }
    const auto planner = motion::PlannerRegistry().create(arm_.pick.planner);
    for (const Vector3d& direction : directions) {
      if (is_over()) break;
      std::vector<Positions> goals = poses_for(direction);
      if (goals.empty()) continue;
      motion::PathOptions searching = arm_.pick.path;
      if (options_.budget > 0) searching.budget = std::max(1e-3, options_.budget - elapsed());
      motion::JointPath way = motion::plan_path(*planner, robot_, start_, goals, searching);
      if (!way.found()) continue;
      motion::TimingOptions timing;
      timing.speed_factor = options_.speed_factor;
      look.trajectory =
          motion::blend_trajectory(robot_, way.waypoints, platform_.acceleration, timing);
      look.X_WC = platform_.X_WC(way.waypoints.back());
      look.way = std::move(way.waypoints);
      look.gain = gain(seen_from(patches_, direction, surface_));
      look.from = side_of(direction, platform_.X_WC(start_), middle_W_, up_W_);
      look.apart = told_apart(direction);
      return look;
    }
    look.problem = is_over() ? "no look was found within the budget"
                             : "the arm cannot bring the camera to where a new side is seen";
    return look;
  }

 private:
  double elapsed() const {
    return std::chrono::duration<double>(steady_clock::now() - begin_).count();
  }
  bool is_over() const { return options_.budget > 0 && elapsed() > options_.budget; }

  /// In the camera's frame: it goes along.
  void find_hand() {
    const Eigen::VectorXd all = platform_.hand.all_positions(open_);
    const RigidTransform X_CH = platform_.X_FC->inverse(Eigen::Isometry) * platform_.X_FH;
    const TriangleMesh hand =
        geometry::concatenated(robot::placed_hand_links(platform_.hand, X_CH, all));
    if (!hand.triangles.empty()) hand_C_.emplace(hand);
  }

  /// Whether the hand is before it, for either eye.
  bool is_behind_hand(const Vector3d& p_C) const {
    if (!hand_C_) return false;
    const auto is_hidden = [&](const Vector3d& eye_C) {
      const Vector3d way = p_C - eye_C;
      return hand_C_->cast_ray(eye_C, way.normalized(), way.norm()).has_value();
    };
    return is_hidden(Vector3d::Zero()) ||
           (camera_.baseline > 0 && is_hidden({camera_.baseline, 0, 0}));
  }

  bool is_in_pictures(const Vector3d& p_C) const {
    const ViewingCamera eye{camera_.left, RigidTransform::Identity()};
    return is_in_picture(eye, p_C, radius_, options_) &&
           is_in_picture(eye, p_C - camera_.baseline * Vector3d::UnitX(), radius_, options_);
  }

  /// Turns the camera's axis from the object, at that distance, to where in the picture least of a
  /// ball of its size is behind the hand, nearest to the middle. None: it is in no picture.
  std::optional<Eigen::Matrix3d> aim_beside_hand(double distance) const {
    const std::vector<Vector3d> ball = even_directions(64);
    std::optional<Eigen::Matrix3d> best;
    std::pair<std::size_t, double> least;
    for (int i = -kAims; i <= kAims; ++i) {
      for (int j = -kAims; j <= kAims; ++j) {
        const Vector3d p_C = distance * Vector3d(i * kAim, j * kAim, 1).normalized();
        if (!is_in_pictures(p_C)) continue;
        std::size_t hidden = 0;
        for (const Vector3d& direction : ball) hidden += is_behind_hand(p_C + radius_ * direction);
        const std::pair<std::size_t, double> cost{hidden, std::hypot(i, j)};
        if (best && cost >= least) continue;
        least = cost;
        best = Eigen::Quaterniond::FromTwoVectors(p_C, Vector3d::UnitZ()).toRotationMatrix();
      }
    }
    return best;
  }

  std::vector<char> seen_from(const std::vector<SurfacePatch>& patches, const Vector3d& direction,
                              const MeshQuery& surface) const {
    std::vector<const MeshQuery*> hiding{&surface};
    if (neighbours_) hiding.push_back(&*neighbours_);
    return seen_along(patches, direction, options_.steepest, hiding);
  }

  double gain(const std::vector<char>& shown) const {
    std::size_t fresh = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) fresh += shown[i] && !patches_[i].seen;
    return static_cast<double>(fresh) / static_cast<double>(patches_.size());
  }

  /// Those that show enough anew, that which shows most first.
  std::vector<Vector3d> ranked_directions() const {
    std::vector<std::pair<double, Vector3d>> ranked;
    for (const Vector3d& direction : even_directions(kLookDirections)) {
      if (direction.dot(up_W_) < kLowest) continue;
      const double gained = gain(seen_from(patches_, direction, surface_));
      if (gained >= options_.least_gain) ranked.emplace_back(gained, direction);
    }
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<Vector3d> directions;
    for (const auto& [gained, direction] : ranked) directions.push_back(direction);
    return directions;
  }

  /// Free positions of the arm from which the camera sees it along there, those with least behind
  /// the hand first, and of these the nearest.
  std::vector<Positions> poses_for(const Vector3d& direction) const {
    const RigidTransform X_BW = platform_.X_WB.inverse(Eigen::Isometry);
    const RigidTransform X_CF = platform_.X_FC->inverse(Eigen::Isometry);
    std::vector<std::pair<std::pair<double, double>, Positions>> found;
    for (const Aim& aim : aims_) {
      const Vector3d eye = middle_W_ + aim.distance * direction;
      const RigidTransform X_WE = geometry::look_at(eye, middle_W_);
      for (int spin = 0; spin < kLookSpins; ++spin) {
        RigidTransform X_WC =
            X_WE * Eigen::AngleAxisd(2 * std::numbers::pi * spin / kLookSpins, Vector3d::UnitZ());
        X_WC.linear() *= aim.R_turn;
        const double hidden = hidden_by_hand(X_WC);
        if (hidden > kMostHidden) continue;
        for (const Positions& q : inverse_.solve(X_BW * X_WC * X_CF, start_).solutions) {
          found.push_back({{std::floor(hidden / kHiddenStep), (q - start_).norm()}, q});
        }
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Positions> free;
    for (const auto& [cost, q] : found) {
      if (free.size() == kMostLookGoals || is_over()) break;
      if (robot_.is_free(q)) free.push_back(q);
    }
    return free;
  }

  /// Share of the surface.
  double hidden_by_hand(const RigidTransform& X_WC) const {
    const RigidTransform X_CW = X_WC.inverse(Eigen::Isometry);
    std::size_t hidden = 0;
    for (const SurfacePatch& patch : patches_) hidden += is_behind_hand(X_CW * patch.p_W);
    return static_cast<double>(hidden) / static_cast<double>(patches_.size());
  }

  Eigen::MatrixXd told_apart(const Vector3d& direction) const {
    std::vector<const TriangleMesh*> shapes{&object_.mesh_W};
    for (const TriangleMesh& other : object_.alternatives_W) shapes.push_back(&other);
    std::vector<MeshQuery> surfaces;
    for (const TriangleMesh* shape : shapes) surfaces.emplace_back(*shape);
    const auto count = static_cast<Eigen::Index>(shapes.size());
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(count, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto own = static_cast<std::size_t>(k);
      const std::vector<SurfacePatch> patches = surface_patches(*shapes[own]);
      const std::vector<char> shown = seen_from(patches, direction, surfaces[own]);
      for (Eigen::Index j = 0; j < count; ++j) {
        double sum = 0;
        int number = 0;
        for (std::size_t i = 0; j != k && i < patches.size(); ++i) {
          if (!shown[i]) continue;
          const double off =
              surfaces[static_cast<std::size_t>(j)].nearest(patches[i].p_W)->distance;
          sum += off * off;
          ++number;
        }
        if (number > 0) apart(k, j) = std::sqrt(sum / number);
      }
    }
    return apart;
  }

  const robot::Platform& platform_;
  Positions start_;
  geometry::StereoCamera camera_;
  const surface::ObjectModel& object_;
  const PlatformPickOptions& arm_;
  const ViewOptions& options_;
  Vector3d up_W_;
  Eigen::VectorXd open_;
  motion::RobotInWorld robot_;
  robot::InverseKinematics inverse_;
  std::vector<SurfacePatch> patches_;
  MeshQuery surface_;
  std::optional<MeshQuery> neighbours_;
  std::optional<MeshQuery> hand_C_;
  struct Aim {
    double distance;         // m, of the object's middle from the camera
    Eigen::Matrix3d R_turn;  // of the camera, from looking at it
  };
  std::vector<Aim> aims_;
  Vector3d middle_W_ = Vector3d::Zero();
  double radius_ = 0;  // m, of a ball about its middle that holds it
  steady_clock::time_point begin_ = steady_clock::now();
};

}  // namespace

PlannedLook plan_look(const robot::Platform& platform, const Positions& start,
                      const geometry::StereoCamera& camera, const surface::ObjectModel& object,
                      const PlatformScene& scene, const PlatformPickOptions& arm,
                      const ViewOptions& options) {
  const text::Require require{"plan_look(): "};
  ViewOptions::knobs(options, text::CheckKnobs{"ViewOptions."});
  require(platform.X_FC.has_value(), "the arm carries no camera");
  require(start.size() == platform.arm_chain().size(), "the start is of another size");
  const geometry::PinholeCamera& left = camera.left;
  require(left.width > 0 && left.height > 0 && left.fx > 0 && left.fy > 0 &&
              std::isfinite(camera.baseline) && camera.baseline >= 0,
          "the camera is none");
  if (scene.object_pieces_W.empty()) {
    throw std::invalid_argument("PlatformScene.object_pieces_W must not be empty");
  }
  return LookPlanner(platform, start, camera, object, scene, arm, options).plan();
}

}  // namespace prehend::planning
