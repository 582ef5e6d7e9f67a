#include "prehend/perception/calibration_document.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <utility>

#include <Eigen/LU>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

using geometry::InputError;

constexpr std::uintmax_t kMaxFileSize = 1 << 20;  // bytes; a calibration has a few thousand
constexpr double kLargestBaseline = 10;           // m

}  // namespace

void fail_calibration(const std::string& place, const std::string& what, const std::string& mend) {
  throw InputError("Calibration '" + place + "' " + what, mend);
}

std::string read_calibration_text(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    fail_calibration(path, "does not exist or is not a file", "Check the path");
  }
  if (std::filesystem::file_size(path, error) > kMaxFileSize || error) {
    fail_calibration(path, "is too large to be a calibration",
                     "Pass the calibration, not the images");
  }
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream || text.str().empty())
    fail_calibration(path, "is empty or not readable", "Calibrate again");
  if (text.str().find('\0') != std::string::npos) {
    fail_calibration(path, "is not a text file", "Pass a YAML file or K.txt");
  }
  return text.str();
}

CalibrationDocument::CalibrationDocument(std::filesystem::path path, std::string text)
    : path_(std::move(path)) {
  // OpenCV writes the directive as "%YAML:1.0", which is not YAML.
  if (text.rfind("%YAML", 0) == 0) text.erase(0, text.find('\n'));
  try {
    root_ = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    fail_calibration(path_, std::string("is not YAML: ") + error.what(),
                     "Pass a YAML file or K.txt");
  }
  if (!root_.IsMap()) {
    fail_calibration(path_, "is no calibration",
                     "Pass OpenCV's YAML, {width, height, fx, fy, cx, cy, baseline} "
                     "or K.txt with nine numbers of K and the baseline");
  }
}

std::optional<YAML::Node> CalibrationDocument::find(Names names) const {
  for (const char* name : names) {
    const YAML::Node node = root_[name];
    if (node) return node;
  }
  return std::nullopt;
}

std::string CalibrationDocument::place(Names names) const {
  const std::optional<YAML::Node> found = find(names);
  if (!found) return path_;
  const YAML::Node node = found->IsMap() && (*found)["data"] ? (*found)["data"] : *found;
  return path_.string() + ":" + std::to_string(node.Mark().line + 1);
}

std::vector<double> CalibrationDocument::numbers(Names names) const {
  const std::optional<YAML::Node> found = find(names);
  if (!found) {
    fail_calibration(path_, std::string("has no key '") + *names.begin() + "'",
                     "Add it or calibrate again");
  }
  const YAML::Node node = found->IsMap() && (*found)["data"] ? (*found)["data"] : *found;
  std::vector<double> values;
  const auto add = [&](const YAML::Node& value) {
    double number = 0;
    if (!value.IsScalar() || !YAML::convert<double>::decode(value, number) ||
        !std::isfinite(number)) {
      fail_calibration(
          path_.string() + ":" + std::to_string(value.Mark().line + 1),
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

std::vector<double> CalibrationDocument::numbers(Names names, std::size_t count) const {
  std::vector<double> values = numbers(names);
  if (values.size() != count) {
    fail_calibration(place(names),
                     std::string("has ") + std::to_string(values.size()) + " values of '" +
                         *names.begin() + "', not " + std::to_string(count),
                     "Correct it or calibrate again");
  }
  return values;
}

Eigen::Matrix3d CalibrationDocument::matrix(Names names) const {
  const std::vector<double> v = numbers(names, 9);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
}

Eigen::Matrix3d CalibrationDocument::rotation(Names names) const {
  const Eigen::Matrix3d R = matrix(names);
  if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) {
    fail_calibration(place(names),
                     std::string("has a '") + *names.begin() + "' that is not a rotation",
                     "Correct it or calibrate again");
  }
  return R;
}

int CalibrationDocument::size(Names names) const {
  if (!find(names)) return 0;
  const double value = number(names);
  if (value < 1 || value > 100000 || value != std::floor(value)) {
    fail_calibration(place(names),
                     std::string("has a '") + *names.begin() + "' that is no size in pixels",
                     "Correct it");
  }
  return static_cast<int>(value);
}

void check_pinhole(const std::string& place, const Eigen::Matrix3d& K, const char* name) {
  const bool good = K.allFinite() && K(0, 0) > 0 && K(1, 1) > 0 && K(1, 0) == 0 && K(2, 0) == 0 &&
                    K(2, 1) == 0 && std::abs(K(2, 2) - 1) < 1e-9;
  if (!good) {
    fail_calibration(place,
                     std::string("has no pinhole matrix in '") + name +
                         "' (fx 0 cx; 0 fy cy; 0 0 1 with fx, fy > 0)",
                     "Correct it or calibrate again");
  }
}

void check_baseline(const std::string& place, double baseline, const char* name) {
  if (!std::isfinite(baseline) || baseline <= 0) {
    fail_calibration(place, std::string("has a '") + name + "' that is not a positive length",
                     "State the distance of the two cameras in metres");
  }
  if (baseline > kLargestBaseline) {
    fail_calibration(place,
                     std::string("has a '") + name + "' of " + std::to_string(baseline) +
                         " m, which looks like millimetres",
                     "State lengths in metres");
  }
}

void check_distortion(const std::string& place, const std::vector<double>& d, const char* name) {
  const std::size_t n = d.size();
  if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14) {
    fail_calibration(place,
                     std::string("has ") + std::to_string(n) + " distortion coefficients in '" +
                         name + "'; OpenCV knows 4, 5, 8, 12 or 14",
                     "Correct it or calibrate again");
  }
}

}  // namespace prehend::perception
