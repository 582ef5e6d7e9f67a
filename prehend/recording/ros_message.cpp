#include "prehend/recording/ros_message.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>

namespace prehend::recording {
namespace {

constexpr std::size_t kDeepest = 32;                       // messages within messages
constexpr std::size_t kMostValues = std::size_t{1} << 22;  // of lists that are no bare numbers

struct Primitive {
  char kind;  // as of RosValue::Numbers; 's' text, 't' time and 'd' duration of ROS 1
  std::size_t size;
};

std::optional<Primitive> primitive(std::string_view type) {
  static const std::map<std::string_view, Primitive> kAll = {
      {"bool", {'u', 1}},    {"int8", {'i', 1}},   {"uint8", {'u', 1}},  {"byte", {'u', 1}},
      {"char", {'u', 1}},    {"int16", {'i', 2}},  {"uint16", {'u', 2}}, {"int32", {'i', 4}},
      {"uint32", {'u', 4}},  {"int64", {'i', 8}},  {"uint64", {'u', 8}}, {"float32", {'f', 4}},
      {"float64", {'f', 8}}, {"string", {'s', 1}}, {"time", {'t', 4}},   {"duration", {'d', 4}}};
  const auto found = kAll.find(type);
  return found == kAll.end() ? std::nullopt : std::optional(found->second);
}

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::uint64_t unsigned_at(std::string_view bytes, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= std::uint64_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  }
  return value;
}

std::int64_t signed_at(std::string_view bytes, std::size_t size) {
  const std::uint64_t value = unsigned_at(bytes, size);
  const auto shift = static_cast<int>(64 - 8 * size);
  return static_cast<std::int64_t>(value << shift) >> shift;
}

double floating_at(std::string_view bytes, std::size_t size) {
  if (size == 4) {
    float value = 0;
    std::memcpy(&value, bytes.data(), 4);
    return static_cast<double>(value);
  }
  double value = 0;
  std::memcpy(&value, bytes.data(), 8);
  return value;
}

RosValue scalar(const Primitive& type, std::string_view bytes) {
  if (type.kind == 'i') return RosValue(signed_at(bytes, type.size));
  if (type.kind == 'f') return RosValue(floating_at(bytes, type.size));
  return RosValue(unsigned_at(bytes, type.size));
}

}  // namespace

std::string ros_type_name(std::string_view name) {
  std::string result(name);
  const std::size_t middle = result.find("/msg/");
  if (middle != std::string::npos) result.erase(middle, 4);
  return result;
}

const RosValue& RosValue::operator[](std::string_view field) const {
  if (const auto* fields = std::get_if<Fields>(&content_)) {
    for (const auto& [name, value] : *fields) {
      if (name == field) return value;
    }
  }
  throw RosError("the message has no field '" + std::string(field) + "'");
}

bool RosValue::has(std::string_view field) const {
  const auto* fields = std::get_if<Fields>(&content_);
  return fields && std::any_of(fields->begin(), fields->end(),
                               [&](const auto& one) { return one.first == field; });
}

std::int64_t RosValue::integer() const {
  if (const auto* value = std::get_if<std::int64_t>(&content_)) return *value;
  const auto* value = std::get_if<std::uint64_t>(&content_);
  if (!value || *value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
    throw RosError("a field is no whole number, or too large");
  }
  return static_cast<std::int64_t>(*value);
}

double RosValue::number() const {
  if (const auto* value = std::get_if<double>(&content_)) return *value;
  return static_cast<double>(integer());
}

std::string_view RosValue::text() const {
  if (const auto* value = std::get_if<std::string_view>(&content_)) return *value;
  throw RosError("a field is no text");
}

std::vector<double> RosValue::numbers() const {
  const auto* raw = std::get_if<Numbers>(&content_);
  if (!raw) throw RosError("a field is no list of numbers");
  std::vector<double> result;
  result.reserve(raw->bytes.size() / raw->size);
  for (std::size_t i = 0; i < raw->bytes.size(); i += raw->size) {
    result.push_back(scalar({raw->kind, raw->size}, raw->bytes.substr(i, raw->size)).number());
  }
  return result;
}

std::string_view RosValue::bytes() const {
  const auto* raw = std::get_if<Numbers>(&content_);
  if (!raw || raw->size != 1) throw RosError("a field is no list of bytes");
  return raw->bytes;
}

const RosValue::List& RosValue::list() const {
  if (const auto* list = std::get_if<List>(&content_)) return *list;
  throw RosError("a field is no list");
}

/// Walks through a message's bytes.
class RosType::Reader {
 public:
  Reader(const RosType& type, std::string_view bytes, RosEncoding encoding)
      : type_(type), all_(bytes), encoding_(encoding) {
    if (encoding != RosEncoding::kCdr) return;
    // 0: big endian; higher ones: parameter lists and later versions.
    constexpr unsigned char kPlainLittleEndian = 1;
    const std::string_view header = raw(4);
    if (header[0] != 0 || static_cast<unsigned char>(header[1]) != kPlainLittleEndian) {
      throw RosError("the message is no plain little-endian CDR");
    }
    begin_ = position_;
  }

  RosValue message(const std::string& name) {
    const std::vector<Field>& fields = type_.messages_.at(name);
    RosValue::Fields values;
    for (const Field& field : fields) values.emplace_back(field.name, value(field));
    if (fields.empty() && encoding_ == RosEncoding::kCdr) raw(1);  // IDL has no empty structures
    return RosValue(std::move(values));
  }

 private:
  // What sequences of CDR end with is padding: it is not looked at.
  std::string_view raw(std::size_t count) {
    if (count > all_.size() - position_) throw RosError("the message ends too early");
    position_ += count;
    return all_.substr(position_ - count, count);
  }
  void align(std::size_t size) {
    if (encoding_ != RosEncoding::kCdr) return;
    const std::size_t over = (position_ - begin_) % size;
    if (over != 0) raw(size - over);
  }
  std::uint32_t count() {
    align(4);
    return static_cast<std::uint32_t>(unsigned_at(raw(4), 4));
  }
  std::string_view text() {
    std::string_view bytes = raw(count());
    if (encoding_ == RosEncoding::kCdr && !bytes.empty()) bytes.remove_suffix(1);  // its NUL
    return bytes;
  }
  RosValue single(const std::string& name) {
    const auto simple = primitive(name);
    if (!simple) return message(name);
    if (simple->kind == 's') return RosValue(text());
    if (simple->kind == 't' || simple->kind == 'd') {
      RosValue::Fields fields;
      fields.emplace_back("sec", scalar({simple->kind == 'd' ? 'i' : 'u', 4}, raw(4)));
      fields.emplace_back("nanosec", scalar({'u', 4}, raw(4)));
      return RosValue(std::move(fields));
    }
    align(simple->size);
    return scalar(*simple, raw(simple->size));
  }
  RosValue value(const Field& field) {
    if (!field.is_list) return single(field.type);
    const std::size_t length = field.length > 0 ? field.length : count();
    const auto simple = primitive(field.type);
    if (simple && std::string_view("iuf").find(simple->kind) != std::string_view::npos) {
      if (length > all_.size()) throw RosError("the message ends too early");
      // Of no element there is no padding before it.
      if (length > 0) align(simple->size);
      return RosValue(RosValue::Numbers{simple->kind, simple->size, raw(length * simple->size)});
    }
    RosValue::List list;
    values_ += length;
    if (values_ > kMostValues) throw RosError("the message has too many parts");
    for (std::size_t i = 0; i < length; ++i) list.push_back(single(field.type));
    return RosValue(std::move(list));
  }

  const RosType& type_;
  const std::string_view all_;
  const RosEncoding encoding_;
  std::size_t position_ = 0, begin_ = 0, values_ = 0;
};

/// Puts a message's bytes together.
class RosType::Writer {
 public:
  Writer(const RosType& type, RosEncoding encoding) : type_(type), encoding_(encoding) {
    if (encoding == RosEncoding::kCdr) bytes_.assign("\0\1\0\0", kCdrHeader);
  }

  /// @param value null: all its fields are 0 or empty
  void message(const std::string& name, const RosValue* value) {
    const std::vector<Field>& fields = type_.messages_.at(name);
    const RosValue::Fields* given = nullptr;
    if (value) {
      given = std::get_if<RosValue::Fields>(&value->content());
      if (!given) throw RosError("a value is no " + name);
      check_names(name, fields, *given);
    }
    for (const Field& field : fields) {
      const RosValue* found = nullptr;
      for (std::size_t i = 0; given && i < given->size(); ++i) {
        if ((*given)[i].first == field.name) found = &(*given)[i].second;
      }
      member(name, field, found);
    }
    if (fields.empty() && encoding_ == RosEncoding::kCdr) bytes_ += '\0';
  }

  std::string take() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kCdrHeader = 4;

  static void check_names(const std::string& name, const std::vector<Field>& fields,
                          const RosValue::Fields& given) {
    for (const auto& one : given) {
      if (std::none_of(fields.begin(), fields.end(),
                       [&](const Field& field) { return field.name == one.first; })) {
        throw RosError("the type " + name + " has no field '" + one.first + "'");
      }
    }
  }
  void align(std::size_t size) {
    if (encoding_ != RosEncoding::kCdr) return;
    const std::size_t over = (bytes_.size() - kCdrHeader) % size;
    if (over != 0) bytes_.append(size - over, '\0');
  }
  void unaligned(std::uint64_t bits, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) bytes_ += static_cast<char>(bits >> (8 * i));
  }
  void count(std::size_t number) {
    if (number > std::numeric_limits<std::uint32_t>::max()) throw RosError("a list is too long");
    align(4);
    unaligned(number, 4);
  }
  void text(std::string_view value) {
    const bool cdr = encoding_ == RosEncoding::kCdr;
    count(value.size() + (cdr ? 1 : 0));
    bytes_ += value;
    if (cdr) bytes_ += '\0';
  }
  // Bits of a whole number, checked against the range of its type.
  static std::uint64_t whole(const RosValue& value, const Primitive& type) {
    const auto* natural = std::get_if<std::uint64_t>(&value.content());
    const std::int64_t number = natural && *natural > INT64_MAX ? 0 : value.integer();
    const auto bits = static_cast<int>(8 * type.size);
    const bool fits = type.kind == 'i'
                          ? bits == 64 ? !natural || *natural <= INT64_MAX
                                       : number >= -(std::int64_t{1} << (bits - 1)) &&
                                             number < (std::int64_t{1} << (bits - 1))
                          : number >= 0 && (bits == 64 || ((!natural || *natural <= INT64_MAX) &&
                                                           number < (std::int64_t{1} << bits)));
    if (!fits) throw RosError("a number is out of its type's range");
    return natural ? *natural : static_cast<std::uint64_t>(number);
  }
  void number(const RosValue* value, const Primitive& type) {
    align(type.size);
    std::uint64_t bits = 0;
    if (value && type.kind == 'f') {
      const double number = value->number();
      const auto single = static_cast<float>(number);
      if (type.size == 4) {
        std::memcpy(&bits, &single, 4);
      } else {
        std::memcpy(&bits, &number, 8);
      }
    } else if (value) {
      bits = whole(*value, type);
    }
    unaligned(bits, type.size);
  }
  void single(const std::string& name, const RosValue* value) {
    const auto simple = primitive(name);
    if (!simple) {
      message(name, value);
    } else if (simple->kind == 's') {
      text(value ? value->text() : std::string_view());
    } else if (simple->kind == 't' || simple->kind == 'd') {
      number(value ? &(*value)["sec"] : nullptr, {simple->kind == 'd' ? 'i' : 'u', 4});
      number(value ? &(*value)["nanosec"] : nullptr, {simple->kind == 'd' ? 'i' : 'u', 4});
    } else {
      number(value, *simple);
    }
  }
  void length(const Field& field, std::size_t given) {
    if (field.length == 0) return count(given);
    if (given != field.length) {
      throw RosError("the list has " + std::to_string(given) + " values instead of " +
                     std::to_string(field.length));
    }
  }
  void list(const Field& field, const RosValue& value) {
    const auto simple = primitive(field.type);
    const auto* numbers = std::get_if<RosValue::Numbers>(&value.content());
    if (numbers && (!simple || simple->kind != numbers->kind || simple->size != numbers->size)) {
      throw RosError("its numbers are of another kind");
    }
    if (!numbers) {
      length(field, value.list().size());
      for (const RosValue& one : value.list()) single(field.type, &one);
      return;
    }
    length(field, numbers->bytes.size() / numbers->size);
    if (!numbers->bytes.empty()) align(numbers->size);
    bytes_ += numbers->bytes;
  }
  void member(const std::string& type, const Field& field, const RosValue* value) {
    try {
      if (!field.is_list) {
        single(field.type, value);
      } else if (value) {
        list(field, *value);
      } else {
        if (field.length == 0) count(0);
        for (std::size_t i = 0; i < field.length; ++i) single(field.type, nullptr);
      }
    } catch (const RosError& error) {
      throw RosError(type + "." + field.name + ": " + error.what());
    }
  }

  const RosType& type_;
  const RosEncoding encoding_;
  std::string bytes_;
};

RosType::RosType(const std::string& name, std::string_view definition)
    : root_(ros_type_name(name)) {
  std::string current = root_;
  std::string text;
  bool names_next = false;
  while (!definition.empty()) {
    const std::size_t end = std::min(definition.find('\n'), definition.size());
    const std::string_view line = trimmed(definition.substr(0, end));
    definition.remove_prefix(std::min(end + 1, definition.size()));
    if (line.size() >= 3 && line.find_first_not_of('=') == std::string_view::npos) {
      parse(current, text);
      text.clear();
      names_next = true;
    } else if (names_next && line.substr(0, 4) == "MSG:") {
      current = ros_type_name(trimmed(line.substr(4)));
      names_next = false;
    } else {
      text.append(line).push_back('\n');
    }
  }
  parse(current, text);
  check(root_, 0);
}

void RosType::parse(const std::string& name, std::string_view text) {
  const std::string package = name.substr(0, name.find('/'));
  std::vector<Field>& fields = messages_[name];
  fields.clear();
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t equals = line.find('=');
    const std::size_t bound = line.find("<=");
    // Constants have a value; what follows '=' may hold a '#'. A bound's is no constant's.
    const bool is_constant =
        equals != std::string_view::npos && line.find('#') > equals &&
        !(bound != std::string_view::npos && line.find('=', bound + 2) == std::string_view::npos);
    if (is_constant) continue;
    line = trimmed(line.substr(0, line.find('#')));
    if (!line.empty()) fields.push_back(parse_field(line, package));
  }
}

RosType::Field RosType::parse_field(std::string_view line, const std::string& package) {
  const std::size_t gap = line.find_first_of(" \t");
  if (gap == std::string_view::npos) {
    throw RosError("the definition's line '" + std::string(line) + "' is no field");
  }
  Field field;
  std::string_view type = line.substr(0, gap);
  const std::string_view rest = trimmed(line.substr(gap));
  field.name = rest.substr(0, rest.find_first_of(" \t"));  // then its default, of ROS 2
  if (const std::size_t open = type.find('['); open != std::string_view::npos) {
    field.is_list = true;
    const std::string_view size = type.substr(open + 1, type.find(']') - open - 1);
    if (!size.empty() && size.front() != '<') {
      const auto parsed = std::from_chars(size.data(), size.data() + size.size(), field.length);
      if (parsed.ec != std::errc() || parsed.ptr != size.data() + size.size() ||
          field.length == 0) {
        throw RosError("the definition's line '" + std::string(line) +
                       "' has a length that is none");
      }
    }
    type = type.substr(0, open);
  }
  type = type.substr(0, type.find('<'));  // a text's bound
  if (type == "wstring") throw RosError("wide texts are not read: '" + std::string(line) + "'");
  if (primitive(type)) {
    field.type = type;
  } else if (type == "Header") {
    field.type = "std_msgs/Header";
  } else if (type.find('/') == std::string_view::npos) {
    field.type = package + "/" + std::string(type);
  } else {
    field.type = ros_type_name(type);
  }
  return field;
}

void RosType::check(const std::string& type, std::size_t depth) const {
  const auto found = messages_.find(type);
  if (found == messages_.end()) {
    throw RosError("the definition of " + root_ + " does not describe '" + type + "'");
  }
  if (depth > kDeepest) throw RosError("the definition of " + root_ + " contains itself");
  for (const Field& field : found->second) {
    if (!primitive(field.type)) check(field.type, depth + 1);
  }
}

RosValue RosType::read(std::string_view bytes, RosEncoding encoding) const {
  return Reader(*this, bytes, encoding).message(root_);
}

std::string RosType::write(const RosValue& message, RosEncoding encoding) const {
  Writer writer(*this, encoding);
  writer.message(root_, &message);
  return writer.take();
}

}  // namespace prehend::recording
