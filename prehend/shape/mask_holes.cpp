#include "prehend/shape/mask_holes.h"

#include <opencv2/imgproc.hpp>

namespace prehend::shape {

geometry::MaskImage with_holes_filled(const geometry::MaskImage& mask, double largest) {
  cv::Mat outside(mask.height, mask.width, CV_8U);
  double area = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    outside.data[i] = mask.data[i] ? 0 : 255;
    area += mask.data[i] != 0;
  }
  cv::Mat labels, statistics, centers;
  const int count = cv::connectedComponentsWithStats(outside, labels, statistics, centers, 4);
  std::vector<bool> fill(count, false);
  for (int label = 1; label < count; ++label) {
    const int* s = statistics.ptr<int>(label);
    const bool reaches_border = s[cv::CC_STAT_LEFT] == 0 || s[cv::CC_STAT_TOP] == 0 ||
                                s[cv::CC_STAT_LEFT] + s[cv::CC_STAT_WIDTH] == mask.width ||
                                s[cv::CC_STAT_TOP] + s[cv::CC_STAT_HEIGHT] == mask.height;
    fill[label] = !reaches_border && s[cv::CC_STAT_AREA] <= largest * area;
  }
  geometry::MaskImage filled = mask;
  for (std::size_t i = 0; i < filled.data.size(); ++i) {
    if (fill[labels.at<int>(static_cast<int>(i / mask.width), static_cast<int>(i % mask.width))]) {
      filled.data[i] = 255;
    }
  }
  return filled;
}

}  // namespace prehend::shape
