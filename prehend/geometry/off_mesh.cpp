#include "prehend/geometry/off_mesh.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

[[noreturn]] void refuse_off(const std::filesystem::path& path, const std::string& what) {
  throw InputError('\'' + path.string() + "' " + what, "Copy or export the file again");
}

/// The lines of the file that say something, without comments.
class OffLines {
 public:
  explicit OffLines(const std::filesystem::path& path) : stream_(path, std::ios::binary) {}

  bool next(std::istringstream& words) {
    for (std::string line; std::getline(stream_, line);) {
      line.erase(std::min(line.find('#'), line.size()));
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      words.clear();
      words.str(line);
      return true;
    }
    return false;
  }

 private:
  std::ifstream stream_;
};

/// Takes the kind of file from its first line, if that has one: [ST][C][N]OFF.
void read_kind(std::istringstream& words, const std::filesystem::path& path, OffLines& lines) {
  const auto begin = words.tellg();
  std::string kind, more;
  words >> kind;
  if (kind.find("OFF") == std::string::npos) {  // it may be left out
    words.seekg(begin);
    return;
  }
  if (kind != "OFF" && kind != "COFF" && kind != "NOFF" && kind != "CNOFF" && kind != "STOFF") {
    refuse_off(path, "is an OFF file of the kind " + kind.substr(0, 40) + ", which is not read");
  }
  const auto counts = words.tellg();
  if (words >> more) {
    if (more == "BINARY") refuse_off(path, "is a binary OFF file, which is not read");
    words.clear();
    words.seekg(counts);
  } else if (!lines.next(words)) {
    refuse_off(path, "is truncated: it has no counts");
  }
}

}  // namespace

TriangleMesh read_off_mesh(const std::filesystem::path& path, double scale) {
  OffLines lines(path);
  std::istringstream words;
  if (!lines.next(words)) refuse_off(path, "is empty");
  read_kind(words, path, lines);
  long vertices = 0, faces = 0;
  if (!(words >> vertices >> faces) || vertices < 0 || faces < 0) {
    refuse_off(path, "has no counts of vertices and faces");
  }
  TriangleMesh mesh;
  for (long i = 0; i < vertices; ++i) {
    Eigen::Vector3d p;
    if (!lines.next(words)) refuse_off(path, "is truncated: it has fewer vertices than it says");
    if (!(words >> p.x() >> p.y() >> p.z())) {
      refuse_off(path, "has a vertex, number " + std::to_string(i) + ", without three numbers");
    }
    mesh.vertices.push_back(scale * p);
  }
  for (long i = 0; i < faces; ++i) {
    if (!lines.next(words)) refuse_off(path, "is truncated: it has fewer faces than it says");
    long corners = 0;
    int first = 0, before = 0, corner = 0;
    bool is_read = words >> corners && corners > 0;
    for (long k = 0; k < corners && is_read; ++k) {
      is_read = static_cast<bool>(words >> corner);
      if (k == 0) first = corner;
      if (k >= 2 && is_read) mesh.triangles.emplace_back(first, before, corner);
      before = corner;
    }
    if (!is_read) refuse_off(path, "has a face, number " + std::to_string(i) + ", without corners");
  }
  return mesh;
}

}  // namespace prehend::geometry
