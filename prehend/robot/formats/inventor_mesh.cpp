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
#include <Inventor/nodes/SoArray.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/file_headers.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/inventor_guards.h"

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

/// What is taken out of Coin's graph.
struct Collected {
  geometry::TriangleMesh mesh;
  std::string wrong;      // with one of its shapes
  std::size_t nodes = 0;  // as often as they are shown: by USE and arrays

  bool is_too_much() const {
    constexpr std::size_t kMostNodes = 100000, kMostTriangles = 20000000;
    return nodes > kMostNodes || mesh.triangles.size() > kMostTriangles;
  }
};

void collect_triangle(void* collected, SoCallbackAction* action, const SoPrimitiveVertex* a,
                      const SoPrimitiveVertex* b, const SoPrimitiveVertex* c) {
  if (static_cast<Collected*>(collected)->is_too_much()) return;
  geometry::TriangleMesh& all = static_cast<Collected*>(collected)->mesh;
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

/// How often a node shows what is below it.
std::size_t places_of(const SoNode& node) {
  if (!node.isOfType(SoArray::getClassTypeId())) return 1;
  const auto& array = static_cast<const SoArray&>(node);
  double places = 1;
  for (const SoSFShort* count : {&array.numElements1, &array.numElements2, &array.numElements3}) {
    places *= std::max<int>(count->getValue(), 0);
  }
  return static_cast<std::size_t>(std::max(places, 1.0));
}

SoCallbackAction::Response look_at_node(void* data, SoCallbackAction* action, const SoNode* node) {
  auto& collected = *static_cast<Collected*>(data);
  // An array goes on through all its places though the action has ended: it may not begin.
  collected.nodes += places_of(*node);
  if (collected.is_too_much() || !collected.wrong.empty()) return SoCallbackAction::ABORT;
  if (is_no_surface(*node)) return SoCallbackAction::PRUNE;
  if (!node->isOfType(SoShape::getClassTypeId())) return SoCallbackAction::CONTINUE;
  // The graph is this reader's own.
  const std::string wrong = wrong_with_shape(*action, *const_cast<SoNode*>(node));
  if (wrong.empty()) return SoCallbackAction::CONTINUE;
  collected.wrong = std::string(node->getTypeId().getName().getString()) + " " + wrong;
  return SoCallbackAction::ABORT;
}

/// The text without comments, and with one blank for each run of them; commas are blanks.
/// @throws InputError for nodes deeper than any graph has: Coin calls itself for each level.
std::string plain_text(const std::string& all, const std::filesystem::path& file) {
  constexpr int kDeepest = 200;
  std::string plain;
  int depth = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    char c = all[i];
    if (is_quoted) {
      plain += c;
      is_quoted = c != '"';
      if (c == '\\' && i + 1 < all.size()) plain += all[++i];
      continue;
    }
    if (c == '#') {
      i = std::min(all.find('\n', i), all.size());
      c = ' ';
    }
    is_quoted = c == '"';
    if (c == '{' || c == '[') ++depth;
    if ((c == '}' || c == ']') && depth > 0) --depth;
    if (depth > kDeepest) {
      throw InputError("'" + file.string() + "' is nested deeper than 200 levels", kMend);
    }
    const bool is_blank = std::isspace(static_cast<unsigned char>(c)) != 0 || c == ',';
    if (!is_blank || (!plain.empty() && plain.back() != ' ')) plain += is_blank ? ' ' : c;
  }
  return plain;
}

/// What Coin unpacks, or reads without braces, cannot be looked over before.
bool is_packed(const std::string& all) {
  const std::string line = all.substr(0, std::min<std::size_t>(all.find('\n'), 100));
  return all.starts_with("\x1f\x8b") || all.starts_with("BZh") || all.starts_with("PK") ||
         line.find("binary") != std::string::npos;
}

/// Coin includes files while it reads, and one that includes itself without end: looked for before.
void refuse_rings(const std::filesystem::path& file, std::vector<std::filesystem::path>& above,
                  FileBudget& files) {
  files.spend(file);
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
  if (is_packed(all)) {
    throw InputError("'" + file.string() + "' is a binary or packed file of Inventor or VRML",
                     "Save it as text, or convert it to STL, OBJ, PLY or COLLADA");
  }
  // Bounded, since the library's regular expressions call themselves for each sign.
  static const std::regex kInclude(R"(\b(?:name|filename|url) ?\[? ?\"?([^ \"\]\}]{1,999}))");
  const std::string plain = plain_text(all, file);
  if (plain.find("PROTO ") != std::string::npos) {
    throw InputError("'" + file.string() + "' has prototypes (PROTO), which are not read", kMend);
  }
  for (std::sregex_iterator at(plain.begin(), plain.end(), kInclude), end; at != end; ++at) {
    const std::filesystem::path included = place.parent_path() / (*at)[1].str();
    if ((*at)[1].length() >= 999) {
      throw InputError("'" + file.string() + "' names a file by more than 999 signs", kMend);
    }
    // Opening a pipe would wait for ever.
    if (std::filesystem::is_other(included, error)) {
      throw InputError("'" + included.string() + "' is no file", "Name one");
    }
    if (std::filesystem::is_regular_file(included, error)) refuse_rings(included, above, files);
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
  FileBudget files;
  refuse_rings(file, above, files);

  static std::mutex one_at_a_time;  // Coin's data base is one for all
  const std::lock_guard lock(one_at_a_time);
  static const CoinDatabase database;
  std::string complaints;
  SoErrorCB* const handler = SoError::getHandlerCallback();
  void* const handler_data = SoError::getHandlerData();
  SoError::setHandlerCallback(collect_error, &complaints);
  Collected collected;
  {
    const std::string folder = std::filesystem::absolute(file).parent_path().string();
    SoInput::addDirectoryFirst(folder.c_str());
    SoInput input;
    SoSeparator* root = input.openFile(file.c_str(), TRUE) ? SoDB::readAll(&input) : nullptr;
    if (root != nullptr) {
      root->ref();
      SoCallbackAction action;
      action.addPreCallback(SoNode::getClassTypeId(), look_at_node, &collected);
      action.addTriangleCallback(SoShape::getClassTypeId(), collect_triangle, &collected);
      action.apply(root);
      root->unref();
    }
    SoInput::removeDirectory(folder.c_str());
  }
  SoError::setHandlerCallback(handler, handler_data);

  if (collected.is_too_much()) {
    throw InputError(
        "'" + file.string() + "' shows more than 100,000 nodes, or 20 million triangles",
        "Look whether its nodes name one another again and again");
  }
  if (!collected.wrong.empty()) {
    throw InputError("'" + file.string() + "': " + collected.wrong, kMend);
  }
  geometry::TriangleMesh& mesh = collected.mesh;
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
