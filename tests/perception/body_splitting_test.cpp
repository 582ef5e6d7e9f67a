#include "prehend/perception/body_splitting.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/perception/seen_width.h"
#include "prehend/perception/segmentation.h"
#include "prehend/shape/body_evidence.h"

// Views of solids by sphere tracing, all of one grey: colours tell nothing.
namespace prehend::perception {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Signed distance [m] to a solid's surface, or less than that.
using Solid = std::function<double(const Vector3d&)>;

double outside(const Eigen::VectorXd& d) {
  return d.cwiseMax(0).norm() + std::min(d.maxCoeff(), 0.0);
}

Solid box(const Vector3d& center, const Vector3d& size, double yaw = 0) {
  return [=](const Vector3d& p) {
    const Vector3d q = Eigen::AngleAxisd(-yaw, Vector3d::UnitZ()) * (p - center);
    return outside(q.cwiseAbs() - size / 2);
  };
}

Solid cylinder(const Vector2d& center, double radius, double low, double high) {
  return [=](const Vector3d& p) {
    const double middle = (low + high) / 2;
    return outside(Vector2d((p.head<2>() - center).norm() - radius,
                            std::abs(p.z() - middle) - (high - low) / 2));
  };
}

Solid united(const Solid& a, const Solid& b) {
  return [=](const Vector3d& p) { return std::min(a(p), b(p)); };
}

Solid without(const Solid& a, const Solid& b) {
  return [=](const Vector3d& p) { return std::max(a(p), -b(p)); };
}

struct Seen {
  geometry::PinholeCamera camera{320, 240, 400, 400, 159.5, 119.5};
  geometry::RigidTransform X_WC = geometry::look_at({0, -0.6, 0.45}, {0, 0, 0.04});
  geometry::PointCloud cloud_C;
  std::vector<int> owner;  // of each pixel: the solid, -1: the table or nothing
  std::vector<int> members;

  explicit Seen(const std::vector<Solid>& solids, double noise = 0.0005) {
    constexpr int kSteps = 400;
    constexpr double kHit = 5e-5, kFar = 1.5;  // m
    std::mt19937 random(3);
    std::normal_distribution<double> deviation(0, noise);
    cloud_C.width = camera.width;
    cloud_C.height = camera.height;
    for (int i = 0; i < camera.width * camera.height; ++i) {
      const Vector3d ray = camera.unproject(i % camera.width, i / camera.width, 1.0);
      const Vector3d direction = X_WC.linear() * ray;
      double z = 0.2;  // depth [m]
      int of = -1;
      for (int step = 0; step < kSteps && z < kFar; ++step) {
        const Vector3d p = X_WC.translation() + z * direction;
        double nearest = p.z();  // the table
        of = -1;
        for (std::size_t k = 0; k < solids.size(); ++k) {
          const double distance = solids[k](p);
          if (distance < nearest) {
            nearest = distance;
            of = static_cast<int>(k);
          }
        }
        if (nearest < kHit) break;
        z += nearest / direction.norm();
      }
      owner.push_back(of);
      const double measured =
          z < kFar ? z + deviation(random) : std::numeric_limits<double>::quiet_NaN();
      cloud_C.points.push_back((measured * ray).cast<float>());
      cloud_C.colors.push_back({120, 120, 120});
      if (of >= 0) members.push_back(i);
    }
  }

  geometry::Plane table_C() const {
    geometry::Plane plane;
    plane.normal = X_WC.linear().transpose() * Vector3d::UnitZ();
    plane.offset = -plane.normal.dot(X_WC.linear().transpose() * X_WC.translation());
    return plane;
  }

  std::vector<std::vector<int>> split(const BodyEvidence& evidence,
                                      const BodySplitOptions& options = {}) const {
    return split_into_bodies(
        {cloud_C, camera, table_C(), {}}, members, evidence,
        [](const std::vector<int>&) { return true; }, options);
  }

  std::vector<std::size_t> sizes_by_shapes() const {
    std::vector<std::size_t> sizes;
    for (const auto& part : split(shape::log_odds_of_one_body)) sizes.push_back(part.size());
    return sizes;
  }

  /// Share of the points that are in the part that has most of their solid.
  double purity(const std::vector<std::vector<int>>& parts, int solids) const {
    double right = 0;
    for (int k = 0; k < solids; ++k) {
      std::ptrdiff_t most = 0;
      for (const auto& part : parts) {
        most = std::max(
            most, std::count_if(part.begin(), part.end(), [&](int i) { return owner[i] == k; }));
      }
      right += static_cast<double>(most);
    }
    return right / static_cast<double>(members.size());
  }
};

const Solid kTallBox = box({-0.04, 0, 0.06}, {0.06, 0.07, 0.12});
const Solid kTurnedBox = box({0.031, -0.01, 0.03}, {0.08, 0.05, 0.06}, 0.5);
// Not in one row with the box across the view: together they would be as symmetric as one body.
const Solid kCan = cylinder({0.031, -0.03}, 0.04, 0, 0.08);

Seen mug() {
  const Solid wall = without(cylinder({0, 0}, 0.04, 0, 0.09), cylinder({0, 0}, 0.036, 0.005, 0.1));
  const Solid handle = [](const Vector3d& p) {  // a ring in the plane of x and z
    const Vector2d around(Vector2d(p.x() - 0.045, p.z() - 0.045).norm() - 0.025, p.y());
    return std::max(around.norm() - 0.005, -cylinder({0, 0}, 0.038, -0.1, 0.2)(p));
  };
  return Seen({united(wall, handle)});
}

void expect_two_bodies(const Seen& seen) {
  const auto parts = seen.split(shape::log_odds_of_one_body);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_GT(seen.purity(parts, 2), 0.95);
  std::vector<int> together = parts[0];
  together.insert(together.end(), parts[1].begin(), parts[1].end());
  std::sort(together.begin(), together.end());
  EXPECT_EQ(together, seen.members);
}

TEST(SplitIntoBodies, TwoBoxesOfOneColourThatTouch) {
  expect_two_bodies(Seen({kTallBox, kTurnedBox}));
}

TEST(SplitIntoBodies, BoxAndCylinderOfOneColourThatTouch) {
  expect_two_bodies(Seen({kTallBox, kCan}));
}

TEST(SplitIntoBodies, AMugKeepsItsHandle) { EXPECT_EQ(mug().sizes_by_shapes().size(), 1U); }

TEST(SplitIntoBodies, ABodyOfLShapeIsOne) {
  const Solid angle = united(box({-0.03, 0, 0.03}, {0.04, 0.12, 0.06}, 0.6),
                             box({0.0005, -0.0285, 0.03}, {0.12, 0.04, 0.06}, 0.6));
  EXPECT_EQ(Seen({angle}).sizes_by_shapes().size(), 1U);
}

TEST(SplitIntoBodies, CutsWhereTheEvidenceSaysSoAndTheGainIsEnough) {
  const Seen seen({kTallBox, kTurnedBox});
  const std::size_t all = seen.members.size();
  double parts_odds = 1;
  // What is seen of the whole has log odds 0, less has `parts_odds`.
  const BodyEvidence evidence = [&](const SegmentedScene&, const ObjectHypothesis& object) {
    return object.cloud_W.size() == all ? 0 : parts_odds;
  };
  BodySplitOptions options;
  options.least_gain = 0.9;
  EXPECT_EQ(seen.split(evidence, options).size(), 2U);
  options.least_gain = 1.1;
  EXPECT_EQ(seen.split(evidence, options), (std::vector<std::vector<int>>{seen.members}));
  options = {};
  options.least_part_gain = 1.1;
  EXPECT_EQ(seen.split(evidence, options).size(), 1U);
  parts_odds = -1;
  EXPECT_EQ(seen.split(evidence).size(), 1U);
}

TEST(SplitIntoBodies, APartThatIsNoObjectIsNotCutOff) {
  const Seen seen({kTallBox, kTurnedBox});
  const std::size_t all = seen.members.size();
  const BodyEvidence evidence = [&](const SegmentedScene&, const ObjectHypothesis& object) {
    return object.cloud_W.size() == all ? 0.0 : 1.0;
  };
  const ClusterView cluster{seen.cloud_C, seen.camera, seen.table_C(), {}};
  const auto is_large = [&](const std::vector<int>& part) { return 10 * part.size() > 9 * all; };
  EXPECT_EQ(split_into_bodies(cluster, seen.members, evidence, is_large).size(), 1U);
}

TEST(SplitIntoBodies, ConvexEdgesAreNoPlaceToCut) {
  const Seen seen({box({0, 0, 0.05}, {0.1, 0.08, 0.1}, 0.5)});
  const std::size_t all = seen.members.size();
  const BodyEvidence evidence = [&](const SegmentedScene&, const ObjectHypothesis& object) {
    return object.cloud_W.size() == all ? 0.0 : 10.0;
  };
  EXPECT_EQ(seen.split(evidence).size(), 1U);
}

TEST(SplitIntoBodies, RefusesWhatItCannotJudge) {
  Seen seen({kTallBox});
  EXPECT_THROW(seen.split({}), std::invalid_argument);
  BodySplitOptions bad;
  bad.least_share = 0.6;
  EXPECT_THROW(seen.split(shape::log_odds_of_one_body, bad), std::invalid_argument);
  seen.cloud_C.width = static_cast<int>(seen.cloud_C.size());
  seen.cloud_C.height = 1;
  EXPECT_THROW(seen.split(shape::log_odds_of_one_body), std::invalid_argument);
}

TEST(SegmentByShapes, FindsTheBodiesAndNeedsTheirEvidence) {
  const Seen seen({kTallBox, kCan});
  SegmentationOptions options;
  const auto count = [&] {
    return segment(seen.cloud_C, seen.camera, seen.X_WC, options).objects.size();
  };
  EXPECT_EQ(count(), 1U) << "by level tops alone: one colour";
  options.split = Splitting::kShapes;
  EXPECT_THROW(count(), std::invalid_argument);
  options.body_evidence = shape::log_odds_of_one_body;
  EXPECT_EQ(count(), 2U);
}

TEST(ChooseSplitting, WideIsByShapesOfWhatIsWiderThanTheHandOpens) {
  const auto chosen = [](const char* name, std::optional<double> widest_opening) {
    SegmentationOptions options;
    choose_splitting(name, widest_opening, &options);
    return std::pair(options.split, options.least_split_width);
  };
  EXPECT_EQ(chosen("none", {}), std::pair(Splitting::kNone, 0.0));
  EXPECT_EQ(chosen("tops", 0.07), std::pair(Splitting::kTops, 0.0));
  EXPECT_EQ(chosen("touching", {}), std::pair(Splitting::kTouching, 0.0));
  EXPECT_EQ(chosen("shapes", 0.07), std::pair(Splitting::kShapes, 0.0));
  EXPECT_EQ(chosen("wide", 0.07), std::pair(Splitting::kShapes, 0.07));
  EXPECT_EQ(chosen("wide", 0.0), std::pair(Splitting::kTops, 0.0)) << "no fingers face each other";
  EXPECT_THROW(chosen("wide", {}), geometry::InputError);
  EXPECT_THROW(chosen("top", {}), geometry::InputError);
}

TEST(SegmentByShapes, LeavesWholeWhatIsNarrow) {
  const Seen seen({kTallBox, kCan});
  SegmentationOptions options;
  options.split = Splitting::kShapes;
  options.body_evidence = shape::log_odds_of_one_body;
  const auto count = [&](double least_width) {
    options.least_split_width = least_width;
    return segment(seen.cloud_C, seen.camera, seen.X_WC, options).objects.size();
  };
  // Of box and can 70 to 80 mm are to be seen across their row.
  EXPECT_EQ(count(0.04), 2U);
  EXPECT_EQ(count(0.1), 1U);
  for (const double bad : {-0.01, std::nan("")}) EXPECT_THROW(count(bad), std::invalid_argument);
}

TEST(SidesOverPlane, AreThoseOfARectangleWhateverItsTurnAndHeight) {
  geometry::Plane plane;
  plane.normal = Vector3d(0.3, -0.5, 0.8).normalized();
  const Vector3d x = plane.normal.unitOrthogonal(), y = plane.normal.cross(x);
  for (const double turn : {0.0, 0.3, 1.2}) {
    geometry::PointCloud cloud;
    std::vector<int> members;
    for (int i = 0; i <= 20; ++i) {
      for (int j = 0; j <= 20; ++j) {
        const Eigen::Vector2d p = Eigen::Rotation2Dd(turn) * Vector2d(0.002 * i, 0.005 * j);
        members.push_back(static_cast<int>(cloud.points.size()));
        cloud.points.push_back(
            (p.x() * x + p.y() * y + 0.01 * ((i * j) % 7) * plane.normal).cast<float>());
      }
    }
    cloud.points.push_back((10 * x).cast<float>());  // of another body
    EXPECT_LT((sides_over_plane(cloud, members, plane) - Vector2d(0.04, 0.1)).norm(), 1e-5) << turn;
    EXPECT_EQ(sides_over_plane(cloud, {members[0]}, plane).norm(), 0);
    EXPECT_EQ(sides_over_plane(cloud, {}, plane).norm(), 0);
  }
}

}  // namespace
}  // namespace prehend::perception
