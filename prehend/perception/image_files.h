#pragma once

#include <filesystem>

#include "prehend/geometry/image.h"

// Target prehend::image_files, apart from prehend::perception because of OpenCV's codecs.
namespace prehend::perception {

/// Reads a PNG, JPEG, BMP, PPM ... as 8-bit colour (grey is spread to the three channels).
/// @throws geometry::InputError for a missing, empty, truncated or foreign file.
geometry::ColorImage read_color_image(const std::filesystem::path& path);

/// Writes 8-bit colour by the file name's ending. @throws geometry::InputError when it cannot.
void write_color_image(const std::filesystem::path& path, const geometry::ColorImage& image);

}  // namespace prehend::perception
