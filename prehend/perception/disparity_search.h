#pragma once

#include "prehend/geometry/camera_model.h"
#include "prehend/perception/stereo.h"

namespace prehend::perception {

/// Of the disparities that `options` allow, those between which anything is seen: a pair of a
/// quarter of the size is matched by semi-global matching, and the range that its patches cover is
/// widened by kSearchMargin. Matching costs as much as it searches disparities; the demo's table
/// covers 160 of the 256 from 0.35 to 2.5 m.
///
/// What this can lose is what a quarter of the size does not show: a patch of fewer than
/// StereoOptions::speckle_size pixels, which matching drops anyway, or a body thinner than
/// about eight pixels, if it is nearer or farther than everything else by more than the margin.
/// All disparities are searched where there is little to gain (32 of them or fewer), and where
/// less than a tenth of the small pair can be matched.
/// @throws as match_stereo().
DisparityRange seen_disparity_range(const GreyImage& left, const GreyImage& right,
                                    const geometry::StereoCamera& camera,
                                    const StereoOptions& options);

/// By how much the range is widened on either side [pixels].
inline constexpr int kSearchMargin = 8;

}  // namespace prehend::perception
