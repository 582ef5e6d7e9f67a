#include "prehend/fidelity/front.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/whole_file.h"
#include "prehend/text/strict_yaml.h"

namespace prehend::fidelity {
namespace {

using geometry::InputError;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what) {
  throw InputError("The front '" + file.string() + "' " + what,
                   "Measure it again with eval_tradeoff");
}

void check_not_empty(const Front& front) {
  if (front.settings.empty()) {
    throw std::invalid_argument("The front of '" + front.subject + "' has no setting");
  }
}

std::string error_text(double error, const std::string& unit) {
  return unit == "m" ? fmt::format("{:.4g} mm", 1e3 * error)
                     : fmt::format("{:.4g} {}", error, unit);
}

std::string described(const Setting& setting, const std::string& unit) {
  return fmt::format("{:.4g} ms, {}", 1e3 * setting.seconds, error_text(setting.error, unit));
}

double number_of(const YAML::Node& node, const char* key, const std::filesystem::path& file) {
  double value = 0;
  if (!node[key] || !YAML::convert<double>::decode(node[key], value) || !std::isfinite(value) ||
      value < 0) {
    fail(file, std::string("has no number '") + key + "' that is 0 or more");
  }
  return value;
}

void check_keys(const YAML::Node& node, std::initializer_list<const char*> known,
                const std::filesystem::path& file) {
  if (!node.IsMap()) fail(file, "is no map of keys");
  for (const auto& entry : node) {
    const auto key = entry.first.as<std::string>();
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      fail(file, "has an unknown key '" + key + "'");
    }
  }
}

// In its error or in another one.
bool is_better(const Setting& one, const Setting& other) {
  if (one.error < other.error) return true;
  for (std::size_t i = 0; i < one.other_errors.size(); ++i) {
    if (one.other_errors[i].second < other.other_errors[i].second) return true;
  }
  return false;
}

}  // namespace

std::string to_string(const Setting& setting) {
  std::string text;
  for (const auto& [name, value] : setting.knobs) {
    text += (text.empty() ? "" : ", ") + name + " " + value;
  }
  return text;
}

std::vector<Setting> pareto_front(std::vector<Setting> measured) {
  for (const Setting& s : measured) {
    if (!std::isfinite(s.seconds) || !std::isfinite(s.error) || s.seconds < 0 || s.error < 0) {
      throw std::invalid_argument("pareto_front: a time or error is not finite and >= 0");
    }
  }
  std::stable_sort(measured.begin(), measured.end(), [](const Setting& a, const Setting& b) {
    return a.seconds != b.seconds ? a.seconds < b.seconds : a.error < b.error;
  });
  std::vector<Setting> front;
  for (Setting& setting : measured) {
    if (front.empty() || setting.error < front.back().error) front.push_back(std::move(setting));
  }
  return front;
}

const Setting& within_budget(const Front& front, double seconds) {
  check_not_empty(front);
  if (!(seconds > 0)) throw std::invalid_argument("within_budget: the budget must be positive");
  const Setting* best = nullptr;
  for (const Setting& s : front.settings) {
    if (s.seconds <= seconds && (best == nullptr || s.error < best->error)) best = &s;
  }
  if (best != nullptr) return *best;
  const auto fastest =
      std::min_element(front.settings.begin(), front.settings.end(),
                       [](const Setting& a, const Setting& b) { return a.seconds < b.seconds; });
  const std::string what = front.error_name.empty() ? "" : " (" + front.error_name + ")";
  throw UnreachableError(
      fmt::format("No setting of '{}' takes at most {:.4g} ms", front.subject, 1e3 * seconds),
      "Allow as much as the fastest one: " + described(*fastest, front.error_unit) + what,
      *fastest);
}

const Setting& within_tolerance(const Front& front, double error) {
  check_not_empty(front);
  if (!(error > 0)) throw std::invalid_argument("within_tolerance: it must be positive");
  const Setting* best = nullptr;
  for (const Setting& s : front.settings) {
    if (s.error <= error && (best == nullptr || s.seconds < best->seconds)) best = &s;
  }
  if (best != nullptr) return *best;
  const auto closest =
      std::min_element(front.settings.begin(), front.settings.end(),
                       [](const Setting& a, const Setting& b) { return a.error < b.error; });
  throw UnreachableError(
      fmt::format("No setting of '{}' has an error of at most {}", front.subject,
                  error_text(error, front.error_unit)),
      "Allow as much as the most accurate one: " + described(*closest, front.error_unit), *closest);
}

const Setting& choose(const Front& front, double budget, double tolerance) {
  if (budget > 0 && tolerance > 0) {
    throw InputError("Of the front '" + front.subject + "' budget and tolerance are both given",
                     "Give one of them; the front answers with the other");
  }
  return budget > 0 ? within_budget(front, budget) : within_tolerance(front, tolerance);
}

Front read_front(const std::filesystem::path& file) {
  YAML::Node root;
  try {
    root = text::load_strict_yaml(file.string());
    check_keys(root, {"subject", "error_name", "error_unit", "other_errors", "machine", "settings"},
               file);
    Front front;
    for (const auto& [key, value] :
         {std::pair{"subject", &front.subject}, std::pair{"error_name", &front.error_name},
          std::pair{"error_unit", &front.error_unit}, std::pair{"machine", &front.machine}}) {
      if (!root[key]) fail(file, std::string("has no key '") + key + "'");
      *value = root[key].as<std::string>();
    }
    if (const YAML::Node others = root["other_errors"]) {
      if (!others.IsMap()) fail(file, "has 'other_errors' that are no map of names and meanings");
      for (const auto& other : others) {
        front.other_errors.emplace_back(other.first.as<std::string>(),
                                        other.second.as<std::string>());
      }
    }
    if (!root["settings"] || !root["settings"].IsSequence() || root["settings"].size() == 0) {
      fail(file, "has no list 'settings'");
    }
    for (const YAML::Node& node : root["settings"]) {
      check_keys(node, {"milliseconds", "error", "other_errors", "knobs"}, file);
      Setting setting;
      setting.seconds = number_of(node, "milliseconds", file) / 1000;
      setting.error = number_of(node, "error", file);
      const YAML::Node others = node["other_errors"];
      if ((others ? others.size() : 0) != front.other_errors.size()) {
        fail(file, "has a setting whose 'other_errors' are not those that the front names");
      }
      for (const auto& [name, meaning] : front.other_errors) {
        setting.other_errors.emplace_back(name, number_of(others, name.c_str(), file));
      }
      if (!node["knobs"] || !node["knobs"].IsMap()) fail(file, "has a setting without 'knobs'");
      for (const auto& knob : node["knobs"]) {
        setting.knobs.emplace_back(knob.first.as<std::string>(), knob.second.as<std::string>());
      }
      front.settings.push_back(std::move(setting));
    }
    for (std::size_t i = 1; i < front.settings.size(); ++i) {
      if (front.settings[i].seconds < front.settings[i - 1].seconds ||
          !is_better(front.settings[i], front.settings[i - 1])) {
        fail(file, "has settings that are no front: slower ones must be more accurate");
      }
    }
    return front;
  } catch (const text::YamlError& error) {
    fail(file, std::string("cannot be read: ") + error.what());
  } catch (const YAML::Exception& error) {
    fail(file, std::string("cannot be read: ") + error.what());
  }
}

void write_front(const std::filesystem::path& file, const Front& front) {
  YAML::Emitter out;
  out << YAML::Comment("Measured by build/bin/eval_tradeoff; fastest first.") << YAML::BeginMap;
  out << YAML::Key << "subject" << YAML::Value << front.subject;
  out << YAML::Key << "error_name" << YAML::Value << front.error_name;
  out << YAML::Key << "error_unit" << YAML::Value << front.error_unit;
  if (!front.other_errors.empty()) {
    out << YAML::Key << "other_errors" << YAML::Value << YAML::BeginMap;
    for (const auto& [name, meaning] : front.other_errors) {
      out << YAML::Key << name << YAML::Value << meaning;
    }
    out << YAML::EndMap;
  }
  out << YAML::Key << "machine" << YAML::Value << front.machine;
  out << YAML::Key << "settings" << YAML::Value << YAML::BeginSeq;
  for (const Setting& setting : front.settings) {
    out << YAML::BeginMap;
    out << YAML::Key << "milliseconds" << YAML::Value
        << fmt::format("{:.6g}", 1e3 * setting.seconds);
    out << YAML::Key << "error" << YAML::Value << fmt::format("{:.6g}", setting.error);
    if (!setting.other_errors.empty()) {
      out << YAML::Key << "other_errors" << YAML::Value << YAML::Flow << YAML::BeginMap;
      for (const auto& [name, error] : setting.other_errors) {
        out << YAML::Key << name << YAML::Value << fmt::format("{:.4g}", error);
      }
      out << YAML::EndMap;
    }
    out << YAML::Key << "knobs" << YAML::Value << YAML::Flow << YAML::BeginMap;
    for (const auto& [name, value] : setting.knobs)
      out << YAML::Key << name << YAML::Value << value;
    out << YAML::EndMap << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  geometry::write_whole_file(file, out.c_str(), "The front");
}

}  // namespace prehend::fidelity
