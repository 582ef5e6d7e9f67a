#include "prehend/perception/supports.h"

#include <algorithm>
#include <cstddef>

#include "prehend/geometry/errors.h"
#include "prehend/perception/cloud_partition.h"

namespace prehend::perception {
namespace {

constexpr double kStands = 0.025;  // m: what begins lower stands on the table
constexpr double kBeside = 0.03;   // m round a footprint, in which the carrier's top is looked for
constexpr double kOver = 0.015;    // m that a carrier's top may seem to be over what stands on it
constexpr double kLeastThick = 0.005;  // m that what stands on something rises over it
constexpr double kGap = 0.03;          // m under the lowest seen points that are not seen of it
constexpr std::size_t kLeast = 20;     // points that show a top

double quantile(std::vector<double> values, double q) {
  const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

}  // namespace

std::vector<double> support_heights(const std::vector<const geometry::PointCloud*>& clouds_W,
                                    const geometry::Plane& table_W) {
  std::vector<double> supports;
  for (const geometry::PointCloud* cloud : clouds_W) {
    double support = 0;
    std::vector<double> heights;
    for (const Eigen::Vector3f& p : cloud->points) {
      heights.push_back(table_W.signed_distance(p.cast<double>()));
    }
    const double highest = heights.empty() ? 0 : quantile(heights, 0.98);
    const double lowest = heights.empty() ? 0 : quantile(std::move(heights), 0.02);
    if (lowest > kStands) {
      try {
        const PlaneOutline footprint(table_W, cloud->points);
        for (const geometry::PointCloud* other : clouds_W) {
          if (other == cloud) continue;
          std::vector<double> under;
          for (const Eigen::Vector3f& p : other->points) {
            const Eigen::Vector3d at = p.cast<double>();
            if (footprint.contains(at, kBeside)) under.push_back(table_W.signed_distance(at));
          }
          if (under.size() < kLeast) continue;
          const double top = quantile(std::move(under), 0.97);
          if (top < lowest + kOver && top > lowest - kGap && top < highest - kLeastThick) {
            support = std::max(support, top);
          }
        }
      } catch (const geometry::InputError&) {
        // A line has no footprint to stand on.
      }
    }
    supports.push_back(support);
  }
  return supports;
}

}  // namespace prehend::perception
