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
constexpr double kMostHidden = 0.2;           // of what a look is to show, behind the hand
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
              const geometry::PinholeCamera& camera, const surface::ObjectModel& object,
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

  /// Free positions of the arm from which the camera sees it along there, nearest first.
  std::vector<Positions> poses_for(const Vector3d& direction) const {
    const RigidTransform X_BW = platform_.X_WB.inverse(Eigen::Isometry);
    const RigidTransform X_CF = platform_.X_FC->inverse(Eigen::Isometry);
    std::vector<std::pair<double, Positions>> found;
    for (const double farther : kFarther) {
      const Vector3d eye = middle_W_ + (options_.nearest + radius_ + farther) * direction;
      const RigidTransform X_WE = geometry::look_at(eye, middle_W_);
      if (!is_in_picture({camera_, X_WE}, middle_W_, radius_, options_)) continue;
      for (int spin = 0; spin < kLookSpins; ++spin) {
        const RigidTransform X_WC =
            X_WE * Eigen::AngleAxisd(2 * std::numbers::pi * spin / kLookSpins, Vector3d::UnitZ());
        if (!is_in_picture({camera_, X_WC}, middle_W_, radius_, options_)) continue;
        if (hidden_by_hand(X_WC) > kMostHidden) continue;
        for (const Positions& q : inverse_.solve(X_BW * X_WC * X_CF, start_).solutions) {
          found.emplace_back((q - start_).norm(), q);
        }
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Positions> free;
    for (const auto& [way, q] : found) {
      if (free.size() == kMostLookGoals || is_over()) break;
      if (robot_.is_free(q)) free.push_back(q);
    }
    return free;
  }

  /// Share of the surface.
  double hidden_by_hand(const RigidTransform& X_WC) const {
    if (!hand_C_) return 0;
    const RigidTransform X_CW = X_WC.inverse(Eigen::Isometry);
    std::size_t hidden = 0;
    for (const SurfacePatch& patch : patches_) {
      const Vector3d p_C = X_CW * patch.p_W;
      hidden += hand_C_->cast_ray(Vector3d::Zero(), p_C.normalized(), p_C.norm()).has_value();
    }
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
  geometry::PinholeCamera camera_;
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
  Vector3d middle_W_ = Vector3d::Zero();
  double radius_ = 0;  // m, of a ball about its middle that holds it
  steady_clock::time_point begin_ = steady_clock::now();
};

}  // namespace

PlannedLook plan_look(const robot::Platform& platform, const Positions& start,
                      const geometry::PinholeCamera& camera, const surface::ObjectModel& object,
                      const PlatformScene& scene, const PlatformPickOptions& arm,
                      const ViewOptions& options) {
  const text::Require require{"plan_look(): "};
  ViewOptions::knobs(options, text::CheckKnobs{"ViewOptions."});
  require(platform.X_FC.has_value(), "the arm carries no camera");
  require(start.size() == platform.arm_chain().size(), "the start is of another size");
  require(camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0,
          "the camera is none");
  if (scene.object_pieces_W.empty()) {
    throw std::invalid_argument("PlatformScene.object_pieces_W must not be empty");
  }
  return LookPlanner(platform, start, camera, object, scene, arm, options).plan();
}

}  // namespace prehend::planning
