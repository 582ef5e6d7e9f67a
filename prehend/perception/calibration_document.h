#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>
#include <Eigen/Core>

// What the readers of calibration files share. Every function throws geometry::InputError that
// names the file, where known the line, the key and the mend.
namespace prehend::perception {

/// Throws the error "Calibration 'place' what. mend."
/// @param place the file, or "file:line".
[[noreturn]] void fail_calibration(const std::string& place, const std::string& what,
                                   const std::string& mend);

/// The text of a file of a calibration's size.
std::string read_calibration_text(const std::filesystem::path& path);

/// One file's values, looked up by any of a key's usual names.
class CalibrationDocument {
 public:
  using Names = std::initializer_list<const char*>;

  /// @param text of the file `path`: a YAML map, with or without OpenCV's directive.
  CalibrationDocument(std::filesystem::path path, std::string text);

  std::optional<YAML::Node> find(Names names) const;
  /// "file:line" of that key's value; the file alone without the key.
  std::string place(Names names) const;
  /// The numbers of a scalar, a list, a list of rows or a map with `data`; all finite.
  std::vector<double> numbers(Names names) const;
  std::vector<double> numbers(Names names, std::size_t count) const;
  double number(Names names) const { return numbers(names, 1)[0]; }
  Eigen::Matrix3d matrix(Names names) const;
  /// A matrix that is a rotation but for printed digits.
  Eigen::Matrix3d rotation(Names names) const;
  /// A size in pixels; 0 without the key.
  int size(Names names) const;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  YAML::Node root_;
};

/// Checks fx 0 cx; 0 fy cy; 0 0 1 with fx, fy > 0.
void check_pinhole(const std::string& place, const Eigen::Matrix3d& K, const char* name);

/// Checks that it is positive and not in millimetres.
void check_baseline(const std::string& place, double baseline, const char* name);

/// Checks that OpenCV knows so many coefficients.
void check_distortion(const std::string& place, const std::vector<double>& d, const char* name);

}  // namespace prehend::perception
