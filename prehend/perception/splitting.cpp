#include "prehend/perception/splitting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "prehend/perception/mean_color.h"
#include "prehend/perception/organized_components.h"

namespace prehend::perception {
namespace {

using geometry::PointCloud;

constexpr int kUnassigned = -1;  // a member on no part
constexpr int kOutside = -2;     // no member
constexpr double kJump = 3;      // patches: a larger step between patch centres is no surface

void check(const SplitOptions& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("SplitOptions: ") + what);
  };
  require(std::isfinite(o.patch) && o.patch > 0, "patch must be positive");
  require(o.min_crease > 0 && o.min_crease < 3.14, "min_crease must be in (0, pi)");
  require(o.min_share > 0 && o.min_share <= 0.5, "min_share must be in (0, 0.5]");
  require(o.min_color_difference >= 0, "min_color_difference must not be negative");
}

// The cluster cut out of the image, with sums for means over rectangles in constant time.
class Patches {
 public:
  Patches(const PointCloud& cloud, const std::vector<int>& members) {
    left_ = top_ = std::numeric_limits<int>::max();
    int right = 0, bottom = 0;
    for (const int i : members) {
      left_ = std::min(left_, i % cloud.width);
      right = std::max(right, i % cloud.width);
      top_ = std::min(top_, i / cloud.width);
      bottom = std::max(bottom, i / cloud.width);
    }
    width_ = right - left_ + 1;
    height_ = bottom - top_ + 1;
    sums_.assign(static_cast<std::size_t>(width_ + 1) * (height_ + 1), Eigen::Vector4d::Zero());
    for (const int i : members) {
      const Eigen::Vector3f& p = cloud.points[i];
      sum(i % cloud.width - left_ + 1, i / cloud.width - top_ + 1) << p.cast<double>(), 1;
    }
    for (int v = 1; v <= height_; ++v) {
      for (int u = 1; u <= width_; ++u) {
        sum(u, v) += sum(u - 1, v) + sum(u, v - 1) - sum(u - 1, v - 1);
      }
    }
  }

  // Mean of the cluster's points within `reach` pixels of (u, v); false where few are.
  bool mean(int u, int v, int reach, Eigen::Vector3d& result) const {
    const int u0 = std::clamp(u - reach - left_, 0, width_);
    const int u1 = std::clamp(u + reach + 1 - left_, 0, width_);
    const int v0 = std::clamp(v - reach - top_, 0, height_);
    const int v1 = std::clamp(v + reach + 1 - top_, 0, height_);
    const Eigen::Vector4d total = sum(u1, v1) - sum(u0, v1) - sum(u1, v0) + sum(u0, v0);
    const double side = 2 * reach + 1;
    if (total.w() < 0.4 * side * side) return false;
    result = total.head<3>() / total.w();
    return true;
  }

  // Unit normal towards the camera of the surface round (u, v).
  bool normal(int u, int v, int reach, Eigen::Vector3d& result) const {
    const int half = std::max(reach / 2, 1);
    Eigen::Vector3d left, right, up, down;
    if (!mean(u - reach, v, half, left) || !mean(u + reach, v, half, right) ||
        !mean(u, v - reach, half, up) || !mean(u, v + reach, half, down)) {
      return false;
    }
    result = (down - up).cross(right - left);
    if (result.norm() < 1e-12) return false;
    result.normalize();
    if (result.dot(left) > 0) result = -result;
    return true;
  }

 private:
  Eigen::Vector4d& sum(int u, int v) {
    return sums_[static_cast<std::size_t>(v) * (width_ + 1) + u];
  }
  const Eigen::Vector4d& sum(int u, int v) const {
    return sums_[static_cast<std::size_t>(v) * (width_ + 1) + u];
  }

  int left_ = 0, top_ = 0, width_ = 0, height_ = 0;
  std::vector<Eigen::Vector4d> sums_;  // (x, y, z, count)
};

// Whether the surface bends inwards between two points of it: the normals lean towards each other.
bool concave(const Eigen::Vector3d& p, const Eigen::Vector3d& n_p, const Eigen::Vector3d& q,
             const Eigen::Vector3d& n_q, double min_crease, double max_step) {
  const Eigen::Vector3d along = q - p;
  if (along.norm() > max_step || along.norm() < 1e-9) return false;
  const double bend = std::acos(std::clamp(n_p.dot(n_q), -1.0, 1.0));
  return bend > min_crease && along.normalized().dot(n_q - n_p) < -0.5 * min_crease;
}

// Members that are not on an inward crease.
std::vector<int> off_creases(const PointCloud& cloud, const std::vector<int>& members,
                             const Patches& patches, int reach, const SplitOptions& options) {
  std::vector<int> kept;
  for (const int i : members) {
    const int u = i % cloud.width, v = i / cloud.width;
    bool crease = false;
    for (const auto& [du, dv] : {std::pair{reach, 0}, std::pair{0, reach}}) {
      Eigen::Vector3d p, q, n_p, n_q;
      if (!patches.mean(u - du, v - dv, reach / 2, p) ||
          !patches.mean(u + du, v + dv, reach / 2, q) ||
          !patches.normal(u - du, v - dv, reach, n_p) ||
          !patches.normal(u + du, v + dv, reach, n_q)) {
        continue;
      }
      crease = crease || concave(p, n_p, q, n_q, options.min_crease, kJump * options.patch);
    }
    if (!crease) kept.push_back(i);
  }
  return kept;
}

// Parts grown over the cluster's pixels, and how they meet.
struct Regions {
  std::vector<int> owner;                  // of each pixel of the image; negative: none
  std::vector<std::vector<int>> creased;   // parts x parts: contacts with a crease between
  std::vector<std::vector<int>> straight;  // contacts without: a step in depth
};

// What is on no part goes to the part it is reached from first, ring by ring.
Regions grown(const PointCloud& cloud, const std::vector<int>& members,
              const std::vector<std::vector<int>>& parts) {
  const std::size_t n = parts.size();
  Regions regions;
  regions.owner.assign(cloud.size(), kOutside);
  regions.creased.assign(n, std::vector<int>(n, 0));
  regions.straight = regions.creased;
  std::vector<char> is_seed(cloud.size(), 0);
  for (const int i : members) regions.owner[i] = kUnassigned;
  std::vector<int> front;
  for (std::size_t k = 0; k < n; ++k) {
    for (const int i : parts[k]) {
      regions.owner[i] = static_cast<int>(k);
      is_seed[i] = 1;
      front.push_back(i);
    }
  }
  while (!front.empty()) {
    std::vector<int> next;
    for (const int i : front) {
      const int u = i % cloud.width, v = i / cloud.width;
      for (const auto& [du, dv] :
           {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
        if (u + du < 0 || u + du >= cloud.width || v + dv < 0 || v + dv >= cloud.height) continue;
        const int j = i + dv * cloud.width + du;
        if (regions.owner[j] == kUnassigned) {
          regions.owner[j] = regions.owner[i];
          next.push_back(j);
        } else if (regions.owner[j] >= 0 && regions.owner[j] != regions.owner[i]) {
          auto& contacts = is_seed[i] && is_seed[j] ? regions.straight : regions.creased;
          ++contacts[regions.owner[i]][regions.owner[j]];
          ++contacts[regions.owner[j]][regions.owner[i]];
        }
      }
    }
    front = std::move(next);
  }
  return regions;
}

// The object each part belongs to: parts stay apart that meet in a crease more than in a step (as
// rim and far inside of a bowl do) and differ in colour.
std::vector<int> objects_of(const PointCloud& cloud, const std::vector<std::vector<int>>& parts,
                            const Regions& regions, const SplitOptions& options) {
  const bool colored = options.min_color_difference > 0 && cloud.colors.size() == cloud.size();
  std::vector<Eigen::Vector3d> colors;
  if (colored) {
    for (const auto& part : parts) colors.push_back(mean_color(cloud, part));
  }
  std::vector<int> name(parts.size());
  std::iota(name.begin(), name.end(), 0);
  for (std::size_t a = 0; a < parts.size(); ++a) {
    for (std::size_t b = a + 1; b < parts.size(); ++b) {
      const bool like = colored && (colors[a] - colors[b]).norm() < options.min_color_difference;
      if (!like && regions.straight[a][b] <= regions.creased[a][b]) continue;
      const int from = std::max(name[a], name[b]), to = std::min(name[a], name[b]);
      std::replace(name.begin(), name.end(), from, to);
    }
  }
  return name;
}

}  // namespace

std::vector<std::vector<int>> split_touching(const PointCloud& cloud_C,
                                             const geometry::PinholeCamera& camera,
                                             const std::vector<int>& members,
                                             const SplitOptions& options) {
  check(options);
  if (!cloud_C.organized()) {
    throw std::invalid_argument("split_touching: the cloud is not organized");
  }
  if (members.empty()) return {};
  double depth = 0;
  for (const int i : members) depth += static_cast<double>(cloud_C.points[i].z());
  depth /= static_cast<double>(members.size());
  const int reach = std::clamp(
      static_cast<int>(std::lround(0.5 * options.patch * camera.fx / std::max(depth, 1e-3))), 2,
      20);
  const std::vector<int> kept =
      off_creases(cloud_C, members, Patches(cloud_C, members), reach, options);
  const int least =
      std::max(1, static_cast<int>(options.min_share * static_cast<double>(members.size())));
  const std::vector<std::vector<int>> parts =
      organized_components(cloud_C, kept, options.patch, 1, least);
  if (parts.size() < 2) return {members};

  const Regions regions = grown(cloud_C, members, parts);
  const std::vector<int> name = objects_of(cloud_C, parts, regions, options);
  std::vector<std::vector<int>> result(parts.size());
  // What no part reaches goes to the largest.
  for (const int i : members) result[name[std::max(regions.owner[i], 0)]].push_back(i);
  std::erase_if(result, [](const auto& part) { return part.empty(); });
  std::stable_sort(result.begin(), result.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return result;
}

}  // namespace prehend::perception
