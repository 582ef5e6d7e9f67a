#include "prehend/perception/camera_calibration.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/perception/calibration_document.h"
#include "prehend/perception/rectification.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/yaml_map.h"

namespace prehend::perception {
namespace {

using geometry::InputError;
using Names = CalibrationDocument::Names;
using Projection = Eigen::Matrix<double, 3, 4>;

constexpr std::size_t kLongestName = 200;
constexpr int kLargestSide = 16384;       // pixels, as of images in messages
constexpr double kSameProjection = 1e-6;  // relative; files of six printed digits keep it

// The number of values that {rows, cols} of a matrix say, against what is meant.
void check_shape(const CalibrationDocument& document, Names names, int rows, int cols) {
  const YAML::Node node = document.find(names).value_or(YAML::Node());
  if (!node.IsMap()) return;
  for (const auto& [key, expected] : {std::pair{"rows", rows}, std::pair{"cols", cols}}) {
    const YAML::Node value = node[key];
    int count = 0;
    if (!value) continue;
    if (!value.IsScalar() || !YAML::convert<int>::decode(value, count) || count != expected) {
      fail_calibration(document.path().string() + ":" + std::to_string(value.Mark().line + 1),
                       std::string("has a '") + *names.begin() + "' whose " + key + " are not " +
                           std::to_string(expected),
                       "Correct it or calibrate again");
    }
  }
}

void check_keys(const CalibrationDocument& document, const YAML::Node& root) {
  static const std::vector<std::string> kKnown = {"image_width",
                                                  "image_height",
                                                  "camera_name",
                                                  "camera_matrix",
                                                  "distortion_model",
                                                  "distortion_coefficients",
                                                  "rectification_matrix",
                                                  "projection_matrix",
                                                  "width",
                                                  "height",
                                                  "header",
                                                  "D",
                                                  "K",
                                                  "R",
                                                  "P",
                                                  "d",
                                                  "k",
                                                  "r",
                                                  "p",
                                                  "binning_x",
                                                  "binning_y",
                                                  "roi"};
  for (const auto& entry : root) {
    const auto key = entry.first.as<std::string>("");
    if (std::find(kKnown.begin(), kKnown.end(), key) != kKnown.end()) continue;
    fail_calibration(document.path().string() + ":" + std::to_string(entry.first.Mark().line + 1),
                     "has the unknown key '" + key + "'", text::nearest_match_mend(key, kKnown));
  }
}

// Neither OpenCV nor a PinholeCamera has skew, and would leave it out.
void check_no_skew(const std::string& place, double skew, const char* name) {
  if (skew == 0) return;
  fail_calibration(place, std::string("has skew in '") + name + "' (second value of row 1)",
                   "Calibrate without skew");
}

// The calibration is of whole images at full resolution: what a message says of cut ones.
void check_whole_image(const CalibrationDocument& document) {
  for (const char* key : {"binning_x", "binning_y"}) {
    if (document.find({key}) && document.number({key}) > 1) {
      fail_calibration(document.place({key}), std::string("has a '") + key + "' over 1",
                       "Calibrate without binning");
    }
  }
  const auto roi = document.find({"roi"});
  if (!roi || !roi->IsMap()) return;
  for (const auto& entry : *roi) {
    double value = 0;
    if (entry.first.as<std::string>("") == "do_rectify" || !entry.second.IsScalar()) continue;
    if (!YAML::convert<double>::decode(entry.second, value) || value != 0) {
      fail_calibration(document.path().string() + ":" + std::to_string(entry.first.Mark().line + 1),
                       "is of a part of the image (roi)", "Calibrate with the whole image");
    }
  }
}

int required_size(const CalibrationDocument& document, Names names) {
  const int size = document.size(names);
  if (size == 0) document.numbers(names, 1);  // says that it is missing
  if (size > kLargestSide) {
    fail_calibration(document.place(names),
                     std::string("has a '") + *names.begin() + "' over " +
                         std::to_string(kLargestSide) + " pixels",
                     "Correct it");
  }
  return size;
}

void check_model(const CalibrationDocument& document, const CameraCalibration& calibration) {
  const Names kModel = {"distortion_model"};
  const auto node = document.find(kModel);
  if (!node) return;
  const auto model = node->as<std::string>("");
  if (model.empty() && calibration.distortion.empty()) return;  // an uncalibrated message's
  if (model != "plumb_bob" && model != "rational_polynomial") {
    fail_calibration(document.place(kModel), "has the distortion_model '" + model + "'",
                     "Calibrate with plumb_bob or rational_polynomial");
  }
  if (model == "plumb_bob" && calibration.distortion.size() > 5) {
    fail_calibration(document.place(kModel),
                     "has " + std::to_string(calibration.distortion.size()) +
                         " coefficients of a plumb_bob, which has 4 or 5",
                     "Name rational_polynomial or calibrate again");
  }
}

std::string read_name(const CalibrationDocument& document) {
  const auto node = document.find({"camera_name"});
  if (!node) return "camera";
  const auto name = node->as<std::string>("");
  const bool printable = std::none_of(name.begin(), name.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f;
  });
  if (name.empty() || name.size() > kLongestName || !printable) {
    fail_calibration(document.place({"camera_name"}),
                     "has a 'camera_name' that is no name of 1 to " + std::to_string(kLongestName) +
                         " printable characters",
                     "Correct it");
  }
  return name;
}

std::string number_text(double value) {
  char buffer[32];
  const auto end = std::to_chars(std::begin(buffer), std::end(buffer), value).ptr;
  return {std::begin(buffer), end};
}

std::string matrix_text(const char* name, int rows, int cols, std::span<const double> values) {
  std::string text = std::string(name) + ":\n  rows: " + std::to_string(rows) +
                     "\n  cols: " + std::to_string(cols) + "\n  data: [";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += (i == 0 ? "" : ", ") + number_text(values[i]);
  }
  return text + "]\n";
}

template <class Matrix>
std::string matrix_text(const char* name, const Matrix& m) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index j = 0; j < m.cols(); ++j) values.push_back(m(i, j));
  }
  return matrix_text(name, static_cast<int>(m.rows()), static_cast<int>(m.cols()), values);
}

Projection projection_of(const geometry::PinholeCamera& camera, double baseline) {
  Projection P = Projection::Zero();
  P(0, 0) = camera.fx;
  P(0, 2) = camera.cx;
  P(0, 3) = -camera.fx * baseline;
  P(1, 1) = camera.fy;
  P(1, 2) = camera.cy;
  P(2, 2) = 1;
  return P;
}

bool is_near(double a, double b) {
  return std::abs(a - b) <= kSameProjection * std::max(std::abs(a), std::abs(b));
}

}  // namespace

const char* CameraCalibration::distortion_model() const {
  return distortion.size() <= 5 ? "plumb_bob" : "rational_polynomial";
}

CameraCalibration ideal_camera(const std::string& name, const geometry::PinholeCamera& camera) {
  CameraCalibration calibration;
  calibration.name = name;
  calibration.width = camera.width;
  calibration.height = camera.height;
  calibration.P = projection_of(camera, 0);
  calibration.K = calibration.P.leftCols<3>();
  return calibration;
}

geometry::PinholeCamera rectified_camera(const CameraCalibration& calibration) {
  const Projection& P = calibration.P;
  return {calibration.width, calibration.height, P(0, 0), P(1, 1), P(0, 2), P(1, 2)};
}

CameraCalibration parse_camera_calibration(const std::string& text,
                                           const std::filesystem::path& path) {
  // `topic echo` ends each message with the mark of a new document.
  std::string one = text;
  while (one.ends_with('\n') || one.ends_with("\n---")) {
    one.resize(one.size() - (one.ends_with('\n') ? 1 : 3));
  }
  const YAML::Node root = text::parse_yaml_map(one, path);  // strict: nothing twice, no tags
  const CalibrationDocument document(path, one);
  check_keys(document, root);
  check_whole_image(document);
  const Names kMatrix = {"camera_matrix", "K", "k"};
  const Names kDistortion = {"distortion_coefficients", "D", "d"};
  const Names kRectification = {"rectification_matrix", "R", "r"};
  const Names kProjection = {"projection_matrix", "P", "p"};
  CameraCalibration calibration;
  calibration.name = read_name(document);
  calibration.width = required_size(document, {"image_width", "width"});
  calibration.height = required_size(document, {"image_height", "height"});
  check_shape(document, kMatrix, 3, 3);
  calibration.K = document.matrix(kMatrix);
  check_pinhole(document.place(kMatrix), calibration.K, "camera_matrix");
  check_no_skew(document.place(kMatrix), calibration.K(0, 1), "camera_matrix");
  if (document.find(kDistortion)) {
    calibration.distortion = document.numbers(kDistortion);
    check_distortion(document.place(kDistortion), calibration.distortion,
                     "distortion_coefficients");
  }
  check_model(document, calibration);
  check_shape(document, kRectification, 3, 3);
  calibration.R = document.rotation(kRectification);
  check_shape(document, kProjection, 3, 4);
  const std::vector<double> p = document.numbers(kProjection, 12);
  calibration.P = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(p.data());
  check_pinhole(document.place(kProjection), calibration.P.leftCols<3>(), "projection_matrix");
  check_no_skew(document.place(kProjection), calibration.P(0, 1), "projection_matrix");
  if (calibration.P(2, 3) != 0) {
    fail_calibration(document.place(kProjection),
                     "has a 'projection_matrix' whose last column does not end with 0",
                     "Correct it or calibrate again");
  }
  return calibration;
}

CameraCalibration read_camera_calibration(const std::filesystem::path& path) {
  return parse_camera_calibration(read_calibration_text(path), path);
}

std::string camera_calibration_text(const CameraCalibration& calibration) {
  YAML::Emitter name;
  name << YAML::DoubleQuoted << calibration.name;
  std::string text = "image_width: " + std::to_string(calibration.width) +
                     "\nimage_height: " + std::to_string(calibration.height) +
                     "\ncamera_name: " + name.c_str() + "\n";
  text += matrix_text("camera_matrix", calibration.K);
  text += std::string("distortion_model: ") + calibration.distortion_model() + "\n";
  text += matrix_text("distortion_coefficients", 1, static_cast<int>(calibration.distortion.size()),
                      calibration.distortion);
  text += matrix_text("rectification_matrix", calibration.R);
  text += matrix_text("projection_matrix", calibration.P);
  parse_camera_calibration(text, "of camera " + calibration.name);  // refuses what cannot be
  return text;
}

void write_camera_calibration(const std::filesystem::path& path,
                              const CameraCalibration& calibration) {
  std::string text = camera_calibration_text(calibration);
  text.pop_back();  // write_whole_file ends the last line
  geometry::write_whole_file(path, text, "The calibration");
}

StereoCalibration stereo_calibration(const CameraCalibration& left, const CameraCalibration& right,
                                     const std::string& right_place) {
  if (left.width != right.width || left.height != right.height) {
    fail_calibration(right_place,
                     "is of images of " + std::to_string(right.width) + " x " +
                         std::to_string(right.height) + " pixels, the left camera's are " +
                         std::to_string(left.width) + " x " + std::to_string(left.height),
                     "Pass the two files of one stereo camera");
  }
  const Projection& l = left.P;
  const Projection& r = right.P;
  if (l(1, 3) != 0 || r(1, 3) != 0) {
    fail_calibration(right_place, "is of cameras that stand one above the other",
                     "Turn the pair on its side, so that the cameras stand side by side");
  }
  if (!is_near(l(1, 1), r(1, 1)) || !is_near(l(1, 2), r(1, 2))) {
    fail_calibration(right_place,
                     "has a 'projection_matrix' whose rows are not those of the left camera's "
                     "(fy, cy)",
                     "Pass the two files of one stereo calibration");
  }
  const double shift = r(0, 3) / r(0, 0) - l(0, 3) / l(0, 0);  // -baseline
  if (shift > 0) {
    fail_calibration(right_place, "is of the left camera (its projection_matrix has a positive Tx)",
                     "Swap the two files");
  }
  check_baseline(right_place, -shift, "projection_matrix");
  StereoCalibration calibration;
  calibration.width = left.width;
  calibration.height = left.height;
  calibration.K_left = left.K;
  calibration.K_right = right.K;
  calibration.distortion_left = left.distortion;
  calibration.distortion_right = right.distortion;
  // p_rectified_right = p_rectified_left + (shift, 0, 0).
  const Eigen::Matrix3d R_RL = right.R.transpose() * left.R;
  calibration.X_RL = geometry::make_transform(Eigen::Quaterniond(R_RL),
                                              right.R.transpose() * Eigen::Vector3d(shift, 0, 0));
  if (is_near(l(0, 0), r(0, 0)) && is_near(l(0, 2), r(0, 2))) {
    calibration.rectification =
        StereoRectification{left.R, right.R, {rectified_camera(left), -shift}};
  }
  return calibration;
}

std::pair<CameraCalibration, CameraCalibration> camera_calibrations(
    const StereoCalibration& calibration) {
  if (calibration.width <= 0 || calibration.height <= 0) {
    throw InputError("A stereo calibration without the images' size cannot be written",
                     "State width and height");
  }
  const StereoRectification rectified =
      rectification(calibration, calibration.width, calibration.height);
  CameraCalibration left;
  left.name = "left";
  left.width = calibration.width;
  left.height = calibration.height;
  CameraCalibration right = left;
  right.name = "right";
  left.K = calibration.K_left;
  right.K = calibration.K_right;
  left.distortion = calibration.distortion_left;
  right.distortion = calibration.distortion_right;
  left.R = rectified.R_left;
  right.R = rectified.R_right;
  left.P = projection_of(rectified.camera.left, 0);
  right.P = projection_of(rectified.camera.left, rectified.camera.baseline);
  return {left, right};
}

}  // namespace prehend::perception
