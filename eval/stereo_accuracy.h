#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "prehend/perception/stereo.h"

namespace prehend::eval {

/// How a disparity image compares with the truth, over the pixels whose truth is known.
struct DisparityErrors {
  double density = 0;                      // 0..1, share that has a disparity
  std::array<double, 3> bad{};             // 0..1, of those: off by more than 1, 2, 4 pixels
  std::array<double, 3> bad_or_missing{};  // 0..1, of all
  double sure_bad = 0;                     // of the more confident half: off by more than 1 pixel
  double unsure_bad = 0;                   // of the less confident half
};

/// @param truth [pixels], NaN where unknown. `confidence` ranks the pixels; empty: by their place.
/// @throws std::invalid_argument for images of different sizes.
DisparityErrors disparity_errors(const perception::DisparityImage& found,
                                 const perception::DisparityImage& truth,
                                 const geometry::Image<float>& confidence = {});

/// One way of matching and what came out.
struct StereoRun {
  std::string method;
  DisparityErrors errors;
  double seconds = 0;  // wall time, OpenCV in one thread
};

/// A rectified pair with known disparity.
struct StereoTruth {
  geometry::ColorImage left;
  geometry::ColorImage right;
  perception::DisparityImage disparity;  // of the left image [pixels], NaN where unknown
  double smallest = 0;                   // pixels, of the disparities to search
  double largest = 0;
};

/// Reads Middlebury's 2003 format: im2.png, im6.png and disp2.png (value / 4, 0 unknown).
/// @throws geometry::InputError when a file is missing.
StereoTruth read_middlebury_2003(const std::filesystem::path& folder);

/// Plain OpenCV (StereoSGBM and StereoBM as their documentation calls them, same window and range)
/// and this library's methods on one pair.
std::vector<StereoRun> compare_stereo_methods(const StereoTruth& truth);

}  // namespace prehend::eval
