#pragma once

#include <cstdint>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/perception/disparity_filter.h"
#include "prehend/perception/subpixel.h"

namespace prehend::perception {

/// Left image's disparity [pixels], float with sub-pixel fraction, NaN where unknown.
using DisparityImage = geometry::Image<float>;
using GreyImage = geometry::Image<std::uint8_t>;

enum class StereoMethod {
  kSemiGlobal,     // smooth surfaces and less texture, see disparity_by_sgbm
  kBlockMatching,  // OpenCV's StereoBM: about ten times faster, needs texture everywhere
};

/// Knobs of stereo matching. What greatly influences the run time: the image size and the
/// number of disparities, fx * baseline * (1 / min_depth - 1 / max_depth).
struct StereoOptions {
  StereoMethod method = StereoMethod::kSemiGlobal;
  double min_depth = 0.35;  // m, > 0; nearer points get a wrong or no disparity
  double max_depth = 2.5;   // m, > min_depth
  int block_size = 5;       // pixels, odd, 1..21: side of the matched window; kBlockMatching
                            // takes 4 more, as it has nothing else to go by
  /// kSemiGlobal: penalties of a disparity change by 1 pixel and by more, per channel and pixel of
  /// the block.
  int small_step_penalty = 8;     // > 0
  int large_step_penalty = 32;    // > small_step_penalty
  int gradient_cap = 63;          // 1..127, clips the horizontal derivative the cost is made of
  int uniqueness_percent = 5;     // 0..100: best cost must win by this margin
  int speckle_size = 200;         // pixels: smaller connected patches are dropped; 0 keeps all
  int speckle_range = 2;          // pixels of disparity within one patch
  int left_right_tolerance = 1;   // pixels; -1 switches the left-right check off
  bool eight_directions = false;  // full two-pass algorithm: better, 1.6 times slower, more memory
  /// What one-pass kSemiGlobal finds is moved to where both images agree best; others do not lag.
  SubpixelOptions subpixel;
  /// Search only disparities near which a small match finds anything, see disparity_search.h.
  bool narrow_search = false;
  /// Match from the right image as well (doubles the time): the confidence then knows of
  /// occlusions.
  bool match_both_ways = false;
  /// Edge-preserving filter guided by the left image: fills small holes, smoothes noise; see
  /// disparity_filter.h.
  bool filter = false;
  DisparityFilterOptions filter_options;
  double min_confidence = 0;  // 0..1: pixels below become unknown
};

/// What matching makes of a pair.
struct StereoMatch {
  DisparityImage disparity;
  geometry::Image<float> confidence;  // 0..1, see stereo_confidence.h
};

/// Disparities that are searched: minimum, minimum + 1, ..., minimum + count - 1 [pixels].
struct DisparityRange {
  int minimum = 0;
  int count = 0;  // a multiple of 16
};

/// The disparities that correspond to the options' depths. @throws std::invalid_argument for a bad
/// option, geometry::InputError for a camera with non-positive focal length, size or baseline.
DisparityRange disparity_range(const geometry::StereoCamera& camera, const StereoOptions& options);

/// Disparity of a rectified pair with a confidence for each pixel, as the options say. Images are
/// padded, so the left margin that other uses of OpenCV lose is matched too. Deterministic.
/// @throws std::invalid_argument for a bad option, geometry::InputError when the images' sizes
/// differ from each other or from the camera's.
StereoMatch match_stereo(const geometry::ColorImage& left, const geometry::ColorImage& right,
                         const geometry::StereoCamera& camera, const StereoOptions& options = {});
StereoMatch match_stereo(const GreyImage& left, const GreyImage& right,
                         const geometry::StereoCamera& camera, const StereoOptions& options = {});

/// The disparity of match_stereo() alone: its confidence is only computed where the options ask for
/// it (filter, min_confidence). @throws as match_stereo().
DisparityImage stereo_disparity(const geometry::ColorImage& left, const geometry::ColorImage& right,
                                const geometry::StereoCamera& camera,
                                const StereoOptions& options = {});

/// Luminance (ITU-R BT.601) of each pixel, rounded.
GreyImage grey_of(const geometry::ColorImage& image);

/// Disparity of a rectified pair by OpenCV's StereoSGBM (Hirschmueller, "Stereo Processing by
/// Semiglobal Matching and Mutual Information", PAMI 2008, with Birchfield-Tomasi costs),
/// without confidence, filter, narrowed search and subpixel steps whatever the options say. Cost:
/// about 0.15 s for 640 x 480 x 128 disparities on one core.
/// @throws std::invalid_argument for a bad option, geometry::InputError when the images' sizes
/// differ from each other or from the camera's.
DisparityImage disparity_by_sgbm(const geometry::ColorImage& left,
                                 const geometry::ColorImage& right,
                                 const geometry::StereoCamera& camera,
                                 const StereoOptions& options = {});
DisparityImage disparity_by_sgbm(const GreyImage& left, const GreyImage& right,
                                 const geometry::StereoCamera& camera,
                                 const StereoOptions& options = {});

/// Depth z = fx * baseline / disparity [m]; NaN where the disparity is NaN or not positive.
geometry::DepthImage depth_from_disparity(const DisparityImage& disparity,
                                          const geometry::StereoCamera& camera);

/// Organized cloud in the optical frame C with a point per pixel, NaN where the depth is NaN.
/// `colors` is the left image or empty. @pre sizes agree (geometry::InputError else).
geometry::PointCloud cloud_from_depth(const geometry::DepthImage& depth,
                                      const geometry::PinholeCamera& camera,
                                      const geometry::ColorImage& colors = {});

/// cloud_from_depth of depth_from_disparity.
geometry::PointCloud cloud_from_disparity(const DisparityImage& disparity,
                                          const geometry::StereoCamera& camera,
                                          const geometry::ColorImage& colors = {});

/// z of an organized cloud in C as an image; NaN where invalid.
geometry::DepthImage depth_of(const geometry::PointCloud& cloud_C);

}  // namespace prehend::perception
