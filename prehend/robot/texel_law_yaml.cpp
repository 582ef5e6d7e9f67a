#include "prehend/robot/texel_law_yaml.h"

#include <memory>
#include <stdexcept>
#include <vector>

#include "prehend/contact/compression_curve.h"
#include "prehend/contact/texel.h"
#include "prehend/geometry/errors.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot {

using contact::BristleLaw;
using contact::FoamMemory;
using contact::NormalLaw;

namespace {

// A list of maps {share, SECOND} at `key` of the map at `place`.
template <class Term>
std::vector<Term> terms_of(const text::YamlMap& map, const YAML::Node& list,
                           const std::filesystem::path& file, const std::string& place,
                           const std::string& key, const std::string& second, double Term::*share,
                           double Term::*other) {
  const std::string mend = "Write a list: [{share: 0.05, " + second + ": ...}]";
  if (!list.IsSequence()) map.fail(key, "is no list", mend);
  std::vector<Term> terms;
  for (const YAML::Node& node : list) {
    if (!node.IsMap() || !node["share"] || !node[second]) {
      map.fail(key, "has an entry without share or " + second, mend);
    }
    text::YamlMap entry(node, file, place + "." + key);
    Term& term = terms.emplace_back();
    entry.read("share", term.*share);
    entry.read(second, term.*other);
    entry.finish();
  }
  return terms;
}

}  // namespace

void read_texel_law(const YAML::Node& node, const std::filesystem::path& file,
                    const std::string& place, contact::TexelLaw& law) {
  text::YamlMap map(node, file, place);
  map.read("stiffness", law.stiffness);
  map.read("damping", law.damping);
  map.read("bristle_stiffness", law.bristle_stiffness);
  map.read("bristle_damping", law.bristle_damping);
  map.read("viscous_friction", law.viscous_friction);
  map.read("static_friction", law.static_friction);
  map.read("dynamic_friction", law.dynamic_friction);
  map.read("stribeck_velocity", law.stribeck_velocity);
  map.choose<NormalLaw>("normal_law",
                        {{"linear", NormalLaw::kLinear},
                         {"hunt_crossley", NormalLaw::kHuntCrossley},
                         {"tabulated", NormalLaw::kTabulated}},
                        law.normal_law);
  map.read("exponent", law.exponent);
  map.choose<BristleLaw>(
      "bristle_law",
      {{"lugre", BristleLaw::kLuGre}, {"elasto_plastic", BristleLaw::kElastoPlastic}},
      law.bristle_law);
  map.read("elastic_limit", law.elastic_limit);
  map.read("return_map", law.return_map);
  const YAML::Node curve = map.child("curve");
  if (const YAML::Node terms = map.child("creep")) {
    law.memory.creep =
        terms_of<FoamMemory::Creep>(map, terms, file, place, "creep", "time",
                                    &FoamMemory::Creep::share, &FoamMemory::Creep::time);
  }
  if (const YAML::Node terms = map.child("hysteresis")) {
    law.memory.hysteresis = terms_of<FoamMemory::Hysteresis>(
        map, terms, file, place, "hysteresis", "depth", &FoamMemory::Hysteresis::share,
        &FoamMemory::Hysteresis::depth);
  }
  map.finish();
  if (curve.IsDefined()) {
    std::vector<contact::CompressionCurve::Sample> samples;
    const auto is_number = [](const YAML::Node& value, double& number) {
      return value.IsScalar() && YAML::convert<double>::decode(value, number);
    };
    for (std::size_t i = 0; curve.IsSequence() && i < curve.size(); ++i) {
      contact::CompressionCurve::Sample sample;
      if (!curve[i].IsSequence() || curve[i].size() != 2 || !is_number(curve[i][0], sample.depth) ||
          !is_number(curve[i][1], sample.force)) {
        map.fail("curve", "has a sample that is no pair of numbers", "Write [depth, force]");
      }
      samples.push_back(sample);
    }
    try {
      law.curve = std::make_shared<contact::CompressionCurve>(samples);
    } catch (const std::invalid_argument& error) {
      map.fail("curve", std::string("is none: ") + error.what(), "Write [[0, 0], [depth, force]]");
    }
  }
  try {
    contact::validate(law);
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(file.string() + ": " + place + ": " + error.what(),
                               "Correct that value");
  }
}

}  // namespace prehend::robot
