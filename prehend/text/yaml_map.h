#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>
#include <Eigen/Core>

namespace prehend::text {

/// Loads a YAML file whose top is a map. @throws InputError "file:line: ..." when it is
/// missing, a folder, empty, no strict YAML (strict_yaml.h), or no map.
YAML::Node load_yaml_map(const std::filesystem::path& path);
/// The same of a text; `path` says in errors where it is from.
YAML::Node parse_yaml_map(const std::string& text, const std::filesystem::path& path);

/// While it lives it notes which keys this thread's YamlMaps know, by their places: what a file may
/// say, as it is read, for those who must go through all of it. One at a time.
class KnownKeys {
 public:
  KnownKeys();
  ~KnownKeys();
  KnownKeys(const KnownKeys&) = delete;
  KnownKeys& operator=(const KnownKeys&) = delete;
  /// Place ("physics.rules") and key ("sleep").
  const std::set<std::pair<std::string, std::string>>& keys() const { return keys_; }

 private:
  friend class YamlMap;
  std::set<std::pair<std::string, std::string>> keys_;
};

/// Reads a YAML map of which every key must be known: ask for each key with read(), then call
/// finish(). Keys that are absent leave the value as it was. All errors are InputError
/// "file:line: what is wrong" with the mend.
class YamlMap {
 public:
  /// `place` says what the map describes, e.g. "pad". @throws InputError when `node` is no map.
  YamlMap(const YAML::Node& node, std::filesystem::path file, std::string place);

  void read(const std::string& key, double& value);
  void read(const std::string& key, bool& value);
  void read(const std::string& key, int& value);
  void read(const std::string& key, std::uint32_t& value);
  void read(const std::string& key, std::string& value);
  void read(const std::string& key, Eigen::Vector2d& value);
  void read(const std::string& key, Eigen::Vector3d& value);
  /// One of a few words, each with what it means.
  template <class Value>
  void choose(const std::string& key, const std::vector<std::pair<std::string, Value>>& words,
              Value& value) {
    std::string word, all;
    read(key, word);
    if (word.empty()) return;
    for (const auto& [name, meaning] : words) {
      if (name == word) {
        value = meaning;
        return;
      }
      all += (all.empty() ? "" : ", ") + name;
    }
    fail(key, "is '" + word + "'", "Write one of " + all);
  }
  /// The value of `key` for a nested structure; an undefined node when absent.
  YAML::Node child(const std::string& key);

  /// @throws InputError for the first key that was never asked for, with the nearest known key.
  void finish() const;

  /// An InputError at the line of `key`.
  [[noreturn]] void fail(const std::string& key, const std::string& wrong,
                         const std::string& mend) const;

 private:
  std::string at(const YAML::Node& node) const;

  YAML::Node node_;
  std::filesystem::path file_;
  std::string place_;
  std::set<std::string> known_;
};

}  // namespace prehend::text
