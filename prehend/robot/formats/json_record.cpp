#include "prehend/robot/formats/json_record.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/text/json_size.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;

/// Whether what is in it is in a line's length readable: no object, or one of numbers and words.
bool is_flat(const JsonValue& value, int depth = 0) {
  constexpr int kDeepest = 2;
  if (!value.is_structured()) return true;
  return depth < kDeepest && std::all_of(value.begin(), value.end(), [&](const JsonValue& one) {
           return !one.is_object() && is_flat(one, depth + 1);
         });
}

void write_value(const JsonValue& value, int depth, std::string& text) {
  const auto line = [&](int at) { text.append("\n").append(static_cast<std::size_t>(at), ' '); };
  if (is_flat(value)) {
    const std::string words = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    // Spaces behind commas and colons that are not within texts.
    bool is_text = false;
    for (std::size_t i = 0; i < words.size(); ++i) {
      text += words[i];
      if (words[i] == '\\' && is_text)
        text += words[++i];
      else if (words[i] == '"')
        is_text = !is_text;
      else if (!is_text && (words[i] == ',' || words[i] == ':'))
        text += ' ';
    }
    return;
  }
  text += value.is_object() ? '{' : '[';
  bool is_first = true;
  for (const auto& item : value.items()) {
    if (!is_first) text += ',';
    is_first = false;
    line(depth + 1);
    if (value.is_object()) {
      text += JsonValue(item.key()).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) +
              ": ";
    }
    write_value(item.value(), depth + 1, text);
  }
  line(depth);
  text += value.is_object() ? '}' : ']';
}

}  // namespace

JsonValue parse_json(const std::string& text, const std::string& file) {
  text::refuse_json_bomb(text, file);
  try {
    return JsonValue::parse(text);
  } catch (const JsonValue::exception& error) {
    const std::string words = error.what();  // "[json.exception...] parse error at line 3, ..."
    const std::size_t begin = words.find("] ");
    throw InputError(
        file + " is no JSON: " + (begin == std::string::npos ? words : words.substr(begin + 2)),
        "Mend it there");
  }
}

std::string json_text(const JsonValue& value, LossReport& loss) {
  try {
    value.dump();
  } catch (const JsonValue::exception&) {
    loss.approximate("robot", "names that are no UTF-8", "their bytes became U+FFFD");
  }
  std::string text;
  write_value(value, 0, text);
  return text + '\n';
}

JsonReader::JsonReader(const JsonValue& object, std::string path, const std::string& file,
                       LossReport& loss)
    : object_(object), path_(std::move(path)), file_(file), loss_(loss) {
  if (!object_.is_object()) fail(path_, "is no object", "Write { ... }");
}

void JsonReader::fail(const std::string& path, const std::string& wrong,
                      const std::string& mend) const {
  throw InputError(file_ + (path.empty() ? " " : ": " + path + ": ") + wrong, mend);
}

void JsonReader::refuse_word(const std::string& path, const std::string& word,
                             const std::vector<std::string>& words) const {
  fail(path, "'" + word.substr(0, 80) + "' is none of its words",
       text::nearest_match_mend(word.substr(0, 80), words));
}

const JsonValue* JsonReader::find(const char* key) {
  known_.emplace_back(key);
  const auto found = object_.find(key);
  if (found == object_.end()) return nullptr;
  loss_.keep(key);
  return &*found;
}

void JsonReader::finish() const {
  for (const auto& item : object_.items()) {
    if (std::find(known_.begin(), known_.end(), item.key()) == known_.end()) {
      const std::string key = item.key().substr(0, 80);
      fail(below(key.c_str()), "there is no such key", text::nearest_match_mend(key, known_));
    }
  }
}

void JsonReader::take(const JsonValue& from, const std::string& path, double& to) {
  if (!from.is_number()) fail(path, "is no number", "Write one");
  to = from.get<double>();
  if (!std::isfinite(to)) fail(path, "is not finite", "Write a number that is");
}

void JsonReader::take(const JsonValue& from, const std::string& path, int& to) {
  double number = 0;
  take(from, path, number);
  constexpr double kMost = 1e9;
  if (number != std::floor(number) || std::abs(number) > kMost) {
    fail(path, "is no whole number", "Write one");
  }
  to = static_cast<int>(number);
}

void JsonReader::take(const JsonValue& from, const std::string& path, bool& to) {
  if (!from.is_boolean()) fail(path, "is neither true nor false", "Write one of them");
  to = from.get<bool>();
}

void JsonReader::take(const JsonValue& from, const std::string& path, std::string& to) {
  if (!from.is_string()) fail(path, "is no text", "Write it in quotes");
  to = from.get<std::string>();
}

void JsonReader::take_numbers(const JsonValue& from, const std::string& path, double* to,
                              std::size_t count) {
  if (!from.is_array() || from.size() != count) {
    fail(path, "is no list of " + std::to_string(count) + " numbers", "Write so many");
  }
  for (std::size_t i = 0; i < count; ++i) {
    take(from[i], path + "[" + std::to_string(i) + "]", to[i]);
  }
}

void JsonReader::take(const JsonValue& from, const std::string& path, Eigen::Vector3d& to) {
  take_numbers(from, path, to.data(), 3);
}

void JsonReader::take(const JsonValue& from, const std::string& path, Eigen::Matrix3d& to) {
  if (!from.is_array() || from.size() != 3) fail(path, "is no list of 3 rows", "Write them");
  for (std::size_t i = 0; i < 3; ++i) {
    Eigen::Vector3d row;
    take(from[i], path + "[" + std::to_string(i) + "]", row);
    to.row(static_cast<Eigen::Index>(i)) = row;
  }
}

void JsonReader::take(const JsonValue& from, const std::string& path, std::array<double, 4>& to) {
  take_numbers(from, path, to.data(), to.size());
}

void JsonReader::take(const JsonValue& from, const std::string& path,
                      geometry::RigidTransform& to) {
  JsonReader reader(from, path, file_, loss_);
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::array<double, 4> wxyz{1, 0, 0, 0};
  reader.field("position", position, position);
  reader.field("quaternion", wxyz, wxyz);
  reader.finish();
  Eigen::Quaterniond rotation(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  constexpr double kUnit = 1e-3, kRounded = 1e-9;
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1) < kUnit)) {
    fail(path + ".quaternion", "has not the length 1", "Write [w, x, y, z] of a rotation");
  }
  if (std::abs(norm - 1) > kRounded) {
    loss_.approximate(file_, path + ".quaternion", "it was made a unit quaternion");
  }
  rotation.normalize();
  to = geometry::RigidTransform::Identity();
  to.translation() = position;
  to.linear() = rotation.toRotationMatrix();
}

void JsonReader::take(const JsonValue& from, const std::string& path,
                      std::pair<std::string, std::string>& to) {
  if (!from.is_array() || from.size() != 2) fail(path, "is no pair of names", "Write two");
  take(from[0], path + "[0]", to.first);
  take(from[1], path + "[1]", to.second);
}

void JsonReader::take(const JsonValue& from, const std::string& path,
                      std::pair<std::string, double>& to) {
  if (!from.is_array() || from.size() != 2) fail(path, "is no name and number", "Write [name, 1]");
  take(from[0], path + "[0]", to.first);
  take(from[1], path + "[1]", to.second);
}

void JsonReader::take(const JsonValue& from, const std::string& path,
                      std::map<std::string, double>& to) {
  if (!from.is_object()) fail(path, "is no object", "Write {name: number, ...}");
  for (const auto& item : from.items()) {
    take(item.value(), path + "." + item.key(), to[item.key()]);
  }
}

JsonValue JsonWriter::json_of(double value, const char* key) const {
  if (!std::isfinite(value)) {
    throw InputError(
        (path_.empty() ? "" : path_ + ".") + key + " is not finite: JSON has no such number",
        "Mend the robot");
  }
  return value;
}

JsonValue JsonWriter::json_of(const Eigen::Vector3d& value, const char* key) const {
  return {json_of(value.x(), key), json_of(value.y(), key), json_of(value.z(), key)};
}

JsonValue JsonWriter::json_of(const Eigen::Matrix3d& value, const char* key) const {
  JsonValue rows = JsonValue::array();
  for (Eigen::Index i = 0; i < 3; ++i) {
    rows.push_back(json_of(Eigen::Vector3d(value.row(i)), key));
  }
  return rows;
}

JsonValue JsonWriter::json_of(const std::array<double, 4>& value, const char* key) const {
  JsonValue all = JsonValue::array();
  for (const double one : value) all.push_back(json_of(one, key));
  return all;
}

JsonValue JsonWriter::json_of(const std::map<std::string, double>& value, const char* key) const {
  JsonValue object = JsonValue::object();
  for (const auto& [name, number] : value) object[name] = json_of(number, key);
  return object;
}

JsonValue JsonWriter::json_of(const geometry::RigidTransform& value, const char* key) const {
  const Eigen::Quaterniond rotation(value.linear());
  JsonValue pose = JsonValue::object();
  pose["position"] = json_of(Eigen::Vector3d(value.translation()), key);
  pose["quaternion"] =
      json_of(std::array<double, 4>{rotation.w(), rotation.x(), rotation.y(), rotation.z()}, key);
  return pose;
}

}  // namespace prehend::robot::formats
