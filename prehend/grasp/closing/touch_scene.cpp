#include "prehend/grasp/closing/touch_scene.h"

#include <algorithm>
#include <utility>

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kShare = 0.7;  // of the clearance beyond what must be exact, at least

class Search {
 public:
  Search(const LinkBalls& link, const geometry::RigidTransform& X_WL, const TouchScene& scene,
         double exact)
      : link_(link), X_WL_(X_WL), scene_(scene), exact_(exact) {}

  NearBall run(int likely) {
    const double root = lower_bound(0);
    // All of it is far: the bound is as good.
    if (root > DistanceGrid::kNear) return {root, 0, Touched::kNothing};
    if (likely >= 0) look_at(likely);
    visit(0);
    best_.clearance = std::min(best_.clearance, passed_over_);
    return best_;
  }

 private:
  const LinkBalls::Node& node(int i) const { return link_.nodes[static_cast<std::size_t>(i)]; }
  double lower_bound(int i) const {
    return scene_.distance(X_WL_ * node(i).center) - node(i).radius;
  }

  void look_at(int ball) {
    Touched what = Touched::kNothing;
    const double clearance =
        scene_.distance(X_WL_ * link_.centers[static_cast<std::size_t>(ball)], &what) -
        link_.radii[static_cast<std::size_t>(ball)];
    if (clearance < best_.clearance) best_ = {clearance, ball, what};
  }

  void visit(int index) {
    const LinkBalls::Node& here = node(index);
    if (here.leaf()) {
      for (int i = here.first; i < here.last; ++i) look_at(i);
      return;
    }
    int near = here.first, far = here.right;
    double near_bound = lower_bound(near), far_bound = lower_bound(far);
    if (far_bound < near_bound) {
      std::swap(near, far);
      std::swap(near_bound, far_bound);
    }
    for (const auto& [bound, child] : {std::pair(near_bound, near), std::pair(far_bound, far)}) {
      if (bound < best_.clearance && bound < exact_ + kShare * (best_.clearance - exact_)) {
        visit(child);
      } else {
        passed_over_ = std::min(passed_over_, bound);
      }
    }
  }

  const LinkBalls& link_;
  const geometry::RigidTransform& X_WL_;
  const TouchScene& scene_;
  double exact_;
  NearBall best_;
  double passed_over_ = std::numeric_limits<double>::infinity();
};

void visit_lowest(const LinkBalls& link, const Vector3d& normal_L, double offset, int index,
                  NearBall& lowest) {
  const LinkBalls::Node& here = link.nodes[static_cast<std::size_t>(index)];
  if (normal_L.dot(here.center) - offset - here.radius >= lowest.clearance) return;
  if (!here.leaf()) {
    visit_lowest(link, normal_L, offset, here.first, lowest);
    visit_lowest(link, normal_L, offset, here.right, lowest);
    return;
  }
  for (int i = here.first; i < here.last; ++i) {
    const auto ball = static_cast<std::size_t>(i);
    const double height = normal_L.dot(link.centers[ball]) - offset - link.radii[ball];
    if (height < lowest.clearance) lowest = {height, i, Touched::kTable};
  }
}

}  // namespace

double TouchScene::distance(const Vector3d& p_W, Touched* what) const {
  double least = std::numeric_limits<double>::infinity();
  Touched nearest = Touched::kNothing;
  if (object_W != nullptr) {
    least = object_W->distance(p_W);
    nearest = Touched::kObject;
  }
  if (table_W) {
    const double height = table_W->signed_distance(p_W);
    if (height < least) {
      least = height;
      nearest = Touched::kTable;
    }
  }
  if (obstacles_W != nullptr) {
    const double other = obstacles_W->distance(p_W);
    if (other < least) {
      least = other;
      nearest = Touched::kObstacle;
    }
  }
  if (what != nullptr) *what = nearest;
  return least;
}

double TouchScene::exact_distance(const Vector3d& p_W, Touched what, Vector3d* away_W) const {
  if (what == Touched::kTable) {
    *away_W = table_W->normal;
    return table_W->signed_distance(p_W);
  }
  const DistanceGrid& grid = what == Touched::kObstacle ? *obstacles_W : *object_W;
  const auto found = grid.mesh().nearest(p_W);
  if (!found) return std::numeric_limits<double>::infinity();
  const Vector3d way = p_W - found->point;
  *away_W = way.norm() > 1e-9 ? Vector3d(way.normalized()) : Vector3d::Zero();
  return found->distance;
}

NearBall nearest_ball(const LinkBalls& link, const geometry::RigidTransform& X_WL,
                      const TouchScene& scene, double exact, int likely) {
  if (link.nodes.empty()) return {};
  return Search(link, X_WL, scene, exact).run(likely);
}

NearBall lowest_ball(const LinkBalls& link, const geometry::RigidTransform& X_WL,
                     const geometry::Plane& plane_W, double most) {
  NearBall lowest;
  lowest.clearance = most;
  if (link.nodes.empty()) return lowest;
  visit_lowest(link, X_WL.linear().transpose() * plane_W.normal,
               plane_W.offset - plane_W.normal.dot(X_WL.translation()), 0, lowest);
  return lowest;
}

}  // namespace prehend::grasp
