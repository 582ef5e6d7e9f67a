#include "eval/data_sets.h"

#include <fmt/format.h>

#include <numbers>

namespace prehend::eval {
namespace {

// FNV-1a: the same on every machine, unlike std::hash.
std::uint32_t hash_of(const std::string& text) {
  std::uint32_t hash = 2166136261U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

simulation::Texture texture_of(const Case& one, double contrast) {
  using Pattern = simulation::Texture::Pattern;
  static constexpr Pattern kPatterns[] = {Pattern::kNoise, Pattern::kStripes, Pattern::kLabel};
  const std::uint32_t hash = hash_of(one.data_set->name);
  const auto channel = [hash](int shift, double low, double high) {
    return low + (high - low) * static_cast<double>(hash >> shift & 0xFF) / 255;
  };
  simulation::Texture texture;
  texture.pattern = kPatterns[hash % 3];
  texture.color = {channel(0, 0.3, 0.85), channel(8, 0.2, 0.7), channel(16, 0.15, 0.6)};
  texture.second_color = {channel(12, 0.6, 0.95), channel(20, 0.6, 0.95), channel(4, 0.5, 0.9)};
  texture.contrast = contrast;
  texture.seed = hash ^ static_cast<std::uint32_t>(one.seed);
  return texture;
}

}  // namespace

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
    sets.push_back({group, object.name, object.mesh_B, object.symmetric});
    if (!object.lies_too) continue;
    sets.push_back({group, object.name + "_lying",
                    std::make_shared<geometry::TriangleMesh>(lying(*object.mesh_B)),
                    object.symmetric});
  }
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
  simulation::VisibleBody body;
  body.name = one.data_set->name;
  body.mesh_B = one.data_set->mesh_B;
  body.X_WB = one.X_WB();
  body.texture = texture_of(one, appearance.texture_contrast);
  body.height = geometry::bounds(*body.mesh_B).max().z();
  rendered.bodies.push_back(std::move(body));
  return rendered;
}

}  // namespace prehend::eval
