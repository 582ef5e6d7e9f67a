#include "prehend/perception/seen_width.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace prehend::perception {

Eigen::Vector2d sides_over_plane(const geometry::PointCloud& cloud_C,
                                 const std::vector<int>& members, const geometry::Plane& plane_C) {
  if (members.empty()) return Eigen::Vector2d::Zero();
  const Eigen::Vector3d z = plane_C.normal.normalized();
  const Eigen::Vector3d x = z.unitOrthogonal();
  Eigen::Matrix<float, 2, 3> onto_plane;
  onto_plane << x.cast<float>().transpose(), z.cross(x).cast<float>().transpose();
  std::vector<cv::Point2f> points;
  points.reserve(members.size());
  for (const int i : members) {
    const Eigen::Vector2f p = onto_plane * cloud_C.points[i];
    points.emplace_back(p.x(), p.y());
  }
  const cv::Size2f size = cv::minAreaRect(points).size;
  return {std::min(size.width, size.height), std::max(size.width, size.height)};
}

}  // namespace prehend::perception
