#include "prehend/perception/image_files.h"

#include <algorithm>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::perception {

geometry::ColorImage read_color_image(const std::filesystem::path& path) {
  const auto fail = [&path](const std::string& what, const std::string& mend) {
    throw geometry::InputError("Image '" + path.string() + "' " + what, mend);
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    fail("does not exist or is not a file", "Check the path");
  }
  cv::Mat image;
  try {
    image = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& exception) {
    fail("could not be decoded: " + exception.err, "Copy or record it again");
  }
  if (image.empty() || image.type() != CV_8UC3) {
    fail("is empty, truncated or of an unknown format", "Pass a whole PNG or JPEG");
  }
  geometry::ColorImage result(image.cols, image.rows);
  for (int v = 0; v < image.rows; ++v) {
    const cv::Vec3b* row = image.ptr<cv::Vec3b>(v);
    for (int u = 0; u < image.cols; ++u) result.at(u, v) = {row[u][2], row[u][1], row[u][0]};
  }
  return result;
}

void write_color_image(const std::filesystem::path& path, const geometry::ColorImage& image) {
  cv::Mat bgr(image.height, image.width, CV_8UC3);
  for (int v = 0; v < image.height; ++v) {
    cv::Vec3b* row = bgr.ptr<cv::Vec3b>(v);
    for (int u = 0; u < image.width; ++u) {
      const geometry::Rgb& c = image.at(u, v);
      row[u] = {c[2], c[1], c[0]};
    }
  }
  bool written = false;
  std::string reason;
  try {
    written = cv::imwrite(path.string(), bgr);
  } catch (const cv::Exception& exception) {
    reason = ": " + exception.err;
  }
  if (!written) {
    throw geometry::InputError("Image '" + path.string() + "' could not be written" + reason,
                               "Check the ending, and that the folder exists and has space");
  }
}

}  // namespace prehend::perception
