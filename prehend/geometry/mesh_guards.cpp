#include "prehend/geometry/mesh_guards.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include <assimp/scene.h>
#include <nlohmann/json.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/text/json_size.h"

namespace prehend::geometry {
namespace {

/// The JSON of a glTF file, or of the first part of a binary one.
std::string gltf_text(const std::filesystem::path& path, bool is_binary) {
  std::string text = text_of(path);
  if (!is_binary) return text;
  constexpr std::size_t kHead = 20;  // magic, version, length; the first part's length and kind
  std::uint32_t length = 0;
  if (text.size() >= kHead) std::memcpy(&length, text.data() + 12, sizeof length);
  if (text.size() < kHead || length > text.size() - kHead) refuse_mesh(path, "is truncated");
  return text.substr(kHead, length);
}

/// What a glTF file makes of its nodes and accessors. They are in lists, by their number; in glTF 1
/// in objects, by their name.
class Gltf {
 public:
  Gltf(const nlohmann::json& file, std::filesystem::path path)
      : file_(file), path_(std::move(path)) {}

  void check() {
    for (const nlohmann::json& node : all("nodes")) stands_for(node, 0);
    std::size_t shown = 0;
    for (const nlohmann::json& scene : all("scenes")) {
      for (const nlohmann::json& key : list(scene, "nodes")) {
        if (const auto* node = entry("nodes", key)) shown += stands_for(*node, 0);
        refuse_above(shown, kMostNodes, "shows its nodes more than 100,000 times");
      }
    }
    std::size_t copied = 0;
    for (const nlohmann::json& mesh : all("meshes")) {
      for (const nlohmann::json& primitive : list(mesh, "primitives")) {
        copied += length_of(primitive, "indices");
        if (primitive.is_object() && primitive.contains("attributes")) {
          for (const auto& item : primitive["attributes"].items()) copied += length(item.value());
        }
        refuse_above(copied, kMostNumbers, "has meshes of more than 100 million vertices");
      }
    }
  }

 private:
  static constexpr std::size_t kMostNumbers = 100000000;

  void refuse_above(std::size_t count, std::size_t most, const char* what) const {
    if (count > most) refuse_mesh(path_, what);
  }
  static const nlohmann::json& nothing() {
    static const nlohmann::json kNothing = nlohmann::json::array();
    return kNothing;
  }
  const nlohmann::json& all(const char* name) const {
    const auto found = file_.find(name);
    return found != file_.end() && found->is_structured() ? *found : nothing();
  }
  static const nlohmann::json& list(const nlohmann::json& object, const char* name) {
    if (!object.is_object()) return nothing();
    const auto found = object.find(name);
    return found != object.end() && found->is_array() ? *found : nothing();
  }
  /// One of `name`; null: it is not there.
  const nlohmann::json* entry(const char* name, const nlohmann::json& key) const {
    const nlohmann::json& known = all(name);
    if (known.is_array() && key.is_number_unsigned() && key < known.size()) {
      return &known[key.get<std::size_t>()];
    }
    if (known.is_object() && key.is_string()) {
      const auto found = known.find(key.get<std::string>());
      if (found != known.end()) return &*found;
    }
    return nullptr;
  }
  std::size_t length(const nlohmann::json& key) const {
    const nlohmann::json* accessor = entry("accessors", key);
    if (!accessor || !accessor->is_object() || !accessor->contains("count")) return 0;
    const nlohmann::json& count = (*accessor)["count"];
    return count.is_number_unsigned() ? std::min(count.get<std::size_t>(), 2 * kMostNumbers) : 0;
  }
  std::size_t length_of(const nlohmann::json& primitive, const char* name) const {
    return primitive.is_object() && primitive.contains(name) ? length(primitive[name]) : 0;
  }

  /// How many nodes are made of one with all below it.
  std::size_t stands_for(const nlohmann::json& node, int depth) {
    if (depth > kDeepestLevel) refuse_mesh(path_, "has nodes deeper than 100, or in a ring");
    const auto known = counts_.find(&node);
    if (known != counts_.end() && known->second.depth + depth <= kDeepestLevel) {
      return known->second.nodes;
    }
    Count count;
    for (const nlohmann::json& key : list(node, "children")) {
      const nlohmann::json* child = entry("nodes", key);
      if (!child) continue;
      count.nodes += stands_for(*child, depth + 1);
      refuse_above(count.nodes, kMostNodes, "shows its nodes more than 100,000 times");
      count.depth = std::max(count.depth, counts_[child].depth + 1);
    }
    counts_[&node] = count;
    return count.nodes;
  }

  struct Count {
    std::size_t nodes = 1;
    int depth = 0;  // levels below it
  };
  const nlohmann::json& file_;
  const std::filesystem::path path_;
  std::map<const nlohmann::json*, Count> counts_;
};

}  // namespace

void refuse_mesh(const std::filesystem::path& path, const std::string& what) {
  throw InputError('\'' + path.string() + "' " + what, "Export it again, as STL or OBJ");
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void refuse_unsound_gltf(const std::filesystem::path& path, bool is_binary) {
  const std::string text = gltf_text(path, is_binary);
  text::refuse_json_bomb(text, path.string());
  const nlohmann::json file = nlohmann::json::parse(text, nullptr, false);
  if (!file.is_object()) refuse_mesh(path, "could not be read: it is no JSON object");
  Gltf(file, path).check();
}

void refuse_unsound_scene(const std::filesystem::path& path, const aiScene& scene) {
  constexpr double kMostWork = 1e8;  // cutting a polygon takes the square of its corners
  constexpr std::size_t kMostVertices = 20000000;
  double work = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices == 0) refuse_mesh(path, "has a face without corners");
      if (face.mNumIndices > 3) work += static_cast<double>(face.mNumIndices) * face.mNumIndices;
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        if (face.mIndices[k] < mesh.mNumVertices) continue;
        refuse_mesh(path, "has a face with a vertex that does not exist");
      }
    }
  }
  if (work > kMostWork) refuse_mesh(path, "has polygons of too many corners");
  std::size_t vertices = 0;
  std::vector<const aiNode*> nodes;
  if (scene.mRootNode) nodes.push_back(scene.mRootNode);
  while (!nodes.empty()) {
    const aiNode& node = *nodes.back();
    nodes.pop_back();
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene.mNumMeshes) refuse_mesh(path, "shows a mesh that is not there");
      vertices += scene.mMeshes[node.mMeshes[i]]->mNumVertices;
    }
    if (vertices > kMostVertices) {
      refuse_mesh(path, "shows its meshes so often that they have more than 20 million vertices");
    }
    nodes.insert(nodes.end(), node.mChildren, node.mChildren + node.mNumChildren);
  }
}

}  // namespace prehend::geometry
