#include "prehend/motion/ball_cover.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/motion/convex_faces.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using Faces = std::vector<geometry::Plane>;

constexpr double kMostCells = 20000;
constexpr int kProjections = 20;
constexpr double kLeastRadius = 1e-6;  // m

/// Whether one of the faces has the whole cell (half sides `half`) outside.
bool is_apart(const Faces& faces, const Vector3d& center, const Vector3d& half) {
  return std::any_of(faces.begin(), faces.end(), [&](const geometry::Plane& face) {
    return face.signed_distance(center) > face.normal.cwiseAbs().dot(half);
  });
}

/// The face that the point is farthest outside of (least inside).
const geometry::Plane& nearest_face(const Faces& faces, const Vector3d& p) {
  return *std::max_element(faces.begin(), faces.end(),
                           [&p](const geometry::Plane& a, const geometry::Plane& b) {
                             return a.signed_distance(p) < b.signed_distance(p);
                           });
}

/// By Pythagoras a step across a face comes nearer to all that is behind it. Nothing when nothing
/// of the body is in the ball.
std::optional<Ball> pull_in(const Faces& faces, Ball ball) {
  double squared = ball.radius * ball.radius;
  for (int k = 0; k < kProjections; ++k) {
    const geometry::Plane& face = nearest_face(faces, ball.center);
    const double outside = face.signed_distance(ball.center);
    if (!(outside > 0)) break;
    ball.center -= outside * face.normal;
    squared -= outside * outside;
  }
  if (squared < -kLeastRadius * kLeastRadius) return std::nullopt;
  ball.radius = std::max(kLeastRadius, std::sqrt(std::max(0.0, squared)));
  return ball;
}

void cover(const geometry::TriangleMesh& piece, double resolution, BallCover& result) {
  const ConvexFaces convex = convex_faces("piece to be covered", piece);
  const Vector3d low = convex.bounds.min(), size = convex.bounds.sizes();
  const Vector3d counts = (size / resolution).array().ceil().max(1);
  if (!(counts.prod() <= kMostCells)) {
    throw geometry::InputError(
        "A piece of " + std::to_string(size.maxCoeff()) + " m needs more than 20000 cells",
        "Take a coarser resolution");
  }
  const Vector3d cell = size.cwiseQuotient(counts);
  const double radius = cell.norm() / 2;
  const Eigen::Vector3i count = counts.cast<int>();
  for (int z = 0; z < count.z(); ++z) {
    for (int y = 0; y < count.y(); ++y) {
      for (int x = 0; x < count.x(); ++x) {
        const Vector3d center = low + Vector3d(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(cell);
        if (is_apart(convex.faces, center, cell / 2)) continue;
        const double outside = nearest_face(convex.faces, center).signed_distance(center);
        if (outside < -radius) continue;  // nothing of the surface is in it
        const std::optional<Ball> ball = pull_in(convex.faces, {center, radius});
        if (!ball) continue;
        result.balls.push_back(*ball);
        result.overshoot = std::max(result.overshoot, ball->radius + std::min(0.0, outside));
      }
    }
  }
}

}  // namespace

BallCover cover_convex_pieces(const std::vector<geometry::TriangleMesh>& pieces,
                              double resolution) {
  if (!(resolution > 0) || !std::isfinite(resolution)) {
    throw std::invalid_argument("cover_convex_pieces: the resolution must be positive");
  }
  BallCover result;
  for (const geometry::TriangleMesh& piece : pieces) cover(piece, resolution, result);
  return result;
}

}  // namespace prehend::motion
