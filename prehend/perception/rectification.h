#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/perception/calibration.h"

namespace prehend::perception {

struct RectifiedPair {
  geometry::ColorImage left;
  geometry::ColorImage right;
  geometry::StereoCamera camera;
};

/// How images of the given size [pixels] are rectified: as the calibration says
/// (`calibration.rectification`), unturned when it `is_rectified()`, else by OpenCV's stereoRectify
/// (zero disparity at infinity, only valid pixels).
/// @throws geometry::InputError when the size is not the calibration's, or when the right camera is
/// displaced more vertically than horizontally, or to the left.
StereoRectification rectification(const StereoCalibration& calibration, int width, int height);

/// Takes distortion and rotation out of one camera's images, one after the other; the maps are
/// computed once, when it is made (some 10 ms). Copies share them.
class ImageRectifier {
 public:
  /// @param K, distortion of the raw image. @param R p_rectified = R p_C.
  /// @param rectified camera of the result, of the raw image's size.
  ImageRectifier(const Eigen::Matrix3d& K, const std::vector<double>& distortion,
                 const Eigen::Matrix3d& R, const geometry::PinholeCamera& rectified);
  /// Bilinear; black where the raw image has nothing. @throws geometry::InputError for another
  /// size.
  geometry::ColorImage operator()(const geometry::ColorImage& image) const;
  /// The nearest pixel's, as depths on either side of an edge have no mean; NaN where the raw image
  /// has nothing. @pre R is the identity, else z is another one.
  geometry::DepthImage operator()(const geometry::DepthImage& depth) const;

 private:
  struct Maps;
  void check_size(int width, int height) const;

  std::shared_ptr<const Maps> maps_;
};

/// Turns raw pairs of a camera into ones whose rows correspond and whose distortion is gone, by
/// rectification() and an ImageRectifier each. The images are passed through when the calibration
/// needs no rectification.
class PairRectifier {
 public:
  /// @throws geometry::InputError as rectification().
  PairRectifier(const StereoCalibration& calibration, int width, int height);
  const geometry::StereoCamera& camera() const { return camera_; }
  /// @throws geometry::InputError when the images' sizes differ from each other or the calibration.
  RectifiedPair operator()(const geometry::ColorImage& left,
                           const geometry::ColorImage& right) const;

 private:
  geometry::StereoCamera camera_;
  std::optional<ImageRectifier> left_;  // absent: nothing to do
  std::optional<ImageRectifier> right_;
};

/// The same for one pair: the maps are computed on each call.
/// @throws geometry::InputError as PairRectifier.
RectifiedPair rectify(const geometry::ColorImage& left, const geometry::ColorImage& right,
                      const StereoCalibration& calibration);

}  // namespace prehend::perception
