#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "prehend/perception/segmentation.h"
#include "prehend/perception/segmented_scene.h"
#include "prehend/simulation/stereo_renderer.h"

namespace prehend::eval {

/// How found objects compare with the true ones.
struct SegmentationErrors {
  int truths = 0;  // objects that are there
  int found = 0;   // objects that were found
  int missed = 0;  // of the truths: no mask covers half of it
  int merged = 0;  // of the found: covers half of two truths or more
  int split = 0;   // of the truths: two masks or more lie mostly on it
  double iou = 0;  // mean over the truths of the best mask's intersection over union
};

/// @param labels of each pixel: 0, 1, ... the true objects, negative: none. Objects with under
/// `least` pixels do not count. @param masks of the found ones, of the same size.
/// @throws std::invalid_argument for images of different sizes.
SegmentationErrors segmentation_errors(const std::vector<geometry::MaskImage>& masks,
                                       const geometry::Image<std::int16_t>& labels,
                                       int least = 100);

/// Adds counts; the overlap is averaged over all truths.
SegmentationErrors operator+(const SegmentationErrors& a, const SegmentationErrors& b);

/// The masks of the objects that were found.
std::vector<geometry::MaskImage> masks_of(const perception::SegmentedScene& scene);

/// How far measured depth is from the truth, on the pixels of true objects.
struct DepthErrors {
  std::vector<double> off;  // m, |depth - truth|, of pixels that have a depth
  double missing = 0;       // pixels without
  double pixels = 0;        // all

  void add(const geometry::DepthImage& depth, const simulation::StereoImages& truth);
  double median() const;  // m; NaN: there is no depth
  double missing_share() const { return pixels > 0 ? missing / pixels : 0; }
};

/// One condition (texture, light, stereo or segmentation method) over several scenes.
struct SegmentationRun {
  std::string condition;
  SegmentationErrors errors;
  double depth_error = 0;    // m, median over object pixels of |depth - truth|; NaN: unknown
  double depth_missing = 0;  // 0..1, of the object pixels
  double seconds = 0;        // of matching and segmentation, mean over the scenes
};

/// Rendered scenes of several household objects each, some close together, for each texture
/// contrast and light, and for the knobs of perception at the middle ones. `scenes` at a time.
std::vector<SegmentationRun> rendered_segmentation(
    int scenes, std::uint64_t seed, const perception::SegmentationOptions& segmentation = {});

/// The labelled recordings of the Object Segmentation Database in `folder` (*.pcd), with each way
/// of clustering, whole and split. Empty when there are none.
std::vector<SegmentationRun> labelled_segmentation(const std::filesystem::path& folder);

}  // namespace prehend::eval
