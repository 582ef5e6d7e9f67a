// The fast vote against the reference, on random clouds, cameras and planes.

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "prehend/shape/fast_vote.h"
#include "tests/oracles/reference_vote.h"
#include "tests/shape/synthetic_view.h"

namespace prehend::shape {
namespace {

struct RandomCase {
  SyntheticView view;
  std::vector<geometry::Plane> planes_C;
};

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (random() / 4294967296.0);
}

Eigen::Vector3d direction(std::mt19937& random) {
  Eigen::Vector3d n;
  do {
    n = {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
  } while (n.norm() < 0.1 || n.norm() > 1);
  return n.normalized();
}

/// A bumpy sheet seen by a random camera from 0.3 to 2 m, and planes near it, some far off.
RandomCase random_case(unsigned seed, int points, int planes) {
  std::mt19937 random(seed);
  RandomCase result;
  SyntheticView& view = result.view;
  view.camera = {160,
                 120,
                 uniform(random, 100, 200),
                 uniform(random, 100, 200),
                 uniform(random, 60, 100),
                 uniform(random, 40, 80)};
  view.X_WC = geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(uniform(random, 0, 3), direction(random))),
      {uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, -2, 2)});
  view.mask = geometry::MaskImage(160, 120, 0);
  view.depth = geometry::DepthImage(160, 120, 0.f);
  const double distance = uniform(random, 0.3, 2);
  const double u0 = uniform(random, 20, 60), v0 = uniform(random, 20, 40);
  for (int i = 0; i < points; ++i) {
    const double u = u0 + uniform(random, 0, 60), v = v0 + uniform(random, 0, 50);
    const double z = distance * (1 + 0.1 * std::sin(u / 7) * std::cos(v / 9));
    view.cloud_W.points.push_back((view.X_WC * view.camera.unproject(u, v, z)).cast<float>());
    view.mask.at(static_cast<int>(u + 0.5), static_cast<int>(v + 0.5)) = 255;
  }
  // Of every second case something hides a part.
  if (seed % 2 == 0) {
    const int first = static_cast<int>(u0) + 40;
    hide_columns(view, first, first + 15, 0.7 * distance);
  }
  const Eigen::Vector3d center_C = view.camera.unproject(u0 + 30, v0 + 25, distance);
  for (int k = 0; k < planes; ++k) {
    const Eigen::Vector3d normal = direction(random);
    const double reach = (k % 7 == 0 ? 1.5 : 0.1) * distance;
    result.planes_C.push_back({normal, normal.dot(center_C) + uniform(random, -reach, reach)});
  }
  return result;
}

/// Removes the points that any plane brings within 2e-4 pixel of a pixel's border: single precision
/// may look those up in the neighbour, which no tolerance on sums describes.
void remove_undecided(RandomCase& c) {
  const geometry::RigidTransform X_CW = c.view.X_WC.inverse();
  const auto undecided = [&](const Eigen::Vector3f& p_W) {
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    return std::any_of(c.planes_C.begin(), c.planes_C.end(), [&](const geometry::Plane& plane) {
      const Eigen::Vector3d q = p_C - 2 * plane.signed_distance(p_C) * plane.normal;
      if (q.z() < -1e-3) return false;
      if (q.z() < 0.02) return true;  // the pixel runs away
      const Eigen::Vector2d pixel = c.view.camera.project(q);
      for (const double x : {pixel.x() + 0.5, pixel.y() + 0.5}) {
        if (std::abs(x) < 1000 && std::abs(x - std::round(x)) < 2e-4) return true;
      }
      return false;
    });
  };
  std::erase_if(c.view.cloud_W.points, undecided);
}

std::vector<Eigen::Vector3d> points_in_camera(const ObjectView& view) {
  std::vector<Eigen::Vector3d> points_C;
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  for (const auto& p_W : view.cloud_W.points) points_C.push_back(X_CW * p_W.cast<double>());
  return points_C;
}

FastVote make_fast(const ObjectView& view, const std::vector<geometry::Plane>& planes_C,
                   const VoteOptions& options) {
  return {points_in_camera(view), view.camera,
          make_seen_map(view, window_of_mirrored(view, planes_C)), options};
}

void expect_same(const VoteTally& fast, const VoteTally& reference, double relative) {
  const double n = static_cast<double>(reference.points);
  ASSERT_EQ(fast.points, reference.points);
  // Sums that are tiny beside the object are compared on its scale: 1e-9 m or 1e-6 of a point each.
  EXPECT_EQ(fast.outside_points, reference.outside_points);
  EXPECT_NEAR(fast.outside_pixels, reference.outside_pixels,
              relative * reference.outside_pixels + 1e-3);
  // Points that hide what they are mirrored from, or nearly: the sign is that of the rounding.
  EXPECT_NEAR(fast.nearer_points, reference.nearer_points, 2 + 1e-3 * n);
  EXPECT_NEAR(fast.nearer, reference.nearer, relative * reference.nearer + 1e-8 * n);
  EXPECT_NEAR(fast.outside_squared, reference.outside_squared,
              relative * reference.outside_squared + 1e-9 * n);
  EXPECT_NEAR(fast.in_front, reference.in_front, relative * reference.in_front + 1e-8 * n);
  EXPECT_NEAR(fast.coincident, reference.coincident, relative * reference.coincident + 1e-4);
  EXPECT_NEAR(fast.contradicted, reference.contradicted, relative * reference.contradicted + 1e-4);
  EXPECT_EQ(fast.unseen, reference.unseen);
  EXPECT_EQ(fast.hidden, reference.hidden);
}

class VoteAgreement : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { choose(GetParam()); }
  void TearDown() override { choose(0); }

  static void choose(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

TEST_P(VoteAgreement, WithTheReferenceOnRandomCloudsAndCameras) {
  const VoteOptions options;
  double contradicted = 0, coincident = 0, hidden = 0, unseen = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    RandomCase c = random_case(seed, seed % 3 == 0 ? 37 : 3000, 16);
    remove_undecided(c);
    const ObjectView view = c.view.view();
    const SeenImages images = reference_images(view);
    const auto fast = make_fast(view, c.planes_C, options).tallies(c.planes_C);
    for (std::size_t k = 0; k < c.planes_C.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", plane " << k);
      const VoteTally reference = reference_tally(view, images, c.planes_C[k], options);
      expect_same(fast[k], reference, 1e-5);
      contradicted += reference.contradicted;
      coincident += reference.coincident;
      hidden += reference.hidden;
      unseen += reference.unseen;
    }
  }
  // Every case of equation (3) occurred, and not just now and then.
  for (const double sum : {contradicted, coincident, hidden, unseen}) EXPECT_GT(sum, 1000);
}

TEST_P(VoteAgreement, OnARenderedBoxWithAllThirtyFiveHypotheses) {
  RandomCase c;
  c.view = synthetic_view(standing(geometry::make_box({0.06, 0.09, 0.12}), 0.3),
                          {.depth_noise = 0.001, .width = 240});
  c.planes_C = reference_hypotheses(c.view.view(), 7, 5, 0.349066);
  remove_undecided(c);
  const ObjectView view = c.view.view();
  const SeenImages images = reference_images(view);
  const auto fast = make_fast(view, c.planes_C, {}).tallies(c.planes_C);
  for (std::size_t k = 0; k < c.planes_C.size(); ++k) {
    const VoteTally reference = reference_tally(view, images, c.planes_C[k], {});
    expect_same(fast[k], reference, 1e-5);
    EXPECT_NEAR(fast[k].published_vote(), reference.published_vote(),
                1e-5 * reference.published_vote());
  }
}

std::vector<std::int64_t> targets() { return hwy::SupportedAndGeneratedTargets(); }

INSTANTIATE_TEST_SUITE_P(InstructionSets, VoteAgreement, testing::ValuesIn(targets()),
                         [](const auto& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

TEST(FastVote, SameBitsWhateverElseRuns) {
  const RandomCase c = random_case(5, 3000, 16);
  const FastVote vote = make_fast(c.view.view(), c.planes_C, {});
  const auto once = vote.tallies(c.planes_C);
  std::vector<std::vector<VoteTally>> others(4);
  std::vector<std::thread> threads;
  for (auto& other : others) threads.emplace_back([&] { other = vote.tallies(c.planes_C); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& other : others) {
    for (std::size_t k = 0; k < once.size(); ++k) {
      EXPECT_EQ(other[k].outside_squared, once[k].outside_squared);
      EXPECT_EQ(other[k].coincident, once[k].coincident);
    }
  }
}

TEST(FastVote, OnePlaneAloneGivesTheBitsItGivesAmongMany) {
  const RandomCase c = random_case(6, 2500, 5);
  const FastVote vote = make_fast(c.view.view(), c.planes_C, {});
  const auto all = vote.tallies(c.planes_C);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(vote.tally(c.planes_C[k]).contradicted, all[k].contradicted);
  }
}

TEST(SeenMap, BesideItsWindowButWithinTheImageRepeatsTheLastPixel) {
  const SyntheticView view =
      synthetic_view(standing(geometry::make_box({0.06, 0.09, 0.12}), 0), {.width = 160});
  const SeenMap map = make_seen_map(view.view(), window_round_object(view.view(), 0.1));
  EXPECT_GT(map.window.u0, 0);
  EXPECT_LT(map.window.u1, 160);
  EXPECT_EQ(map.at(map.window.u0 - 1, map.window.v0), map.at(map.window.u0, map.window.v0));
  EXPECT_LT(map.at(map.window.u0 - 1, map.window.v0 + 10), 0);
  // Where the window ends with the image, nobody looked beyond.
  const SeenMap whole = make_seen_map(view.view(), {0, 0, 160, 120});
  EXPECT_EQ(whole.at(-1, 10), 0);
  EXPECT_EQ(whole.at(160, 120), 0);
}

}  // namespace
}  // namespace prehend::shape
