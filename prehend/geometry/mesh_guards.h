#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

struct aiScene;

// What Assimp 5.2 does not bear: it calls itself for each level of a file, copies what is named as
// often as it is named, and takes numbers of a file for true. Internal to prehend::mesh_files.
namespace prehend::geometry {

inline constexpr int kDeepestLevel = 100;
inline constexpr std::size_t kMostNodes = 100000;  // as often as they are shown

/// @throws InputError, with the mend.
[[noreturn]] void refuse_mesh(const std::filesystem::path& path, const std::string& what);

std::string text_of(const std::filesystem::path& path);

/// The text of a COLLADA file for Assimp: without animations, which move no mesh that is read, and
/// with the meshes of its skins as they are at rest instead of the skins.
/// @throws InputError for a file that is no XML, that is nested deeper than 100 levels, whose nodes
/// name one another in a ring or stand for more than 100,000, and for lists of numbers that are
/// shorter than is said, or none.
std::string sound_collada(const std::filesystem::path& path);

/// Looks over a glTF file before Assimp reads it.
/// @throws InputError for a file that is no JSON, that is nested deeper than 32 levels, or whose
/// nodes name one another in a ring or stand for more than 100,000.
void refuse_unsound_gltf(const std::filesystem::path& path, bool is_binary);

/// Looks over what Assimp has read before it makes triangles of it.
/// @throws InputError for faces without corners or of vertices that do not exist, for polygons of
/// so many corners that their triangles take minutes, and for nodes that show a mesh so often that
/// there are more than 20 million vertices.
void refuse_unsound_scene(const std::filesystem::path& path, const aiScene& scene);

}  // namespace prehend::geometry
