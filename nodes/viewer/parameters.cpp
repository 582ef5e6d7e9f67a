#include "nodes/viewer/parameters.h"

#include <set>
#include <stdexcept>
#include <utility>

#include "prehend/text/json.h"

namespace prehend::nodes {
namespace {

using msgs::graph::ParameterRecord;
using msgs::graph::ParameterValue;
using text::Json;

viewing::Value viewed(const ParameterValue& value) {
  switch (value.value_case()) {
    case ParameterValue::kBoolValue:
      return value.bool_value();
    case ParameterValue::kIntValue:
      return static_cast<std::int64_t>(value.int_value());
    case ParameterValue::kDoubleValue:
      return value.double_value();
    case ParameterValue::kStringValue:
      return value.string_value();
    case ParameterValue::kNumbersValue:
      return std::vector<double>(value.numbers_value().values().begin(),
                                 value.numbers_value().values().end());
    case ParameterValue::kTextsValue:
      return std::vector<std::string>(value.texts_value().values().begin(),
                                      value.texts_value().values().end());
    case ParameterValue::VALUE_NOT_SET:
      break;
  }
  return {};
}

const char* type_name(const ParameterValue& value) {
  switch (value.value_case()) {
    case ParameterValue::kBoolValue:
      return "bool";
    case ParameterValue::kIntValue:
      return "int";
    case ParameterValue::kDoubleValue:
      return "double";
    case ParameterValue::kStringValue:
      return "string";
    case ParameterValue::kNumbersValue:
      return "numbers";
    case ParameterValue::kTextsValue:
      return "texts";
    case ParameterValue::VALUE_NOT_SET:
      break;
  }
  return "";
}

Json json_of(const ParameterValue& value) {
  struct Teller {
    Json operator()(std::monostate) const { return Json::null(); }
    Json operator()(const std::vector<double>& numbers) const {
      Json array = Json::array();
      for (const double number : numbers) array.add(number);
      return array;
    }
    Json operator()(const std::vector<std::string>& texts) const { return Json(texts); }
    Json operator()(bool v) const { return v; }
    Json operator()(std::int64_t v) const { return v; }
    Json operator()(double v) const { return v; }
    Json operator()(const std::string& v) const { return v; }
  };
  return std::visit(Teller{}, viewed(value));
}

Json described_parameter(const std::string& node, const ParameterRecord& record) {
  return Json::object()
      .set("name", viewed_name(node, record.name()))
      .set("type", type_name(record.value()))
      .set("value", json_of(record.value()))
      .set("default", json_of(record.default_value()))
      .set("min", json_of(record.minimum()))
      .set("max", json_of(record.maximum()))
      .set("choices",
           Json(std::vector<std::string>(record.choices().begin(), record.choices().end())))
      .set("unit", record.unit())
      .set("description", record.description())
      .set("read_only", record.read_only());
}

std::pair<std::string, std::string> parts_of(const std::string& name) {
  const std::size_t point = name.find('.');
  if (point == std::string::npos || point == 0 || point + 1 == name.size()) {
    throw std::invalid_argument("'" + name + "' is no parameter: they are called NODE.PARAMETER");
  }
  return {name.substr(0, point), name.substr(point + 1)};
}

void add_line(std::string& text, const std::string& line) {
  if (!text.empty()) text += '\n';
  text += line;
}

}  // namespace

std::string viewed_name(const std::string& node, const std::string& parameter) {
  return node + "." + parameter;
}

viewing::Parameter viewed_parameter(const std::string& node, const ParameterRecord& record) {
  return {viewed_name(node, record.name()), viewed(record.value())};
}

std::string parameter_text(const viewing::Parameter& parameter) {
  struct Teller {
    const viewing::Parameter& parameter;
    ParameterValue operator()(std::monostate) const {
      throw std::invalid_argument("parameter " + parameter.name +
                                  ": a parameter cannot be removed, only set");
    }
    ParameterValue operator()(bool v) const {
      ParameterValue value;
      value.set_bool_value(v);
      return value;
    }
    ParameterValue operator()(std::int64_t v) const {
      ParameterValue value;
      value.set_int_value(v);
      return value;
    }
    ParameterValue operator()(double v) const {
      ParameterValue value;
      value.set_double_value(v);
      return value;
    }
    ParameterValue operator()(const std::string& v) const {
      ParameterValue value;
      value.set_string_value(v);
      return value;
    }
    ParameterValue operator()(const std::vector<double>& v) const {
      ParameterValue value;
      for (const double one : v) value.mutable_numbers_value()->add_values(one);
      return value;
    }
    ParameterValue operator()(const std::vector<std::string>& v) const {
      ParameterValue value;
      value.mutable_texts_value();  // also when it is empty
      for (const std::string& one : v) value.mutable_texts_value()->add_values(one);
      return value;
    }
  };
  return graph::to_text(std::visit(Teller{parameter}, parameter.value));
}

Parameters::Parameters(const std::string& registry, const std::string& keys_file)
    : graph_(registry, std::chrono::seconds(2), keys_file) {}

viewing::ParameterAnswer Parameters::get(const std::vector<std::string>& names) {
  viewing::ParameterAnswer answer;
  const std::set<std::string> wanted(names.begin(), names.end());
  std::set<std::string> nodes, found;
  for (const std::string& name : names) {
    try {
      nodes.insert(parts_of(name).first);
    } catch (const std::invalid_argument& error) {
      add_line(answer.error, error.what());
    }
  }
  if (names.empty()) {
    for (const auto& node : graph_.nodes()) nodes.insert(node.name());
  }
  for (const std::string& node : nodes) {
    try {
      for (const ParameterRecord& record : graph_.parameters(node)) {
        const std::string name = viewed_name(node, record.name());
        if (!wanted.empty() && wanted.count(name) == 0) continue;
        answer.parameters.push_back(viewed_parameter(node, record));
      }
    } catch (const std::runtime_error& error) {
      // A node that has just gone is no news to who asked for all.
      if (!names.empty()) add_line(answer.error, error.what());
    }
  }
  return answer;
}

viewing::ParameterAnswer Parameters::set(const std::vector<viewing::Parameter>& parameters) {
  viewing::ParameterAnswer answer;
  for (const viewing::Parameter& one : parameters) {
    std::string node, name;
    try {
      std::tie(node, name) = parts_of(one.name);
      answer.parameters.push_back(
          viewed_parameter(node, graph_.set_parameter(node, name, parameter_text(one))));
      continue;
    } catch (const std::exception& error) {
      add_line(answer.error, error.what());
    }
    try {
      if (!node.empty()) {
        answer.parameters.push_back(viewed_parameter(node, graph_.parameter(node, name)));
      }
    } catch (const std::runtime_error&) {
      // There is no such parameter, which was just said.
    }
  }
  return answer;
}

std::string Parameters::described() {
  Json array = Json::array();
  for (const auto& node : graph_.nodes()) {
    try {
      for (const ParameterRecord& record : graph_.parameters(node.name())) {
        array.add(described_parameter(node.name(), record));
      }
    } catch (const std::runtime_error&) {
      // It has just gone, or hangs: the others are told.
    }
  }
  return array.text();
}

}  // namespace prehend::nodes
