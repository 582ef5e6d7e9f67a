#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::robot::formats {

/// ` name="value"`, with entities.
std::string xml_attribute(std::string_view name, std::string_view value);

/// An angle [rad] in degrees, of which radians_of_degrees() makes the same number again: in the
/// digits of a double where those are enough.
std::string degrees_text(double angle);

/// Elements as they are written, in lines that are moved in.
class ColladaText {
 public:
  /// @param depth how deep the first of them is.
  explicit ColladaText(int depth) : depth_(depth) {}

  void open(const std::string& name, const std::string& attributes = "");
  void close();
  /// An element without others in it.
  void leaf(const std::string& name, const std::string& attributes, const std::string& text = "");
  /// <translate> and <rotate>, the only steps that links, mass frames and shapes may have.
  void steps(const geometry::RigidTransform& X);
  void add(const std::string& lines) { text_ += lines; }
  std::string take() { return std::move(text_); }

 private:
  void indent() { text_.append(static_cast<std::size_t>(depth_), ' '); }

  int depth_;
  std::vector<std::string> names_;
  std::string text_;
};

}  // namespace prehend::robot::formats
