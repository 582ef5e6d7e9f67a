#include "prehend/perception/calibration.h"

#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

using geometry::InputError;

constexpr std::uintmax_t kMaxFileSize = 1 << 20;  // bytes; a calibration has a few thousand
constexpr double kLargestBaseline = 10;           // m

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what,
                       const std::string& mend) {
  throw InputError("Calibration '" + path.string() + "' " + what, mend);
}

std::string read_text(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    fail(path, "does not exist or is not a file", "Check the path");
  }
  if (std::filesystem::file_size(path, error) > kMaxFileSize || error) {
    fail(path, "is too large to be a calibration", "Pass the calibration, not the images");
  }
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream || text.str().empty()) fail(path, "is empty or not readable", "Calibrate again");
  if (text.str().find('\0') != std::string::npos) {
    fail(path, "is not a text file", "Pass a YAML file or K.txt");
  }
  return text.str();
}

// One file's values, looked up by any of a key's usual names.
class Document {
 public:
  Document(std::filesystem::path path, YAML::Node root)
      : path_(std::move(path)), root_(std::move(root)) {}

  using Names = std::initializer_list<const char*>;

  std::optional<YAML::Node> find(Names names) const {
    for (const char* name : names) {
      const YAML::Node node = root_[name];
      if (node) return node;
    }
    return std::nullopt;
  }

  std::vector<double> numbers(Names names) const {
    const std::optional<YAML::Node> found = find(names);
    if (!found) {
      fail(path_, std::string("has no key '") + *names.begin() + "'", "Add it or calibrate again");
    }
    const YAML::Node node = found->IsMap() && (*found)["data"] ? (*found)["data"] : *found;
    std::vector<double> values;
    const auto add = [&](const YAML::Node& value) {
      double number = 0;
      if (!value.IsScalar() || !YAML::convert<double>::decode(value, number) ||
          !std::isfinite(number)) {
        fail(path_,
             std::string("has a value of '") + *names.begin() + "' that is not a finite number",
             "Correct it or calibrate again");
      }
      values.push_back(number);
    };
    if (node.IsScalar()) {
      add(node);
    } else if (node.IsSequence()) {
      for (const YAML::Node& child : node) {
        if (!child.IsSequence()) {
          add(child);
          continue;
        }
        for (const YAML::Node& grandchild : child) add(grandchild);
      }
    }
    return values;
  }

  std::vector<double> numbers(Names names, std::size_t count) const {
    std::vector<double> values = numbers(names);
    if (values.size() != count) {
      fail(path_,
           std::string("has ") + std::to_string(values.size()) + " values of '" + *names.begin() +
               "', not " + std::to_string(count),
           "Correct it or calibrate again");
    }
    return values;
  }

  Eigen::Matrix3d matrix(Names names) const {
    const std::vector<double> v = numbers(names, 9);
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
  }

  double number(Names names) const { return numbers(names, 1)[0]; }

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  YAML::Node root_;
};

void check_pinhole(const std::filesystem::path& path, const Eigen::Matrix3d& K, const char* name) {
  const bool good = K.allFinite() && K(0, 0) > 0 && K(1, 1) > 0 && K(1, 0) == 0 && K(2, 0) == 0 &&
                    K(2, 1) == 0 && std::abs(K(2, 2) - 1) < 1e-9;
  if (!good) {
    fail(path,
         std::string("has no pinhole matrix in '") + name +
             "' (fx 0 cx; 0 fy cy; 0 0 1 with fx, fy > 0)",
         "Correct it or calibrate again");
  }
}

void check_baseline(const std::filesystem::path& path, double baseline, const char* name) {
  if (!std::isfinite(baseline) || baseline <= 0) {
    fail(path, std::string("has a '") + name + "' that is not a positive length",
         "State the distance of the two cameras in metres");
  }
  if (baseline > kLargestBaseline) {
    fail(path,
         std::string("has a '") + name + "' of " + std::to_string(baseline) +
             " m, which looks like millimetres",
         "State lengths in metres");
  }
}

void check_distortion(const std::filesystem::path& path, const std::vector<double>& d,
                      const char* name) {
  const std::size_t n = d.size();
  if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14) {
    fail(path,
         std::string("has ") + std::to_string(n) + " distortion coefficients in '" + name +
             "'; OpenCV knows 4, 5, 8, 12 or 14",
         "Correct it or calibrate again");
  }
}

void set_baseline(StereoCalibration& calibration, const std::filesystem::path& path,
                  double baseline) {
  check_baseline(path, baseline, "baseline");
  calibration.X_RL.translation() = Eigen::Vector3d(-baseline, 0, 0);
}

StereoCalibration from_plain_text(const std::filesystem::path& path,
                                  const std::vector<double>& values) {
  if (values.size() != 10) {
    fail(path, "has " + std::to_string(values.size()) + " numbers, not 10",
         "Write the nine numbers of K row by row, then the baseline in metres");
  }
  StereoCalibration calibration;
  calibration.K_left =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  check_pinhole(path, calibration.K_left, "K");
  calibration.K_right = calibration.K_left;
  set_baseline(calibration, path, values[9]);
  return calibration;
}

// The file's numbers if it is nothing but numbers.
std::optional<std::vector<double>> plain_numbers(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> values;
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    values.push_back(std::strtod(word.c_str(), &end));
    if (end == word.c_str() || *end != '\0') return std::nullopt;
  }
  return values;
}

void read_stereo_pose(const Document& document, StereoCalibration& calibration) {
  const std::filesystem::path& path = document.path();
  const Eigen::Matrix3d R = document.matrix({"R"});
  const std::vector<double> T = document.numbers({"T"}, 3);
  if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) {
    fail(path, "has an 'R' that is not a rotation", "Correct it or calibrate again");
  }
  // Printed digits leave R off by a little; the nearest rotation.
  calibration.X_RL = geometry::make_transform(Eigen::Quaterniond(R), {T[0], T[1], T[2]});
  check_baseline(path, calibration.baseline(), "T");
}

StereoCalibration from_document(const Document& document) {
  const std::filesystem::path& path = document.path();
  StereoCalibration calibration;
  const auto size_of = [&](Document::Names names) {
    if (!document.find(names)) return 0;
    const double value = document.number(names);
    if (value < 1 || value > 100000 || value != std::floor(value)) {
      fail(path, std::string("has a '") + *names.begin() + "' that is no size in pixels",
           "Correct it");
    }
    return static_cast<int>(value);
  };
  calibration.width = size_of({"width", "image_width"});
  calibration.height = size_of({"height", "image_height"});

  const Document::Names kLeft = {"M1", "K1", "K", "cameraMatrix1", "camera_matrix_left"};
  const Document::Names kRight = {"M2", "K2", "cameraMatrix2", "camera_matrix_right"};
  const Document::Names kLeftDistortion = {"D1", "distCoeffs1", "distortion_left"};
  const Document::Names kRightDistortion = {"D2", "distCoeffs2", "distortion_right"};
  if (!document.find(kLeft)) {  // the plain kind
    if (!document.find({"fx"})) {
      fail(path, "has neither the key 'fx' nor a matrix 'M1' or 'K'", "Add it or calibrate again");
    }
    calibration.K_left << document.number({"fx"}), 0, document.number({"cx"}), 0,
        document.number({"fy"}), document.number({"cy"}), 0, 0, 1;
    check_pinhole(path, calibration.K_left, "fx, fy");
    calibration.K_right = calibration.K_left;
    set_baseline(calibration, path, document.number({"baseline"}));
    return calibration;
  }
  calibration.K_left = document.matrix(kLeft);
  check_pinhole(path, calibration.K_left, "M1");
  if (document.find(kLeftDistortion)) {
    calibration.distortion_left = document.numbers(kLeftDistortion);
    check_distortion(path, calibration.distortion_left, "D1");
  }
  const bool one_matrix = !document.find(kRight) && document.find({"baseline"});
  if (one_matrix) {
    calibration.K_right = calibration.K_left;
    calibration.distortion_right = calibration.distortion_left;
    set_baseline(calibration, path, document.number({"baseline"}));
    return calibration;
  }
  calibration.K_right = document.matrix(kRight);
  check_pinhole(path, calibration.K_right, "M2");
  if (document.find(kRightDistortion)) {
    calibration.distortion_right = document.numbers(kRightDistortion);
    check_distortion(path, calibration.distortion_right, "D2");
  }
  read_stereo_pose(document, calibration);
  return calibration;
}

}  // namespace

bool StereoCalibration::is_rectified() const {
  const auto none = [](const std::vector<double>& coefficients) {
    for (const double c : coefficients) {
      if (c != 0) return false;
    }
    return true;
  };
  const Eigen::Vector3d& T = X_RL.translation();
  return none(distortion_left) && none(distortion_right) && K_left.isApprox(K_right, 1e-9) &&
         K_left(0, 1) == 0 && X_RL.linear().isIdentity(1e-9) && T.x() < 0 &&
         T.tail<2>().norm() <= 1e-6 * T.norm();
}

StereoCalibration read_stereo_calibration(const std::filesystem::path& path) {
  std::string text = read_text(path);
  if (const auto values = plain_numbers(text)) return from_plain_text(path, *values);
  // OpenCV writes the directive as "%YAML:1.0", which is not YAML.
  if (text.rfind("%YAML", 0) == 0) text.erase(0, text.find('\n'));
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    fail(path, std::string("is not YAML: ") + error.what(), "Pass a YAML file or K.txt");
  }
  if (!root.IsMap()) {
    fail(path, "is no calibration",
         "Pass OpenCV's YAML, {width, height, fx, fy, cx, cy, baseline} "
         "or K.txt with nine numbers of K and the baseline");
  }
  return from_document(Document(path, root));
}

geometry::StereoCamera rectified_camera(const StereoCalibration& calibration, int width,
                                        int height) {
  if (!calibration.is_rectified()) {
    throw InputError("The calibration is of cameras that are not rectified",
                     "Rectify the images first");
  }
  if (calibration.width > 0 && calibration.height > 0 &&
      (calibration.width != width || calibration.height != height)) {
    throw InputError("The images are " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels, the calibration is for " + std::to_string(calibration.width) +
                         " x " + std::to_string(calibration.height),
                     "Pass the calibration of these images");
  }
  geometry::StereoCamera camera;
  const Eigen::Matrix3d& K = calibration.K_left;
  camera.left = {width, height, K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
  camera.baseline = calibration.baseline();
  return camera;
}

}  // namespace prehend::perception
