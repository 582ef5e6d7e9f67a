#include "prehend/text/yaml_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "prehend/text/input_error.h"
#include "prehend/text/nearest_match.h"
#include "prehend/text/strict_yaml.h"

namespace prehend::text {
namespace {

template <typename Vector>
bool to_vector(const YAML::Node& node, Vector& value) {
  if (!node.IsSequence() || node.size() != static_cast<std::size_t>(value.size())) return false;
  Vector read;
  for (int i = 0; i < read.size(); ++i) {
    if (!YAML::convert<double>::decode(node[i], read[i]) || !std::isfinite(read[i])) return false;
  }
  value = read;
  return true;
}

YAML::Node as_map(YAML::Node node, const std::filesystem::path& path) {
  if (!node.IsMap()) {
    throw InputError(path.string() + ":1: expected a map of keys at the top",
                     "Write `key: value` lines");
  }
  return node;
}

thread_local KnownKeys* noting = nullptr;

}  // namespace

KnownKeys::KnownKeys() { noting = this; }
KnownKeys::~KnownKeys() { noting = nullptr; }

YAML::Node load_yaml_map(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) {
    throw InputError(path.string() + " does not exist or is no file", "Check the path");
  }
  try {
    return as_map(load_strict_yaml(path.string()), path);
  } catch (const YamlError& error) {
    throw InputError(error.what(), "Correct the YAML at that line");
  }
}

YAML::Node parse_yaml_map(const std::string& text, const std::filesystem::path& path) {
  try {
    return as_map(parse_strict_yaml(text, path.string()), path);
  } catch (const YamlError& error) {
    throw InputError(error.what(), "Correct the YAML at that line");
  }
}

YamlMap::YamlMap(const YAML::Node& node, std::filesystem::path file, std::string place)
    : node_(node), file_(std::move(file)), place_(std::move(place)) {
  if (!node_.IsMap()) {
    throw InputError(at(node_) + place_ + " must be a map", "Write `key: value` lines");
  }
}

std::string YamlMap::at(const YAML::Node& node) const {
  return file_.string() + ":" + std::to_string(node.Mark().line + 1) + ": ";
}

YAML::Node YamlMap::child(const std::string& key) {
  known_.insert(key);
  const YAML::Node& map = node_;  // operator[] of a const node does not insert the key
  return map[key];
}

void YamlMap::fail(const std::string& key, const std::string& wrong,
                   const std::string& mend) const {
  const YAML::Node value = node_[key];
  throw InputError(at(value.IsDefined() ? value : node_) + place_ + "." + key + " " + wrong, mend);
}

void YamlMap::read(const std::string& key, double& value) {
  const YAML::Node node = child(key);
  if (!node.IsDefined()) return;
  double read = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, read) || !std::isfinite(read)) {
    fail(key, "is no finite number", "Write a number");
  }
  value = read;
}

void YamlMap::read(const std::string& key, bool& value) {
  const YAML::Node node = child(key);
  if (!node.IsDefined()) return;
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) {
    fail(key, "is neither true nor false", "Write true or false");
  }
}

void YamlMap::read(const std::string& key, int& value) {
  const YAML::Node node = child(key);
  if (!node.IsDefined()) return;
  if (!node.IsScalar() || !YAML::convert<int>::decode(node, value)) {
    fail(key, "is no whole number", "Write a whole number");
  }
}

void YamlMap::read(const std::string& key, std::uint32_t& value) {
  const YAML::Node node = child(key);
  if (!node.IsDefined()) return;
  std::int64_t read = -1;
  if (!node.IsScalar() || !YAML::convert<std::int64_t>::decode(node, read) || read < 0 ||
      read > UINT32_MAX) {
    fail(key, "is no whole number from 0 to 4294967295", "Write such a number");
  }
  value = static_cast<std::uint32_t>(read);
}

void YamlMap::read(const std::string& key, std::string& value) {
  const YAML::Node node = child(key);
  if (!node.IsDefined()) return;
  if (!node.IsScalar()) fail(key, "is no text", "Write one word or quoted text");
  value = node.Scalar();
}

void YamlMap::read(const std::string& key, Eigen::Vector2d& value) {
  const YAML::Node node = child(key);
  if (node.IsDefined() && !to_vector(node, value)) {
    fail(key, "is no list of 2 finite numbers", "Write [x, y]");
  }
}

void YamlMap::read(const std::string& key, Eigen::Vector3d& value) {
  const YAML::Node node = child(key);
  if (node.IsDefined() && !to_vector(node, value)) {
    fail(key, "is no list of 3 finite numbers", "Write [x, y, z]");
  }
}

void YamlMap::finish() const {
  for (const std::string& key : known_) {
    if (noting) noting->keys_.emplace(place_, key);
  }
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "(not a word)";
    if (known_.count(key) != 0) continue;
    throw InputError(at(entry.first) + "unknown key '" + key + "' of " + place_,
                     nearest_match_mend(key, {known_.begin(), known_.end()}));
  }
}

}  // namespace prehend::text
