#include "eval/data_sets.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "eval/household_objects.h"

namespace prehend::eval {
namespace {

// FNV-1a: the same on every machine, unlike std::hash.
std::uint32_t hash_of(const std::string& text) {
  std::uint32_t hash = 2166136261U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

template <class Value>
std::uint32_t hash_of(const std::vector<Value>& values, std::uint32_t hash) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  for (std::size_t i = 0; i < values.size() * sizeof(Value); ++i) {
    hash = (hash ^ bytes[i]) * 16777619U;
  }
  return hash;
}

std::uint32_t content_of(const DataSet& set) {
  const Viewing& s = set.viewing;
  std::uint32_t hash =
      hash_of(std::vector<double>{static_cast<double>(s.sensor), s.elevation, s.distance,
                                  s.look_aside.x(), s.look_aside.y(), s.missing},
              2166136261U);
  for (const simulation::Texture& t : s.textures) {
    hash = hash_of(
        std::vector<double>{static_cast<double>(t.pattern), t.color.x(), t.color.y(), t.color.z(),
                            t.second_color.x(), t.second_color.y(), t.second_color.z(), t.contrast,
                            t.scale, static_cast<double>(t.seed)},
        hash);
  }
  hash = hash_of(set.mesh_B->triangles, hash_of(set.mesh_B->vertices, hash));
  for (const auto& other : s.others_B) {
    hash = hash_of(other->triangles, hash_of(other->vertices, hash));
  }
  return hash;
}

simulation::Texture texture_of(const std::string& name, std::uint64_t seed, double contrast) {
  using Pattern = simulation::Texture::Pattern;
  static constexpr Pattern kPatterns[] = {Pattern::kNoise, Pattern::kStripes, Pattern::kLabel};
  const std::uint32_t hash = hash_of(name);
  const auto channel = [hash](int shift, double low, double high) {
    return low + (high - low) * static_cast<double>(hash >> shift & 0xFF) / 255;
  };
  simulation::Texture texture;
  texture.pattern = kPatterns[hash % 3];
  texture.color = {channel(0, 0.3, 0.85), channel(8, 0.2, 0.7), channel(16, 0.15, 0.6)};
  texture.second_color = {channel(12, 0.6, 0.95), channel(20, 0.6, 0.95), channel(4, 0.5, 0.9)};
  texture.contrast = contrast;
  texture.seed = hash ^ static_cast<std::uint32_t>(seed);
  return texture;
}

// Looks from the elevation at the object, which is `look_aside` of the image's middle.
void place_camera(simulation::CameraSetup& camera, const Viewing& viewing) {
  const Eigen::Vector3d along = camera.eye - camera.target;
  const double distance = viewing.distance > 0 ? viewing.distance : along.norm();
  const double elevation = viewing.elevation > 0 ? viewing.elevation * std::numbers::pi / 180
                                                 : std::asin(along.z() / along.norm());
  camera.eye =
      camera.target + distance * Eigen::Vector3d(std::cos(elevation), 0, std::sin(elevation));
  const geometry::RigidTransform X_WC = camera.X_WC();
  const geometry::PinholeCamera& left = camera.camera.left;
  const Eigen::Vector2d aside(viewing.look_aside.x() * left.width / 2 / left.fx,
                              viewing.look_aside.y() * left.height / 2 / left.fy);
  camera.target -= X_WC.linear().leftCols<2>() * aside * distance;
}

}  // namespace

std::string Case::result_name() const {
  return fmt::format("{}-{:08x}", name(), data_set->content);
}

std::string Case::name() const {
  return fmt::format("{}-{}-{:03}-seed{}", data_set->group, data_set->name, orientation, seed);
}

geometry::RigidTransform Case::X_WB() const {
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  X_WB.linear() =
      Eigen::AngleAxisd(orientation * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()).matrix();
  return X_WB;
}

std::vector<DataSet> make_data_sets(const std::string& group,
                                    const std::vector<EvaluationObject>& objects) {
  std::vector<DataSet> sets;
  for (const EvaluationObject& object : objects) {
    sets.push_back({group, object.name, object.mesh_B, object.symmetric, object.viewing});
    if (!object.lies_too) continue;
    sets.push_back({group, object.name + "_lying",
                    std::make_shared<geometry::TriangleMesh>(lying(*object.mesh_B)),
                    object.symmetric, object.viewing});
  }
  for (DataSet& set : sets) set.content = content_of(set);
  return sets;
}

std::vector<Case> make_cases(const std::vector<DataSet>& data_sets, int orientations,
                             std::uint64_t seed) {
  std::vector<Case> cases;
  for (const DataSet& set : data_sets) {
    for (int k = 0; k < orientations; ++k) cases.push_back({&set, 360 * k / orientations, seed});
  }
  return cases;
}

RenderedScene scene_of(const Case& one, const Appearance& appearance) {
  RenderedScene rendered;
  rendered.scene.camera.noise = appearance.image_noise;
  rendered.scene.camera.seed = hash_of(one.name());
  rendered.scene.light.ambient = appearance.ambient;
  const Viewing& viewing = one.data_set->viewing;
  place_camera(rendered.scene.camera, viewing);
  rendered.sensor = viewing.sensor;
  rendered.missing = viewing.missing;
  const auto add = [&](const std::string& name,
                       const std::shared_ptr<const geometry::TriangleMesh>& mesh_B) {
    simulation::VisibleBody body;
    body.name = name;
    body.mesh_B = mesh_B;
    body.X_WB = one.X_WB();
    body.texture = viewing.textures.empty()
                       ? texture_of(name, one.seed, appearance.texture_contrast)
                       : viewing.textures.at(rendered.bodies.size());
    body.height = geometry::bounds(*mesh_B).max().z();
    rendered.bodies.push_back(std::move(body));
  };
  add(one.data_set->name, one.data_set->mesh_B);
  for (const auto& other : viewing.others_B) {
    add(fmt::format("{}_other_{}", one.data_set->name, rendered.bodies.size()), other);
  }
  return rendered;
}

}  // namespace prehend::eval
