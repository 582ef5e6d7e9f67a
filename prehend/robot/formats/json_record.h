#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/robot/formats/loss_report.h"

// Records as JSON: a record's fields are named once, by a function
//   template <class Visitor> void fields(Visitor& v, Part<Visitor, Record>& record)
// which reads them with a JsonReader and writes them with a JsonWriter.
namespace prehend::robot::formats {

using JsonValue = nlohmann::ordered_json;

template <class Visitor, class Record>
using Part = std::conditional_t<Visitor::kReads, Record, const Record>;

/// Words for an enum's values, in their order.
template <std::size_t count>
using Choices = std::array<const char*, count>;

/// Text as a value. @throws geometry::InputError naming `file`, and where: what is no JSON, nested
/// deeper than 32, or says a key twice.
JsonValue parse_json(const std::string& text, const std::string& file);
/// Objects over several lines, and what has none in it on one. Text that is no UTF-8 is replaced,
/// and `loss` says so.
std::string json_text(const JsonValue& value, LossReport& loss);

/// Reads the fields of an object.
class JsonReader {
 public:
  static constexpr bool kReads = true;
  /// @param path of the object in the file, "joints[3]"; empty: the whole. All outlive it.
  /// @throws geometry::InputError when it is no object
  JsonReader(const JsonValue& object, std::string path, const std::string& file, LossReport& loss);

  /// A field that must be there. As all below it @throws geometry::InputError "FILE: path: what"
  template <class Value>
  void field(const char* key, Value& value) {
    const JsonValue* found = find(key);
    if (!found) fail(path_, std::string("has no '") + key + "'", "Give it");
    take(*found, below(key), value);
  }
  /// One that has `otherwise` where it is absent.
  template <class Value>
  void field(const char* key, Value& value, const Value& otherwise) {
    const JsonValue* found = find(key);
    found ? take(*found, below(key), value) : void(value = otherwise);
  }
  template <class Value>
  void field(const char* key, std::optional<Value>& value) {
    if (const JsonValue* found = find(key)) take(*found, below(key), value.emplace());
  }
  /// One of some words.
  template <class Enum, std::size_t count>
  void choice(const char* key, Enum& value, const Choices<count>& words) {
    std::string word;
    field(key, word);
    for (std::size_t i = 0; i < count; ++i) {
      if (word == words[i]) return void(value = static_cast<Enum>(i));
    }
    refuse_word(below(key), word, {words.begin(), words.end()});
  }
  /// Values, as many as there are; none where it is absent.
  template <class Value>
  void list(const char* key, std::vector<Value>& values) {
    const JsonValue* found = find(key);
    if (!found) return;
    if (!found->is_array()) fail(below(key), "is no list", "Write [ ... ]");
    values.reserve(found->size());
    for (std::size_t i = 0; i < found->size(); ++i) {
      take((*found)[i], below(key) + "[" + std::to_string(i) + "]", values.emplace_back());
    }
  }
  /// Refuses keys that no field has asked for.
  void finish() const;

  const std::string& path() const { return path_; }
  LossReport& loss() { return loss_; }
  [[noreturn]] void fail(const std::string& path, const std::string& wrong,
                         const std::string& mend) const;

 private:
  const JsonValue* find(const char* key);
  std::string below(const char* key) const { return path_.empty() ? key : path_ + "." + key; }
  [[noreturn]] void refuse_word(const std::string& path, const std::string& word,
                                const std::vector<std::string>& words) const;
  void take_numbers(const JsonValue& from, const std::string& path, double* to, std::size_t count);
  void take(const JsonValue& from, const std::string& path, double& to);
  void take(const JsonValue& from, const std::string& path, int& to);
  void take(const JsonValue& from, const std::string& path, bool& to);
  void take(const JsonValue& from, const std::string& path, std::string& to);
  static void take(const JsonValue& from, const std::string&, JsonValue& to) { to = from; }
  void take(const JsonValue& from, const std::string& path, Eigen::Vector3d& to);
  void take(const JsonValue& from, const std::string& path, Eigen::Matrix3d& to);
  void take(const JsonValue& from, const std::string& path, std::array<double, 4>& to);
  void take(const JsonValue& from, const std::string& path, geometry::RigidTransform& to);
  void take(const JsonValue& from, const std::string& path,
            std::pair<std::string, std::string>& to);
  void take(const JsonValue& from, const std::string& path, std::pair<std::string, double>& to);
  void take(const JsonValue& from, const std::string& path, std::map<std::string, double>& to);
  template <class Record>
  void take(const JsonValue& from, const std::string& path, Record& to) {
    JsonReader reader(from, path, file_, loss_);
    fields(reader, to);
    reader.finish();
  }

  const JsonValue& object_;
  std::string path_;
  const std::string& file_;
  LossReport& loss_;
  std::vector<std::string> known_;
};

/// Writes the fields of an object, in the order in which they are named.
class JsonWriter {
 public:
  static constexpr bool kReads = false;
  explicit JsonWriter(std::string path, LossReport& loss) : path_(std::move(path)), loss_(loss) {}

  /// As all below it @throws geometry::InputError for a number that is not finite
  template <class Value>
  void field(const char* key, const Value& value) {
    object_[key] = json_of(value, key);
  }
  template <class Value>
  void field(const char* key, const Value& value, const Value& otherwise) {
    if (!is_same(value, otherwise)) field(key, value);
  }
  template <class Value>
  void field(const char* key, const std::optional<Value>& value) {
    if (value) field(key, *value);
  }
  template <class Enum, std::size_t count>
  void choice(const char* key, const Enum& value, const Choices<count>& words) {
    object_[key] = words.at(static_cast<std::size_t>(value));
  }
  template <class Value>
  void list(const char* key, const std::vector<Value>& values) {
    if (values.empty()) return;
    loss_.keep(key, values.size());
    JsonValue all = JsonValue::array();
    for (const Value& value : values) all.push_back(json_of(value, key));
    object_[key] = std::move(all);
  }

  const std::string& path() const { return path_; }
  LossReport& loss() { return loss_; }
  JsonValue& object() { return object_; }

 private:
  template <class Value>
  static bool is_same(const Value& one, const Value& other) {
    return one == other;
  }
  static bool is_same(const geometry::RigidTransform& one, const geometry::RigidTransform& other) {
    return one.matrix() == other.matrix();
  }
  JsonValue json_of(double value, const char* key) const;
  static JsonValue json_of(int value, const char*) { return value; }
  static JsonValue json_of(bool value, const char*) { return value; }
  static JsonValue json_of(const std::string& value, const char*) { return value; }
  JsonValue json_of(const Eigen::Vector3d& value, const char* key) const;
  JsonValue json_of(const Eigen::Matrix3d& value, const char* key) const;
  JsonValue json_of(const std::array<double, 4>& value, const char* key) const;
  JsonValue json_of(const geometry::RigidTransform& value, const char* key) const;
  static JsonValue json_of(const std::pair<std::string, std::string>& value, const char*) {
    return {value.first, value.second};
  }
  JsonValue json_of(const std::pair<std::string, double>& value, const char* key) const {
    return {value.first, json_of(value.second, key)};
  }
  JsonValue json_of(const std::map<std::string, double>& value, const char* key) const;
  template <class Record>
  JsonValue json_of(const Record& record, const char* key) const {
    JsonWriter writer(path_.empty() ? key : path_ + "." + key, loss_);
    fields(writer, record);
    return std::move(writer.object_);
  }

  std::string path_;
  LossReport& loss_;
  JsonValue object_ = JsonValue::object();
};

}  // namespace prehend::robot::formats
