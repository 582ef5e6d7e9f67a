#include "prehend/robot/formats/inventor_mesh.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <mutex>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <Inventor/SbVec3f.h>
#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/errors/SoError.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;

constexpr const char* kMend = "Convert it to STL, OBJ, PLY or COLLADA";

/// Coin's, from the first file on until the program ends.
struct CoinDatabase {
  CoinDatabase() { SoDB::init(); }
  ~CoinDatabase() { SoDB::finish(); }
  CoinDatabase(const CoinDatabase&) = delete;
  CoinDatabase& operator=(const CoinDatabase&) = delete;
};

void collect_error(const SoError* error, void* words) {
  auto& text = *static_cast<std::string*>(words);
  if (text.size() < 300)
    text += (text.empty() ? "" : "; ") + std::string(error->getDebugString().getString());
}

void collect_triangle(void* mesh, SoCallbackAction* action, const SoPrimitiveVertex* a,
                      const SoPrimitiveVertex* b, const SoPrimitiveVertex* c) {
  auto& all = *static_cast<geometry::TriangleMesh*>(mesh);
  const int first = static_cast<int>(all.vertices.size());
  const SbMatrix& X = action->getModelMatrix();
  for (const SoPrimitiveVertex* vertex : {a, b, c}) {
    SbVec3f p;
    X.multVecMatrix(vertex->getPoint(), p);
    all.vertices.emplace_back(p[0], p[1], p[2]);
  }
  // A transform that mirrors turns the surface's inside out.
  const bool is_mirrored = X.det3() < 0;
  all.triangles.emplace_back(first, first + (is_mirrored ? 2 : 1), first + (is_mirrored ? 1 : 2));
}

/// Coin includes files while it reads, and one that includes itself without end: looked for before.
void refuse_rings(const std::filesystem::path& file, std::vector<std::filesystem::path>& above) {
  std::error_code error;
  const auto place = std::filesystem::weakly_canonical(file, error);
  if (std::find(above.begin(), above.end(), place) != above.end()) {
    throw InputError("'" + file.string() + "' includes itself", "Take one of its File nodes out");
  }
  constexpr std::size_t kDeepest = 32;
  if (above.size() > kDeepest) {
    throw InputError("'" + file.string() + "' is included too deep", "Put the files into one");
  }
  std::ifstream stream(place, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  const std::string all = text.str();
  above.push_back(place);
  // Bounded, since the library's regular expressions call themselves for each sign.
  static const std::regex kInclude(
      R"((?:File|WWWInline|Texture2|ImageTexture)\s{0,99}\{\s{0,99}(?:name|filename|url)\s{1,99}\"?([^\s\"}]{1,999}))");
  for (std::sregex_iterator at(all.begin(), all.end(), kInclude), end; at != end; ++at) {
    const std::filesystem::path included = place.parent_path() / (*at)[1].str();
    if ((*at)[1].length() >= 999) {
      throw InputError("'" + file.string() + "' names a file by more than 999 signs", kMend);
    }
    // Opening a pipe would wait for ever.
    if (std::filesystem::is_other(included, error)) {
      throw InputError("'" + included.string() + "' is no file", "Name one");
    }
    const bool is_part = (*at)[0].str().starts_with("File") || (*at)[0].str().starts_with("WWW");
    if (is_part && std::filesystem::is_regular_file(included, error)) refuse_rings(included, above);
  }
  above.pop_back();
}

}  // namespace

bool is_inventor_file(const std::filesystem::path& file) {
  const std::string ending = geometry::lower_case_extension(file);
  return ending == ".iv" || ending == ".wrl" || ending == ".vrml";
}

geometry::TriangleMesh read_inventor_mesh(const std::filesystem::path& file) {
  geometry::checked_file_size(file);
  std::vector<std::filesystem::path> above;
  refuse_rings(file, above);

  static std::mutex one_at_a_time;  // Coin's data base is one for all
  const std::lock_guard lock(one_at_a_time);
  static const CoinDatabase database;
  std::string complaints;
  SoErrorCB* const handler = SoError::getHandlerCallback();
  void* const handler_data = SoError::getHandlerData();
  SoError::setHandlerCallback(collect_error, &complaints);
  geometry::TriangleMesh mesh;
  {
    const std::string folder = std::filesystem::absolute(file).parent_path().string();
    SoInput::addDirectoryFirst(folder.c_str());
    SoInput input;
    SoSeparator* root = input.openFile(file.c_str(), TRUE) ? SoDB::readAll(&input) : nullptr;
    if (root != nullptr) {
      root->ref();
      SoCallbackAction action;
      action.addTriangleCallback(SoShape::getClassTypeId(), collect_triangle, &mesh);
      action.apply(root);
      root->unref();
    }
    SoInput::removeDirectory(folder.c_str());
  }
  SoError::setHandlerCallback(handler, handler_data);

  std::replace(complaints.begin(), complaints.end(), '\n', ' ');
  if (mesh.triangles.empty()) {
    throw InputError("'" + file.string() + "' " +
                         (complaints.empty() ? "has no surface" : "is not read: " + complaints),
                     kMend);
  }
  for (const Eigen::Vector3d& p : mesh.vertices) {
    if (!p.allFinite()) {
      throw InputError("'" + file.string() + "' has a vertex that is not a number", kMend);
    }
  }
  constexpr double kRounding = 1e-6;  // of the mesh's extent
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  return extent > 0 ? geometry::with_merged_vertices(mesh, kRounding * extent) : mesh;
}

}  // namespace prehend::robot::formats
