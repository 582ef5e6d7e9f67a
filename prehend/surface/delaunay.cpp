#include "prehend/surface/delaunay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/surface/point_order.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;

/// Up to `count` of the finite points before the camera, the same for any order of the cloud.
std::vector<Eigen::Vector3f> drawn(const geometry::PointCloud& cloud_W,
                                   const geometry::RigidTransform& X_CW, int count,
                                   std::uint64_t seed) {
  std::vector<Eigen::Vector3f> points;
  for (const Eigen::Vector3f& p : cloud_W.points) {
    if (geometry::is_finite(p) && (X_CW * p.cast<double>()).z() > 0) points.push_back(p);
  }
  std::vector<int> order = canonical_order(points);
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3f> chosen;
  for (std::size_t i = 0; i < order.size() && chosen.size() < static_cast<std::size_t>(count);
       ++i) {
    std::swap(order[i], order[i + random() % (order.size() - i)]);
    chosen.push_back(points[order[i]]);
  }
  return chosen;
}

/// Delaunay triangles of points in the image, counter-clockwise as the camera sees them (y down).
std::vector<Eigen::Vector3i> triangulated(const std::vector<cv::Point2f>& pixels) {
  cv::Point2f least = pixels.front();
  cv::Point2f most = pixels.front();
  for (const cv::Point2f& p : pixels) {
    least = {std::min(least.x, p.x), std::min(least.y, p.y)};
    most = {std::max(most.x, p.x), std::max(most.y, p.y)};
  }
  const int width = static_cast<int>(std::ceil(most.x - least.x)) + 20;
  const int height = static_cast<int>(std::ceil(most.y - least.y)) + 20;
  cv::Subdiv2D subdivision(cv::Rect(static_cast<int>(std::floor(least.x)) - 10,
                                    static_cast<int>(std::floor(least.y)) - 10, width, height));
  std::map<std::pair<float, float>, int> index_of;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!index_of.emplace(std::pair(pixels[i].x, pixels[i].y), static_cast<int>(i)).second)
      continue;
    subdivision.insert(pixels[i]);
  }
  std::vector<cv::Vec6f> corners;
  subdivision.getTriangleList(corners);
  std::vector<Eigen::Vector3i> triangles;
  for (const cv::Vec6f& c : corners) {
    const auto a = index_of.find({c[0], c[1]});
    const auto b = index_of.find({c[2], c[3]});
    const auto d = index_of.find({c[4], c[5]});
    if (a == index_of.end() || b == index_of.end() || d == index_of.end()) continue;
    const double area = (static_cast<double>(c[2]) - c[0]) * (static_cast<double>(c[5]) - c[1]) -
                        (static_cast<double>(c[4]) - c[0]) * (static_cast<double>(c[3]) - c[1]);
    if (area == 0) continue;
    triangles.emplace_back(a->second, area < 0 ? b->second : d->second,
                           area < 0 ? d->second : b->second);
  }
  return triangles;
}

/// Without the triangles that have an edge over `factor` times the median edge.
template <class Length>
void drop_long(std::vector<Eigen::Vector3i>& triangles, double factor, const Length& length) {
  std::vector<double> lengths;
  for (const Eigen::Vector3i& t : triangles) {
    for (int k = 0; k < 3; ++k) lengths.push_back(length(t[k], t[(k + 1) % 3]));
  }
  if (lengths.empty()) return;
  std::nth_element(lengths.begin(), lengths.begin() + lengths.size() / 2, lengths.end());
  const double longest = factor * lengths[lengths.size() / 2];
  std::erase_if(triangles, [&](const Eigen::Vector3i& t) {
    for (int k = 0; k < 3; ++k) {
      if (length(t[k], t[(k + 1) % 3]) > longest) return true;
    }
    return false;
  });
}

int root_of(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

void join(std::vector<int>& parent, int a, int b) {
  a = root_of(parent, a);
  b = root_of(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

/// The triangles that hang together by edges with the most others. Where parts of it meet in a
/// point only, each gets a vertex of its own.
TriangleMesh largest_part(const std::vector<Eigen::Vector3i>& triangles,
                          const std::vector<Eigen::Vector3f>& points) {
  const int count = static_cast<int>(triangles.size());
  std::vector<int> part(count);
  std::vector<int> fan(3 * static_cast<std::size_t>(count));  // corners that share a vertex
  std::iota(part.begin(), part.end(), 0);
  std::iota(fan.begin(), fan.end(), 0);
  std::map<std::pair<int, int>, int> corner_at;  // corner 3 t + k of directed edge (t[k], t[k+1])
  for (int t = 0; t < count; ++t) {
    for (int k = 0; k < 3; ++k) corner_at[{triangles[t][k], triangles[t][(k + 1) % 3]}] = 3 * t + k;
  }
  for (const auto& [edge, corner] : corner_at) {
    const auto other = corner_at.find({edge.second, edge.first});
    if (other == corner_at.end()) continue;
    const auto next = [](int c) { return c - c % 3 + (c + 1) % 3; };
    join(part, corner / 3, other->second / 3);
    join(fan, corner, next(other->second));
    join(fan, next(corner), other->second);
  }
  std::vector<int> size(count, 0);
  for (int t = 0; t < count; ++t) ++size[root_of(part, t)];
  const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  TriangleMesh mesh;
  std::map<int, int> vertex_of_fan;
  for (int t = 0; t < count; ++t) {
    if (root_of(part, t) != largest) continue;
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      const auto [found, is_new] = vertex_of_fan.try_emplace(
          root_of(fan, 3 * t + k), static_cast<int>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(points[triangles[t][k]].cast<double>());
      triangle[k] = found->second;
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

using Edges = std::set<std::pair<int, int>>;

/// Triangles between the vertices of a closed `loop` of border edges, in its direction: of all
/// ways to span them, the one with the least area. Chords that are edges of the mesh already would
/// join four triangles, and triangles that are turned over in the image would lie outside the
/// contour; both are taken only where nothing else closes it. Dynamic programming over the loop's
/// pieces (Barequet and Sharir, "Filling gaps in the boundary of a polyhedron", CAGD 1995).
class SpannedLoop {
 public:
  SpannedLoop(const std::vector<int>& loop, const TriangleMesh& mesh,
              const std::vector<Eigen::Vector2d>& pixels, const Edges& edges)
      : loop_(loop), mesh_(mesh), pixels_(pixels), edges_(edges), count_(loop.size()) {
    double twice = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Eigen::Vector2d& p = pixels_[loop_[i]];
      const Eigen::Vector2d& q = pixels_[loop_[(i + 1) % count_]];
      twice += p.x() * q.y() - p.y() * q.x();
    }
    turn_ = twice < 0 ? -1 : 1;
  }

  std::vector<Eigen::Vector3i> triangles() {
    Eigen::AlignedBox3d box;
    for (const int i : loop_) box.extend(mesh_.vertices[i]);
    turned_over_ = box.diagonal().squaredNorm() * static_cast<double>(count_);
    shared_ = turned_over_ * static_cast<double>(count_);
    cost_.assign(count_ * count_, 0.0);
    middle_.assign(count_ * count_, 0);
    for (std::size_t length = 2; length < count_; ++length) {
      for (std::size_t i = 0; i + length < count_; ++i) span(i, i + length);
    }
    std::vector<Eigen::Vector3i> result;
    collect(0, count_ - 1, result);
    return result;
  }

 private:
  // The best triangle over the chord from i to k.
  void span(std::size_t i, std::size_t k) {
    double& best = cost_[i * count_ + k];
    best = std::numeric_limits<double>::infinity();
    for (std::size_t j = i + 1; j < k; ++j) {
      const double cost = cost_[i * count_ + j] + cost_[j * count_ + k] + triangle_cost(i, j, k);
      if (cost >= best) continue;
      best = cost;
      middle_[i * count_ + k] = j;
    }
    const bool is_border = i == 0 && k + 1 == count_;
    if (!is_border && edges_.count(std::minmax(loop_[i], loop_[k])) > 0) best += shared_;
  }

  double triangle_cost(std::size_t i, std::size_t j, std::size_t k) const {
    const Eigen::Vector3d& a = mesh_.vertices[loop_[i]];
    const Eigen::Vector3d ab = mesh_.vertices[loop_[j]] - a, ac = mesh_.vertices[loop_[k]] - a;
    const Eigen::Vector2d p = pixels_[loop_[j]] - pixels_[loop_[i]];
    const Eigen::Vector2d q = pixels_[loop_[k]] - pixels_[loop_[i]];
    const bool turned_over = turn_ * (p.x() * q.y() - p.y() * q.x()) < 0;
    return 0.5 * ab.cross(ac).norm() + (turned_over ? turned_over_ : 0);
  }

  void collect(std::size_t first, std::size_t last, std::vector<Eigen::Vector3i>& result) const {
    std::vector<std::pair<std::size_t, std::size_t>> chords{{first, last}};
    while (!chords.empty()) {
      const auto [i, k] = chords.back();
      chords.pop_back();
      if (k < i + 2) continue;
      const std::size_t j = middle_[i * count_ + k];
      result.emplace_back(loop_[i], loop_[j], loop_[k]);
      chords.emplace_back(i, j);
      chords.emplace_back(j, k);
    }
  }

  const std::vector<int>& loop_;
  const TriangleMesh& mesh_;
  const std::vector<Eigen::Vector2d>& pixels_;
  const Edges& edges_;
  std::size_t count_;
  double turn_ = 1;                      // sign of the loop's area in the image
  double turned_over_ = 0, shared_ = 0;  // m^2, more than any area of the loop
  std::vector<double> cost_;             // count x count: of the piece from i to k [m^2]
  std::vector<std::size_t> middle_;      // count x count: third corner over the chord from i to k
};

/// Closes every loop of border edges by triangles between its vertices, without new ones.
/// `pixels`: of the vertices.
void close_contours(TriangleMesh& mesh, const std::vector<Eigen::Vector2d>& pixels) {
  std::set<std::pair<int, int>> directed;
  Edges edges;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      directed.emplace(t[k], t[(k + 1) % 3]);
      edges.insert(std::minmax(t[k], t[(k + 1) % 3]));
    }
  }
  std::map<int, int> next;  // along the border, against the triangles' direction
  for (const auto& [from, to] : directed) {
    if (directed.count({to, from}) == 0) next[to] = from;
  }
  while (!next.empty()) {
    std::vector<int> loop;
    for (auto at = next.begin(); at != next.end();) {
      const int to = at->second;
      loop.push_back(at->first);
      next.erase(at);
      at = next.find(to);
    }
    for (const Eigen::Vector3i& t : SpannedLoop(loop, mesh, pixels, edges).triangles()) {
      mesh.triangles.push_back(t);
    }
  }
}

}  // namespace

TriangleMesh delaunay_surface(const geometry::PointCloud& cloud_W,
                              const geometry::PinholeCamera& camera,
                              const geometry::RigidTransform& X_WC,
                              const DelaunayOptions& options) {
  if (options.samples < 3) throw std::invalid_argument("DelaunayOptions.samples must be >= 3");
  if (!(options.longest_edge > 1)) {
    throw std::invalid_argument("DelaunayOptions.longest_edge must be > 1");
  }
  const geometry::RigidTransform X_CW = X_WC.inverse(Eigen::Isometry);
  const std::vector<Eigen::Vector3f> points = drawn(cloud_W, X_CW, options.samples, options.seed);
  const std::string mend = "segment the object again";
  if (points.size() < 3) throw InputError("fewer than three points are before the camera", mend);
  std::vector<cv::Point2f> pixels;
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector2d pixel = camera.project(X_CW * p.cast<double>());
    if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) {
      throw InputError("a point projects far beyond the image", "check the camera and its pose");
    }
    pixels.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  }
  std::vector<Eigen::Vector3i> triangles = triangulated(pixels);
  if (triangles.empty()) throw InputError("all points lie on a line of the image", mend);
  drop_long(triangles, options.longest_edge, [&](int i, int k) {
    return std::hypot(pixels[i].x - pixels[k].x, pixels[i].y - pixels[k].y);
  });
  drop_long(triangles, options.longest_edge,
            [&](int i, int k) { return (points[i] - points[k]).norm(); });
  if (triangles.empty()) throw InputError("every triangle has a long edge", "raise longest_edge");
  TriangleMesh mesh = largest_part(triangles, points);
  std::vector<Eigen::Vector2d> projected;
  for (const Eigen::Vector3d& p_W : mesh.vertices) projected.push_back(camera.project(X_CW * p_W));
  close_contours(mesh, projected);
  return mesh;
}

}  // namespace prehend::surface
