#include "prehend/perception/mean_color.h"

#include <limits>

#include <opencv2/imgproc.hpp>

namespace prehend::perception {

Eigen::Vector3d mean_color(const geometry::PointCloud& cloud, const std::vector<int>& members) {
  cv::Mat colors(static_cast<int>(members.size()), 1, CV_8UC3);
  for (std::size_t k = 0; k < members.size(); ++k) {
    const geometry::Rgb& c = cloud.colors[members[k]];
    colors.at<cv::Vec3b>(static_cast<int>(k), 0) = {c[0], c[1], c[2]};
  }
  cv::cvtColor(colors, colors, cv::COLOR_RGB2Lab);
  const cv::Scalar mean = cv::mean(colors);
  return {mean[0], mean[1], mean[2]};
}

double color_difference(const geometry::PointCloud& cloud, const std::vector<int>& a,
                        const std::vector<int>& b) {
  if (cloud.colors.size() != cloud.size() || a.empty() || b.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  return (mean_color(cloud, a) - mean_color(cloud, b)).norm();
}

double hue_difference(const geometry::PointCloud& cloud, const std::vector<int>& a,
                      const std::vector<int>& b) {
  if (cloud.colors.size() != cloud.size() || a.empty() || b.empty()) return 0;
  const auto hue = [&](const std::vector<int>& members) {
    constexpr double kGrey = 128;
    constexpr double kLevels = 2.55;  // of L*, as 8 bits hold it
    const Eigen::Vector3d lab = mean_color(cloud, members);
    return Eigen::Vector2d((lab.tail<2>().array() - kGrey) / (lab[0] / kLevels + 16));
  };
  return (hue(a) - hue(b)).norm();
}

}  // namespace prehend::perception
