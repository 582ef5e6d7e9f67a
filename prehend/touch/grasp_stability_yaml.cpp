#include <cmath>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/geometry/whole_file.h"
#include "prehend/text/yaml_map.h"
#include "prehend/touch/grasp_stability.h"

namespace prehend::touch {
namespace {

constexpr int kVersion = 1;  // of the file
constexpr const char* kMend = "Write the file anew: eval_grasp_stability --fit";

GraspStability::Weighed read_moment(const YAML::Node& node, const std::filesystem::path& file,
                                    GripMoment moment) {
  text::YamlMap map(node, file, to_string(moment));
  const auto number = [](text::YamlMap& from, const std::string& key) {
    double value = std::numeric_limits<double>::quiet_NaN();
    from.read(key, value);
    if (!std::isfinite(value)) from.fail(key, "is missing or no finite number", kMend);
    return value;
  };
  const std::vector<std::string>& names = grip_feature_names(moment);
  const auto size = static_cast<Eigen::Index>(names.size());
  GraspStability::Weighed read{Eigen::VectorXd(size), Eigen::VectorXd(size), Eigen::VectorXd(size),
                               number(map, "bias")};
  const YAML::Node given = map.child("features");
  if (!given.IsDefined()) map.fail("features", "is missing", kMend);
  text::YamlMap features(given, file, to_string(moment) + ".features");
  for (Eigen::Index i = 0; i < size; ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    const YAML::Node child = features.child(name);
    if (!child.IsDefined()) features.fail(name, "is missing", kMend);
    text::YamlMap feature(child, file, name);
    read.mean[i] = number(feature, "mean");
    read.deviation[i] = number(feature, "deviation");
    read.weight[i] = number(feature, "weight");
    if (!(read.deviation[i] > 0)) feature.fail("deviation", "is not above 0", kMend);
    feature.finish();
  }
  features.finish();
  map.finish();
  return read;
}

}  // namespace

GraspStability GraspStability::load(const std::filesystem::path& file) {
  text::YamlMap map(text::load_yaml_map(file), file, "grasp stability");
  int version = 0;
  map.read("version", version);
  if (version != kVersion) {
    map.fail("version", fmt::format("is {}", version),
             fmt::format("This program reads {}. {}", kVersion, kMend));
  }
  const auto moment = [&](GripMoment of) {
    const YAML::Node node = map.child(to_string(of));
    if (!node.IsDefined()) map.fail(to_string(of), "is missing", kMend);
    return read_moment(node, file, of);
  };
  Weighed closed = moment(GripMoment::kClosed), lifting = moment(GripMoment::kLifting);
  map.finish();
  return {std::move(closed), std::move(lifting)};
}

void GraspStability::save(const std::filesystem::path& file, const std::string& made_by) const {
  std::string text =
      "# How likely a lift holds, by what the pads feel (prehend/touch/grasp_stability.h).\n";
  std::istringstream lines(made_by);
  for (std::string line; std::getline(lines, line);) text += "# " + line + "\n";
  text += fmt::format("version: {}\n", kVersion);
  for (const GripMoment moment : {GripMoment::kClosed, GripMoment::kLifting}) {
    const Weighed& one = of(moment);
    text += fmt::format("{}:\n  bias: {:.6g}\n  features:\n", to_string(moment), one.bias);
    const std::vector<std::string>& names = grip_feature_names(moment);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      text += fmt::format("    {}: {{mean: {:.6g}, deviation: {:.6g}, weight: {:.6g}}}\n", names[i],
                          one.mean[at], one.deviation[at], one.weight[at]);
    }
  }
  geometry::write_whole_file(file, text, "The model of grasp stability");
}

}  // namespace prehend::touch
