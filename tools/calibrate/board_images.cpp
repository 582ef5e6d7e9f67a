#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/perception/image_files.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {
namespace {

using geometry::InputError;

bool is_image(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* known : {".png", ".jpg", ".jpeg", ".bmp", ".ppm", ".pgm", ".tif", ".tiff"}) {
    if (ending == known) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> image_files(const std::vector<std::string>& inputs) {
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    if (!std::filesystem::is_directory(input)) {
      files.push_back(input);  // reading it says what is wrong with it
      continue;
    }
    std::vector<std::string> of_folder;
    for (const auto& entry : std::filesystem::directory_iterator(input)) {
      if (entry.is_regular_file() && is_image(entry.path())) {
        of_folder.push_back(entry.path().string());
      }
    }
    if (of_folder.empty()) throw InputError(input + " holds no image", "Name another folder");
    std::sort(of_folder.begin(), of_folder.end());
    files.insert(files.end(), of_folder.begin(), of_folder.end());
  }
  return files;
}

BoardImages::BoardImages(const std::string& board_file)
    : board_(calibration::read_calibration_board(board_file)) {}

calibration::BoardView BoardImages::find(const std::string& file) {
  return find(perception::read_color_image(file), file);
}

calibration::BoardView BoardImages::find(const geometry::ColorImage& image,
                                         const std::string& file) {
  if (first_.empty()) {
    first_ = file;
    width_ = image.width;
    height_ = image.height;
  } else if (image.width != width_ || image.height != height_) {
    throw InputError(fmt::format("{} has {} x {} pixels, {} has {} x {}", file, image.width,
                                 image.height, first_, width_, height_),
                     "Give images of one camera at one size");
  }
  return calibration::find_board(image, board_, file);
}

std::vector<Eigen::Matrix3d> rotations_of(const text::CsvTable& table) {
  std::array<std::vector<double>, 4> q;
  static constexpr std::array<const char*, 4> kNames{"qw", "qx", "qy", "qz"};
  for (std::size_t i = 0; i < 4; ++i) {
    q[i] = table.numbers(table.require(kNames[i], "of a unit quaternion"));
  }
  std::vector<Eigen::Matrix3d> rotations;
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const Eigen::Quaterniond rotation(q[0][r], q[1][r], q[2][r], q[3][r]);
    if (!(std::abs(rotation.norm() - 1) < 0.01)) {
      throw InputError(fmt::format("{}:{}: the quaternion's length is {:.3g}, not 1",
                                   table.file.string(), table.lines[r], rotation.norm()),
                       "Write qw, qx, qy, qz of a rotation");
    }
    rotations.push_back(rotation.normalized().toRotationMatrix());
  }
  return rotations;
}

std::vector<geometry::RigidTransform> poses_of(const text::CsvTable& table) {
  const std::vector<Eigen::Matrix3d> rotations = rotations_of(table);
  const std::vector<double> x = table.numbers(table.require("x", "m"));
  const std::vector<double> y = table.numbers(table.require("y", "m"));
  const std::vector<double> z = table.numbers(table.require("z", "m"));
  std::vector<geometry::RigidTransform> poses;
  for (std::size_t r = 0; r < rotations.size(); ++r) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.linear() = rotations[r];
    X.translation() = Eigen::Vector3d(x[r], y[r], z[r]);
    poses.push_back(X);
  }
  return poses;
}

std::string pose_text(const geometry::RigidTransform& X) {
  const Eigen::Matrix3d R = X.linear();
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2)));
  // Straight up or down roll and yaw turn about one axis: all of it is yaw then.
  const bool locked = std::hypot(R(2, 1), R(2, 2)) < 1e-9;
  const double roll = locked ? 0 : std::atan2(R(2, 1), R(2, 2));
  const double yaw = locked ? std::atan2(-R(0, 1), R(1, 1)) : std::atan2(R(1, 0), R(0, 0));
  const Eigen::Vector3d t = X.translation();
  return fmt::format("{{xyz: [{:.7f}, {:.7f}, {:.7f}], rpy: [{:.8f}, {:.8f}, {:.8f}]}}", t.x(),
                     t.y(), t.z(), roll, pitch, yaw);
}

std::string beside(const text::CsvTable& table, const std::string& name) {
  const std::filesystem::path path(name);
  return path.is_absolute() ? name : (table.file.parent_path() / path).string();
}

std::string page_file(const CalibrateChoices& choices) {
  if (!choices.report.empty() || choices.out.empty()) return choices.report;
  return std::filesystem::path(choices.out).replace_extension(".html").string();
}

void write_result(const std::string& file, const std::string& text, const char* what) {
  const std::filesystem::path path(file);
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  geometry::write_whole_file(path, text, what);
  std::printf("%s is in %s\n", what, file.c_str());
}

void write_page(const std::string& file, const report::Page& page) {
  const std::filesystem::path path(file);
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  page.write(file);
  std::printf("The page of residuals is in %s\n", file.c_str());
}

}  // namespace prehend::tools
