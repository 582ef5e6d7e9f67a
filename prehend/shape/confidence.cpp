#include "prehend/shape/confidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/strict_yaml.h"

namespace prehend::shape {
namespace {

using geometry::InputError;

struct Coefficient {
  const char* name;
  double ConfidenceModel::*value;
  bool may_be_negative;
};

constexpr std::array kCoefficients{
    Coefficient{"mirror", &ConfidenceModel::mirror, true},
    Coefficient{"rotation", &ConfidenceModel::rotation, true},
    Coefficient{"extrusion", &ConfidenceModel::extrusion, true},
    Coefficient{"convex_hull", &ConfidenceModel::convex_hull, true},
    Coefficient{"refused_mirror", &ConfidenceModel::refused_mirror, true},
    Coefficient{"contradiction", &ConfidenceModel::contradiction, false},
    Coefficient{"contradicted", &ConfidenceModel::contradicted, false},
    Coefficient{"unsupported", &ConfidenceModel::unsupported, false},
    Coefficient{"unseen", &ConfidenceModel::unseen, false},
    Coefficient{"ambiguous", &ConfidenceModel::ambiguous, false},
    Coefficient{"concavity", &ConfidenceModel::concavity, false},
    Coefficient{"open_vessel", &ConfidenceModel::open_vessel, false},
    Coefficient{"cut_by_image", &ConfidenceModel::cut_by_image, false},
    Coefficient{"occluded", &ConfidenceModel::occluded, false},
    Coefficient{"on_another", &ConfidenceModel::on_another, false},
    Coefficient{"disagreement", &ConfidenceModel::disagreement, false},
    Coefficient{"guessed_depth", &ConfidenceModel::guessed_depth, false},
    Coefficient{"may_be_several", &ConfidenceModel::may_be_several, false},
};

}  // namespace

double confidence(const Evidence& e, const ConfidenceModel& model) {
  double x = 0;
  switch (e.method) {
    case CompletionMethod::kMirror:
      x = model.mirror;
      break;
    case CompletionMethod::kRotation:
      x = model.rotation;
      break;
    case CompletionMethod::kExtrusion:
      x = model.extrusion;
      break;
    case CompletionMethod::kConvexHull:
      x = model.convex_hull;
      break;
    case CompletionMethod::kRefusedMirror:
      x = model.refused_mirror;
      break;
  }
  x -= model.contradiction * std::sqrt(std::clamp(e.contradiction, 0.0, 1.0)) +
       model.contradicted * std::sqrt(std::clamp(e.contradicted, 0.0, 1.0)) +
       model.unsupported * (1 - e.support) + model.unseen * e.unseen +
       model.ambiguous * (1 - e.margin) + model.concavity * e.concavity;
  if (e.open_vessel()) x -= model.open_vessel;
  if (e.cut_by_image) x -= model.cut_by_image;
  constexpr double kRight = 0.005;  // m
  constexpr double kDeep = 0.1;     // m
  x -= model.occluded * std::sqrt(std::clamp(e.occluded, 0.0, 1.0)) +
       model.disagreement * std::clamp(e.disagreement / kRight, 0.0, 1.0) +
       model.guessed_depth * std::max(0.0, e.guessed_depth) / kDeep;
  if (e.on_another) x -= model.on_another;
  if (e.may_be_several) x -= model.may_be_several;
  return 1 / (1 + std::exp(-x));
}

ConfidenceModel read_confidence_model(const std::filesystem::path& path) {
  const std::string place = "the confidence model " + path.string();
  YAML::Node file;
  try {
    file = text::load_strict_yaml(path.string());
  } catch (const text::YamlError& error) {
    throw InputError(place + " cannot be read: " + error.what(), "check the path and its YAML");
  }
  if (!file.IsMap()) throw InputError(place + " is not a map", "write lines `name: number`");
  ConfidenceModel model;
  for (const auto& entry : file) {
    const auto key = entry.first.as<std::string>();
    const auto* found = std::find_if(kCoefficients.begin(), kCoefficients.end(),
                                     [&](const Coefficient& c) { return key == c.name; });
    if (found == kCoefficients.end()) {
      std::string names;
      for (const Coefficient& c : kCoefficients) names += std::string(" ") + c.name;
      throw InputError(place + " has the unknown coefficient '" + key + "'", "use one of:" + names);
    }
    double value = NAN;
    if (!YAML::convert<double>::decode(entry.second, value) || !std::isfinite(value) ||
        (value < 0 && !found->may_be_negative)) {
      throw InputError(place + ": '" + key + "' is not a finite number" +
                           (found->may_be_negative ? "" : " >= 0"),
                       "give one");
    }
    model.*found->value = value;
  }
  return model;
}

}  // namespace prehend::shape
