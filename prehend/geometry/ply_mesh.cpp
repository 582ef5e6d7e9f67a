#include "prehend/geometry/ply_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"

namespace prehend::geometry {
namespace {

// The numbers of a PLY body one after the other.
class PlyBody {
 public:
  PlyBody(const std::filesystem::path& path, const PlyHeader& header)
      : path_(path), ascii_(header.format == "ascii"), swap_(header.format == "binary_big_endian") {
    std::ifstream stream(path, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(header.body_offset));
    bytes_.resize(checked_file_size(path) - header.body_offset);
    stream.read(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
    bytes_.resize(static_cast<std::size_t>(stream.gcount()));
  }

  double next(PlyNumber type) {
    if (ascii_) return next_word();
    switch (type) {
      case PlyNumber::kInt8:
        return load<std::int8_t>();
      case PlyNumber::kUint8:
        return load<std::uint8_t>();
      case PlyNumber::kInt16:
        return load<std::int16_t>();
      case PlyNumber::kUint16:
        return load<std::uint16_t>();
      case PlyNumber::kInt32:
        return load<std::int32_t>();
      case PlyNumber::kUint32:
        return load<std::uint32_t>();
      case PlyNumber::kFloat32:
        return static_cast<double>(load<float>());
      case PlyNumber::kFloat64:
        return load<double>();
    }
    return 0;
  }

  // A list's length, which the rest of the file can hold.
  std::size_t next_length(PlyNumber type) {
    const double length = next(type);
    if (!(length >= 0) || length > static_cast<double>(bytes_.size() - position_)) fail_truncated();
    return static_cast<std::size_t>(length);
  }

  // A vertex index; -1 for what is none, which the check of the mesh refuses.
  int next_index(PlyNumber type) {
    const double index = next(type);
    return index >= 0 && index < 2147483647.0 ? static_cast<int>(index) : -1;
  }

 private:
  [[noreturn]] void fail_truncated() const {
    throw InputError('\'' + path_.string() +
                         "' is truncated or damaged: its data end before the "
                         "elements that its header promises",
                     "Copy or export the file again");
  }

  double next_word() {
    char* end = nullptr;
    const double number = std::strtod(bytes_.c_str() + position_, &end);
    const auto stop = static_cast<std::size_t>(end - bytes_.c_str());
    if (stop == position_) fail_truncated();
    position_ = stop;
    return number;
  }

  template <typename T>
  T load() {
    if (bytes_.size() - position_ < sizeof(T)) fail_truncated();
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + position_, sizeof(T));
    if (swap_) std::reverse(raw.begin(), raw.end());
    position_ += sizeof(T);
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  std::filesystem::path path_;
  bool ascii_;
  bool swap_;
  std::string bytes_;
  std::size_t position_ = 0;
};

/// Takes `value` where the property is a part of a colour.
void read_color(const PlyProperty& property, double value, std::array<int, 3>& color) {
  const bool is_share =
      property.type == PlyNumber::kFloat32 || property.type == PlyNumber::kFloat64;
  const int part =
      static_cast<int>(std::lround(std::clamp(is_share ? 255 * value : value, 0., 255.)));
  if (property.name == "red") color[0] = part;
  if (property.name == "green") color[1] = part;
  if (property.name == "blue") color[2] = part;
}

bool has_color(const PlyElement& element) {
  return std::any_of(element.properties.begin(), element.properties.end(),
                     [](const PlyProperty& one) { return one.name == "red"; });
}

void read_vertex(PlyBody& body, const PlyElement& element, double scale, TriangleMesh& mesh,
                 PlyColors* colors) {
  Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
  std::array<int, 3> color{};
  for (const PlyProperty& property : element.properties) {
    const std::size_t count = property.list_length ? body.next_length(*property.list_length) : 1;
    for (std::size_t k = 0; k < count; ++k) {
      const double value = body.next(property.type);
      if (property.name == "x") vertex.x() = value;
      if (property.name == "y") vertex.y() = value;
      if (property.name == "z") vertex.z() = value;
      if (colors) read_color(property, value, color);
    }
  }
  if (colors && has_color(element)) colors->vertices.push_back(color);
  mesh.vertices.push_back(scale * vertex);
}

// `polygon` is room to work in.
void read_face(PlyBody& body, const PlyElement& element, std::vector<int>& polygon,
               TriangleMesh& mesh, PlyColors* colors) {
  const std::size_t before = mesh.triangles.size();
  std::array<int, 3> color{};
  for (const PlyProperty& property : element.properties) {
    const bool corners = property.list_length &&
                         (property.name == "vertex_indices" || property.name == "vertex_index");
    const std::size_t count = property.list_length ? body.next_length(*property.list_length) : 1;
    if (!corners) {
      for (std::size_t k = 0; k < count; ++k) {
        const double value = body.next(property.type);
        if (colors) read_color(property, value, color);
      }
      continue;
    }
    polygon.clear();
    for (std::size_t k = 0; k < count; ++k) polygon.push_back(body.next_index(property.type));
    for (std::size_t k = 2; k < count; ++k) {
      mesh.triangles.emplace_back(polygon[0], polygon[k - 1], polygon[k]);
    }
  }
  if (colors && has_color(element)) {
    colors->triangles.insert(colors->triangles.end(), mesh.triangles.size() - before, color);
  }
}

void skip_row(PlyBody& body, const PlyElement& element) {
  for (const PlyProperty& property : element.properties) {
    const std::size_t count = property.list_length ? body.next_length(*property.list_length) : 1;
    for (std::size_t k = 0; k < count; ++k) body.next(property.type);
  }
}

}  // namespace

TriangleMesh read_ply_mesh(const std::filesystem::path& path, double scale, PlyColors* colors) {
  const PlyHeader header = read_ply_header(path);
  PlyBody body(path, header);
  TriangleMesh mesh;
  mesh.vertices.reserve(header.vertices);
  mesh.triangles.reserve(header.faces);
  std::vector<int> polygon;
  for (const PlyElement& element : header.elements) {
    for (std::size_t row = 0; row < element.count; ++row) {
      if (element.name == "vertex") {
        read_vertex(body, element, scale, mesh, colors);
      } else if (element.name == "face") {
        read_face(body, element, polygon, mesh, colors);
      } else {
        skip_row(body, element);
      }
    }
  }
  return mesh;
}

}  // namespace prehend::geometry
