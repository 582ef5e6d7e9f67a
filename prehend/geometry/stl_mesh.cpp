#include "prehend/geometry/stl_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

constexpr std::size_t kHeader = 80;                 // bytes, of any content
constexpr std::size_t kBody = kHeader + 4;          // where the triangles begin
constexpr std::size_t kNormal = 3 * sizeof(float);  // bytes
constexpr std::size_t kTriangle = 4 * kNormal + 2;  // normal, three corners, attributes

[[noreturn]] void refuse_stl(const std::filesystem::path& path, const std::string& what) {
  throw InputError('\'' + path.string() + "' " + what, "Copy or export the file again");
}

std::uint32_t triangle_count(const char* header) {
  std::uint32_t count = 0;
  std::memcpy(&count, header + kHeader, sizeof count);
  return count;
}

}  // namespace

bool is_binary_stl(const std::filesystem::path& path, std::size_t size) {
  std::ifstream stream(path, std::ios::binary);
  std::array<char, kBody> head{};
  stream.read(head.data(), head.size());
  if (stream.gcount() == static_cast<std::streamsize>(head.size()) &&
      kBody + kTriangle * triangle_count(head.data()) == size) {
    return true;
  }
  if (std::strncmp(head.data(), "solid", 5) != 0) {
    refuse_stl(path,
               "is not an STL file or is truncated: its triangle count does not fit its size");
  }
  std::string tail(std::min<std::size_t>(size, 512), '\0');
  stream.clear();
  stream.seekg(-static_cast<std::streamoff>(tail.size()), std::ios::end);
  stream.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  if (tail.find("endsolid") == std::string::npos) {
    refuse_stl(path, "is truncated: a text STL ends with 'endsolid'");
  }
  return false;
}

TriangleMesh read_binary_stl(const std::filesystem::path& path, double scale) {
  std::ifstream stream(path, std::ios::binary);
  std::array<char, kBody> head{};
  stream.read(head.data(), head.size());
  std::vector<char> bytes(kTriangle * triangle_count(head.data()));
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!stream) refuse_stl(path, "could not be read");
  TriangleMesh mesh;
  mesh.vertices.reserve(3 * bytes.size() / kTriangle);
  mesh.triangles.reserve(bytes.size() / kTriangle);
  for (std::size_t at = 0; at < bytes.size(); at += kTriangle) {
    std::array<float, 9> corners;
    std::memcpy(corners.data(), bytes.data() + at + kNormal, sizeof corners);
    const int first = static_cast<int>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.push_back(
          scale * Eigen::Map<const Eigen::Vector3f>(corners.data() + 3 * k).cast<double>());
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

}  // namespace prehend::geometry
