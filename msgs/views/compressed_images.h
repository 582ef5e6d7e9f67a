#pragma once

#include <string>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/RawImage.pb.h"

namespace prehend::views {

enum class PictureFormat {
  kJpeg,  // smaller, not exact: quality 90
  kPng    // exact
};

/// A picture of 8 bit (mono8, rgb8), smaller. @throws geometry::InputError for another encoding, or
/// data that do not fit its size.
::foxglove::CompressedImage compressed_image(const ::foxglove::RawImage& image,
                                             PictureFormat format);

}  // namespace prehend::views
