#include "prehend/robot/formats/collada_materials.h"

#include <algorithm>

#include "prehend/robot/formats/collada_elements.h"

namespace prehend::robot::formats {
namespace {

// COLLADA 1.5, "Determining transparency (opacity)": by <transparent>, weighed by <transparency>.
// The diffuse colour's own alpha says nothing: exporters leave it at 0.
double collada_opacity(const XmlElement& light) {
  const auto transparent = light.child("transparent");
  const double weight = number_in(light.child("transparency")).value_or(1);
  if (!transparent) return 1;  // transparency weighs nothing then
  const std::string mode = transparent->attribute("opaque").value_or("A_ONE");
  const auto color = transparent->child("color");
  if (!color) {
    transparent->drop("textures are not kept");
    return 1;
  }
  color->attribute("sid");
  const auto n = color->text_numbers(4);
  const double luminance = 0.212671 * n[0] + 0.715160 * n[1] + 0.072169 * n[2];
  const double amount = weight * (mode.starts_with("RGB") ? luminance : n[3]);
  return std::clamp(mode.ends_with("_ZERO") ? 1 - amount : amount, 0.0, 1.0);
}

}  // namespace

std::map<std::string, XmlElement> ColladaMaterials::bound_by(const XmlElement& instance) {
  std::map<std::string, XmlElement> materials;  // by symbol
  if (const auto bind = instance.child("bind_material")) {
    if (const auto technique = bind->child("technique_common")) {
      for (const XmlElement& one : technique->children("instance_material")) {
        const auto material = document_.by_url(one.attribute("target").value_or(""));
        if (material) {
          materials.emplace(one.attribute("symbol").value_or(""), *material);
        } else {
          one.drop("its material is not there");
        }
      }
    }
  }
  return materials;
}

std::optional<std::array<double, 4>> ColladaMaterials::color(const XmlElement& material) {
  const auto instance = material.child("instance_effect");
  const auto effect =
      instance ? document_.by_url(instance->attribute("url").value_or("")) : std::nullopt;
  const auto profile = effect ? effect->child("profile_COMMON") : std::nullopt;
  const auto technique = profile ? profile->child("technique") : std::nullopt;
  if (!technique) return std::nullopt;
  technique->attribute("sid");
  const bool is_new = told_.insert(effect->attribute("id").value_or("")).second;
  for (const char* kind : {"phong", "lambert", "blinn", "constant"}) {
    const auto light = technique->child(kind);
    if (!light) continue;
    for (const XmlElement& one : light->children()) {
      const bool is_color =
          one.name() == "diffuse" || one.name() == "transparent" || one.name() == "transparency";
      if (!is_color && is_new) one.drop("how it is lit");
    }
    const auto diffuse = light->child("diffuse");
    if (!diffuse) continue;
    const auto given = diffuse->child("color");
    if (!given) {
      if (is_new) diffuse->drop("textures are not kept");
      continue;
    }
    given->attribute("sid");
    const auto n = given->text_numbers(0);
    if (n.size() < 3) given->fail("a colour has three or four numbers", "Mend it");
    const auto part = [&](std::size_t i) { return std::clamp(n[i], 0.0, 1.0); };
    return {{part(0), part(1), part(2), collada_opacity(*light)}};
  }
  return std::nullopt;
}

}  // namespace prehend::robot::formats
