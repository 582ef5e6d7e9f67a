#include "msgs/views/compressed_images.h"

#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::views {
namespace {

constexpr int kJpegQuality = 90;

}  // namespace

::foxglove::CompressedImage compressed_image(const ::foxglove::RawImage& image,
                                             PictureFormat format) {
  const bool is_color = image.encoding() == "rgb8";
  if (!is_color && image.encoding() != "mono8") {
    throw geometry::InputError("A picture of " + image.encoding() + " cannot be made smaller",
                               "Take mono8 or rgb8");
  }
  const std::size_t row = std::size_t{image.width()} * (is_color ? 3 : 1);
  if (image.width() == 0 || image.height() == 0 || image.step() < row ||
      image.data().size() != std::size_t{image.step()} * image.height()) {
    throw geometry::InputError("A picture's data do not fit its size", "Mend who made it");
  }
  // imencode() only reads.
  const cv::Mat seen(static_cast<int>(image.height()), static_cast<int>(image.width()),
                     is_color ? CV_8UC3 : CV_8UC1, const_cast<char*>(image.data().data()),
                     image.step());
  cv::Mat picture = seen;
  if (is_color) cv::cvtColor(seen, picture, cv::COLOR_RGB2BGR);
  const bool is_jpeg = format == PictureFormat::kJpeg;
  std::vector<int> options;
  if (is_jpeg) options = {cv::IMWRITE_JPEG_QUALITY, kJpegQuality};
  std::vector<unsigned char> bytes;
  if (!cv::imencode(is_jpeg ? ".jpg" : ".png", picture, bytes, options)) {
    throw geometry::InputError("A picture could not be made smaller", "Take it as it is");
  }
  ::foxglove::CompressedImage compressed;
  *compressed.mutable_timestamp() = image.timestamp();
  compressed.set_data(bytes.data(), bytes.size());
  compressed.set_format(is_jpeg ? "jpeg" : "png");
  compressed.set_frame_id(image.frame_id());
  return compressed;
}

}  // namespace prehend::views
