#include "prehend/surface/delaunay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <random>
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
void drop_long(std::vector<Eigen::Vector3i>& triangles, const std::vector<Eigen::Vector3f>& points,
               double factor) {
  std::vector<float> lengths;
  for (const Eigen::Vector3i& t : triangles) {
    for (int k = 0; k < 3; ++k) lengths.push_back((points[t[k]] - points[t[(k + 1) % 3]]).norm());
  }
  std::nth_element(lengths.begin(), lengths.begin() + lengths.size() / 2, lengths.end());
  const double longest = factor * lengths[lengths.size() / 2];
  std::erase_if(triangles, [&](const Eigen::Vector3i& t) {
    for (int k = 0; k < 3; ++k) {
      if ((points[t[k]] - points[t[(k + 1) % 3]]).norm() > longest) return true;
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

/// Closes every loop of border edges by triangles to its centre.
void close_contours(TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  std::map<int, int> next;  // along the border, against the triangles' direction
  for (const auto& [edge, uses] : edges) {
    if (edges.count({edge.second, edge.first}) == 0) next[edge.second] = edge.first;
  }
  while (!next.empty()) {
    std::vector<int> loop;
    for (auto at = next.begin(); at != next.end();) {
      const int to = at->second;
      loop.push_back(at->first);
      next.erase(at);
      at = next.find(to);
    }
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const int i : loop) center += mesh.vertices[i] / static_cast<double>(loop.size());
    const int apex = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(center);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      mesh.triangles.emplace_back(apex, loop[i], loop[(i + 1) % loop.size()]);
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
  drop_long(triangles, points, options.longest_edge);
  if (triangles.empty()) throw InputError("every triangle has a long edge", "raise longest_edge");
  TriangleMesh mesh = largest_part(triangles, points);
  close_contours(mesh);
  return mesh;
}

}  // namespace prehend::surface
