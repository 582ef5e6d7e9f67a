#include "prehend/planning/held_views.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/rotation_between.h"
#include "prehend/motion/plan_path.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using robot::Positions;
using std::chrono::steady_clock;

constexpr int kDirections = 64;         // that an object may be seen from, evenly spread
constexpr int kSpins = 12;              // about the line of sight
constexpr int kMostGoals = 8;           // positions that a path may lead to
constexpr double kApart = 0.7;          // rad, of views that show nothing new
constexpr double kOverlap = 0.3;        // of what a view shows, that is known: enough to lay it on
constexpr double kOverTable = 0.04;     // m, that all of it stays over the table when it is turned
constexpr double kFarthestPlace = 2;    // m, beyond the nearest place before the camera
constexpr double kPlaceStep = 0.05;     // m, between places along the line of sight
constexpr std::size_t kMostPlaces = 3;  // besides where it is lifted to

class ViewPlanner {
 public:
  ViewPlanner(const motion::RobotInWorld& carrying, const robot::InverseKinematics& inverse,
              const RigidTransform& X_WB, const Positions& lifted, const HeldThing& thing,
              const ViewingCamera& camera, const geometry::Plane& table_W,
              const HeldViewOptions& options)
      : carrying_(carrying),
        inverse_(inverse),
        X_BW_(X_WB.inverse(Eigen::Isometry)),
        lifted_(lifted),
        X_WT_lifted_(X_WB * carrying.chain().forward(lifted)),
        thing_(thing),
        camera_(camera),
        options_(options) {
    Eigen::AlignedBox3d box;
    for (const SurfacePatch& patch : thing.patches_T) box.extend(patch.p_W);
    middle_T_ = box.center();
    for (const SurfacePatch& patch : thing.patches_T) {
      radius_ = std::max(radius_, (patch.p_W - middle_T_).norm());
      known_.push_back(patch.seen);
    }
    hiding_.push_back(thing.object_T);
    if (thing.hand_T) hiding_.push_back(thing.hand_T);
    find_places(table_W);
  }

  HeldViews plan(const motion::PathPlanner& planner, const motion::PathOptions& path,
                 const Eigen::VectorXd& acceleration) {
    HeldViews result;
    result.seen = known_share();
    result.shown = result.seen;
    if (1 - result.seen < options_.least_gain) {
      result.problem = "all of it is known";
      return result;
    }
    if (places_.empty()) {
      result.problem = "what is lifted is not brought into the camera's picture";
      return result;
    }
    if (is_in_picture(camera_, X_WT_lifted_ * middle_T_, radius_, options_)) {
      HeldView stays;
      stays.way = {lifted_};
      const std::vector<char> shown =
          shown_from(X_WT_lifted_.linear().transpose() * to_eye(X_WT_lifted_ * middle_T_));
      stays.gain = learn(shown);
      taken_T_.push_back(X_WT_lifted_.linear().transpose() * to_eye(X_WT_lifted_ * middle_T_));
      result.views.push_back(std::move(stays));
    }
    std::vector<Vector3d> directions_T = even_directions(kDirections);
    std::vector<std::vector<char>> shown;
    for (const Vector3d& direction_T : directions_T) shown.push_back(shown_from(direction_T));
    std::vector<char> open(directions_T.size(), 1);
    const std::size_t most = static_cast<std::size_t>(options_.views);
    while (result.views.size() < most && !is_over()) {
      const std::size_t best = best_direction(directions_T, shown, open);
      if (best == open.size()) break;
      open[best] = 0;
      const std::vector<Positions> goals = poses_for(directions_T[best]);
      if (goals.empty()) continue;
      motion::PathOptions searching = path;
      if (options_.budget > 0) searching.budget = std::max(1e-3, options_.budget - elapsed());
      motion::JointPath way = motion::plan_path(planner, carrying_, lifted_, goals, searching);
      if (!way.found()) continue;
      HeldView view;
      motion::TimingOptions timing;
      timing.speed_factor = options_.speed_factor;
      view.trajectory = motion::blend_trajectory(carrying_, way.waypoints, acceleration, timing);
      view.way = std::move(way.waypoints);
      view.gain = learn(shown[best]);
      taken_T_.push_back(directions_T[best]);
      result.views.push_back(std::move(view));
    }
    result.shown = known_share();
    if (result.views.empty()) {
      result.problem = is_over()
                           ? "no view was found within the budget"
                           : "the arm cannot turn any side of it to the camera that was not seen";
    }
    return result;
  }

 private:
  double elapsed() const {
    return std::chrono::duration<double>(steady_clock::now() - begin_).count();
  }
  bool is_over() const { return options_.budget > 0 && elapsed() > options_.budget; }

  /// Of the open directions that which shows most anew; where none shows enough, but something was
  /// learnt in the hand, that which shows most from another side than those taken: looks that
  /// overlap put each other right. As many as there are: none.
  std::size_t best_direction(const std::vector<Vector3d>& directions_T,
                             const std::vector<std::vector<char>>& shown,
                             const std::vector<char>& open) const {
    std::size_t best = open.size();
    double most = 0;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (!open[i] || gain(shown[i]) < options_.least_gain) continue;
      const double worth = gain(shown[i]) * std::min(1.0, overlap(shown[i]) / kOverlap);
      if (worth > most) best = i;
      most = std::max(most, worth);
    }
    if (best < open.size() || taken_T_.empty()) return best;
    for (std::size_t i = 0; i < open.size(); ++i) {
      const bool is_another = std::none_of(
          taken_T_.begin(), taken_T_.end(),
          [&](const Vector3d& taken_T) { return taken_T.dot(directions_T[i]) > std::cos(kApart); });
      if (!open[i] || !is_another) continue;
      const double area = share(static_cast<std::size_t>(std::count_if(
          shown[i].begin(), shown[i].end(), [](char is_shown) { return is_shown != 0; })));
      if (area > most) best = i;
      most = std::max(most, area);
    }
    return best;
  }

  Vector3d to_eye(const Vector3d& p_W) const {
    return (camera_.X_WC.translation() - p_W).normalized();
  }

  /// Where its middle may be brought to: where it is lifted to, then those on the line of sight
  /// through the picture's middle that are nearest to that.
  void find_places(const geometry::Plane& table_W) {
    const Vector3d lifted_W = X_WT_lifted_ * middle_T_;
    if (is_in_picture(camera_, lifted_W, radius_, options_)) places_.push_back(lifted_W);
    const double least = radius_ + kOverTable;
    const geometry::PinholeCamera& camera = camera_.camera;
    const Vector3d eye_W = camera_.X_WC.translation();
    const Vector3d ahead_W =
        (camera_.X_WC.linear() *
         camera.unproject(0.5 * (camera.width - 1), 0.5 * (camera.height - 1), 1))
            .normalized();
    std::vector<std::pair<double, Vector3d>> found;
    for (double along = options_.nearest; along < options_.nearest + kFarthestPlace;
         along += kPlaceStep) {
      const Vector3d p_W = eye_W + along * ahead_W;
      if (table_W.signed_distance(p_W) < least || !is_in_picture(camera_, p_W, radius_, options_))
        continue;
      found.emplace_back((p_W - lifted_W).norm(), p_W);
    }
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < std::min(kMostPlaces, found.size()); ++i) {
      places_.push_back(found[i].second);
    }
  }

  std::vector<char> shown_from(const Vector3d& direction_T) const {
    return seen_along(thing_.patches_T, direction_T, options_.steepest, hiding_);
  }

  double share(std::size_t count) const {
    return static_cast<double>(count) / static_cast<double>(known_.size());
  }
  double known_share() const {
    return share(static_cast<std::size_t>(std::count(known_.begin(), known_.end(), 1)));
  }
  double gain(const std::vector<char>& shown) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) count += shown[i] && !known_[i];
    return share(count);
  }
  /// Of what is shown, the share that is known.
  double overlap(const std::vector<char>& shown) const {
    std::size_t both = 0, all = 0;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      all += shown[i] != 0;
      both += shown[i] && known_[i];
    }
    return all > 0 ? static_cast<double>(both) / static_cast<double>(all) : 0;
  }
  double learn(const std::vector<char>& shown) {
    const double gained = gain(shown);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (shown[i]) known_[i] = 1;
    }
    return gained;
  }

  /// Free positions of the arm that turn that side to the camera, nearest first.
  std::vector<Positions> poses_for(const Vector3d& direction_T) const {
    std::vector<std::pair<double, Positions>> found;
    for (const Vector3d& place_W : places_) {
      const Vector3d sight_W = to_eye(place_W);
      const Eigen::Quaterniond facing =
          geometry::rotation_between(X_WT_lifted_.linear() * direction_T, sight_W);
      for (int spin = 0; spin < kSpins; ++spin) {
        const Eigen::AngleAxisd about(2 * std::numbers::pi * spin / kSpins, sight_W);
        RigidTransform X_WT = RigidTransform::Identity();
        X_WT.linear() = (about * facing).toRotationMatrix() * X_WT_lifted_.linear();
        X_WT.translation() = place_W - X_WT.linear() * middle_T_;
        for (const Positions& q : inverse_.solve(X_BW_ * X_WT, lifted_).solutions) {
          found.emplace_back((q - lifted_).norm(), q);
        }
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Positions> free;
    for (const auto& [way, q] : found) {
      if (free.size() == kMostGoals || is_over()) break;
      if (carrying_.is_free(q)) free.push_back(q);
    }
    return free;
  }

  const motion::RobotInWorld& carrying_;
  const robot::InverseKinematics& inverse_;
  RigidTransform X_BW_;
  Positions lifted_;
  RigidTransform X_WT_lifted_;
  const HeldThing& thing_;
  const ViewingCamera& camera_;
  const HeldViewOptions& options_;
  std::vector<const geometry::MeshQuery*> hiding_;
  Vector3d middle_T_ = Vector3d::Zero();
  double radius_ = 0;        // m, of a ball about its middle that holds it
  std::vector<char> known_;  // patches, by looks and views so far
  std::vector<Vector3d> places_;
  std::vector<Vector3d> taken_T_;  // directions of the views so far
  steady_clock::time_point begin_ = steady_clock::now();
};

}  // namespace

void HeldViewOptions::validate() const { knobs(*this, text::CheckKnobs{"HeldViewOptions."}); }

HeldViews plan_held_views(const motion::RobotInWorld& carrying,
                          const robot::InverseKinematics& inverse,
                          const geometry::RigidTransform& X_WB, const robot::Positions& lifted,
                          const HeldThing& thing, const ViewingCamera& camera,
                          const geometry::Plane& table_W, const motion::PathPlanner& planner,
                          const motion::PathOptions& path, const Eigen::VectorXd& acceleration,
                          const HeldViewOptions& options) {
  options.validate();
  const text::Require require{"plan_held_views(): "};
  require(!thing.patches_T.empty() && thing.object_T != nullptr, "the object has no surface");
  require(camera.camera.width > 0 && camera.camera.height > 0 && camera.camera.fx > 0 &&
              camera.camera.fy > 0 && camera.X_WC.matrix().allFinite(),
          "the camera is none");
  return ViewPlanner(carrying, inverse, X_WB, lifted, thing, camera, table_W, options)
      .plan(planner, path, acceleration);
}

}  // namespace prehend::planning
