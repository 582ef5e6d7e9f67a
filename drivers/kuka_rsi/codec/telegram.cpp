#include "drivers/kuka_rsi/codec/telegram.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "drivers/kuka_rsi/codec/xml_reader.h"

namespace prehend::drivers::kuka_rsi {
namespace {

using Event = XmlReader::Event;
using NamesOfSix = std::array<std::string_view, kAxes>;

constexpr NamesOfSix kAxisNames{"A1", "A2", "A3", "A4", "A5", "A6"};
constexpr NamesOfSix kPoseNames{"X", "Y", "Z", "A", "B", "C"};
constexpr double kLargest = 1e6;  // mm or deg

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(std::abs(value) <= kLargest)) return std::nullopt;
  return value;
}

std::string_view trimmed_text(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") + 1 - first);
}

std::string_view attribute_of(const XmlReader& reader, std::string_view name) {
  for (const XmlAttribute& attribute : reader.attributes()) {
    if (attribute.name == name) return attribute.value;
  }
  return {};
}

// An element with six numbers; nothing where all are empty.
bool read_six(const XmlReader& reader, const NamesOfSix& names, std::optional<Axes>& six,
              const char*& why) {
  if (six) {
    why = "an element is given twice";
    return false;
  }
  Axes values{};
  std::size_t given = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const std::string_view text = attribute_of(reader, names[i]);
    if (text.empty()) continue;
    const std::optional<double> value = number_of(text);
    if (!value) {
      why = "a number is none, or beyond all measure";
      return false;
    }
    values[i] = *value;
    ++given;
  }
  if (given == 0) return true;
  if (given < kAxes) {
    why = "one of six values is missing";
    return false;
  }
  six = values;
  return true;
}

// Reads the root's children: `on_start` for each, `on_text` for what text it has; both return false
// where something is wrong.
template <class OnRoot, class OnStart, class OnText>
bool read_children(XmlReader& reader, std::string_view root, const char*& why, OnRoot on_root,
                   OnStart on_start, OnText on_text) {
  std::string_view child;
  while (true) {
    switch (reader.next()) {
      case Event::kStart:
        if (reader.depth() == 1) {
          if (reader.name() != root) {
            why = "its root is another element";
            return false;
          }
          on_root(reader);
        } else if (reader.depth() == 2) {
          child = reader.name();
          if (!on_start(reader)) return false;
        }
        break;
      case Event::kText:
        if (reader.depth() == 2 && !on_text(child, trimmed_text(reader.text()))) return false;
        break;
      case Event::kEnd:
        break;
      case Event::kDone:
        return true;
      case Event::kWrong:
        why = reader.problem();
        return false;
    }
  }
}

bool take_ipoc(std::string_view text, bool& has_ipoc, Ipoc& ipoc, const char*& why) {
  const std::optional<Ipoc> read = Ipoc::parse(text);
  if (!read || has_ipoc) {
    why = has_ipoc ? "an element is given twice" : "IPOC is no time stamp";
    return false;
  }
  ipoc = *read;
  has_ipoc = true;
  return true;
}

/// Text into a buffer; remembers when it was too small.
class Writer {
 public:
  explicit Writer(std::span<char> out) : out_(out) {}

  Writer& operator<<(std::string_view text) {
    if (text.size() > out_.size() - size_) {
      fits_ = false;
      return *this;
    }
    std::copy(text.begin(), text.end(), out_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += text.size();
    return *this;
  }
  void number(double value, int decimals) {
    if (!(std::abs(value) <= kLargest)) {
      fits_ = false;
      return;
    }
    std::int64_t scale = 1;
    for (int i = 0; i < decimals; ++i) scale *= 10;
    std::int64_t counts = std::llround(value * static_cast<double>(scale));
    if (counts < 0) *this << "-";
    counts = std::abs(counts);
    integer(static_cast<std::uint64_t>(counts / scale));
    if (decimals == 0) return;
    *this << ".";
    std::array<char, 20> digits{};
    std::int64_t left = counts % scale;
    for (int i = decimals - 1; i >= 0; --i, left /= 10) {
      digits[static_cast<std::size_t>(i)] = static_cast<char>('0' + left % 10);
    }
    *this << std::string_view(digits.data(), static_cast<std::size_t>(decimals));
  }
  void integer(std::uint64_t value) { *this << Ipoc::of(value).text(); }
  void six(std::string_view name, const NamesOfSix& names, const Axes& values, int decimals) {
    *this << "<" << name;
    for (std::size_t i = 0; i < kAxes; ++i) {
      *this << " " << names[i] << "=\"";
      number(values[i], decimals);
      *this << "\"";
    }
    *this << "/>";
  }
  std::size_t size() const { return fits_ ? size_ : 0; }

 private:
  std::span<char> out_;
  std::size_t size_ = 0;
  bool fits_ = true;
};

}  // namespace

std::optional<Ipoc> Ipoc::parse(std::string_view text) {
  Ipoc ipoc;
  if (text.empty() || text.size() > ipoc.digits.size()) return std::nullopt;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, ipoc.value);
  if (error != std::errc() || stop != end) return std::nullopt;
  std::copy(text.begin(), text.end(), ipoc.digits.begin());
  ipoc.size = static_cast<std::uint8_t>(text.size());
  return ipoc;
}

Ipoc Ipoc::of(std::uint64_t value) {
  Ipoc ipoc;
  ipoc.value = value;
  const auto written =
      std::to_chars(ipoc.digits.data(), ipoc.digits.data() + ipoc.digits.size(), value);
  ipoc.size = static_cast<std::uint8_t>(written.ptr - ipoc.digits.data());
  return ipoc;
}

TelegramResult read_robot_telegram(std::string_view text, const TelegramNames& names,
                                   RobotTelegram& telegram, const char*& why) {
  telegram = {};
  why = "";
  bool has_ipoc = false;
  XmlReader reader(text);
  const auto start = [&](const XmlReader& child) {
    const std::string_view name = child.name();
    if (name == names.actual_axes) return read_six(child, kAxisNames, telegram.actual_axes, why);
    if (name == names.commanded_axes) {
      return read_six(child, kAxisNames, telegram.commanded_axes, why);
    }
    if (name == names.actual_pose) return read_six(child, kPoseNames, telegram.actual_pose, why);
    if (name != names.delay) return true;
    const std::string_view value = attribute_of(child, "D");
    if (value.empty()) return true;
    const std::optional<Ipoc> delay = Ipoc::parse(value);
    if (!delay || telegram.delay) {
      why = "Delay is no number, or given twice";
      return false;
    }
    telegram.delay = delay->value;
    return true;
  };
  const auto words = [&](std::string_view name, std::string_view content) {
    return name != "IPOC" || take_ipoc(content, has_ipoc, telegram.ipoc, why);
  };
  if (!read_children(
          reader, names.robot, why, [](const XmlReader&) {}, start, words)) {
    return TelegramResult::kWrong;
  }
  return has_ipoc ? TelegramResult::kGood : TelegramResult::kShort;
}

TelegramResult read_sensor_telegram(std::string_view text, const TelegramNames& names,
                                    SensorTelegram& telegram, const char*& why) {
  telegram = {};
  why = "";
  bool has_ipoc = false;
  XmlReader reader(text);
  const auto root = [&](const XmlReader& sensor) { telegram.type = attribute_of(sensor, "Type"); };
  const auto start = [&](const XmlReader& child) {
    return child.name() != names.correction ||
           read_six(child, kAxisNames, telegram.correction, why);
  };
  const auto words = [&](std::string_view name, std::string_view content) {
    if (name == names.message) telegram.message = content;
    return name != "IPOC" || take_ipoc(content, has_ipoc, telegram.ipoc, why);
  };
  if (!read_children(reader, names.sensor, why, root, start, words)) return TelegramResult::kWrong;
  return has_ipoc ? TelegramResult::kGood : TelegramResult::kShort;
}

std::size_t write_sensor_telegram(std::span<char> out, const TelegramNames& names,
                                  const Axes& correction, const Ipoc& ipoc,
                                  std::string_view message) {
  Writer writer(out);
  writer << "<" << names.sensor << " Type=\"" << names.type << "\">";
  if (!names.message.empty()) {
    writer << "<" << names.message << ">";
    for (const char c : message) {
      const bool is_plain = c >= ' ' && c <= '~' && c != '<' && c != '>' && c != '&';
      writer << std::string_view(is_plain ? &c : " ", 1);
    }
    writer << "</" << names.message << ">";
  }
  writer.six(names.correction, kAxisNames, correction, names.decimals);
  writer << "<IPOC>" << ipoc.text() << "</IPOC></" << names.sensor << ">";
  return writer.size();
}

std::size_t write_robot_telegram(std::span<char> out, const TelegramNames& names,
                                 const RobotTelegram& telegram, const RobotLayout& layout) {
  Writer writer(out);
  const std::string_view line = layout.has_lines ? "\r\n" : "";
  writer << "<" << names.robot << (layout.type_in_capitals ? " TYPE" : " Type") << "=\"KUKA\">"
         << line;
  const auto put = [&](const std::string& name, const NamesOfSix& of,
                       const std::optional<Axes>& values) {
    if (!values) return;
    writer.six(name, of, *values, layout.decimals);
    writer << line;
  };
  put(names.actual_pose, kPoseNames, telegram.actual_pose);
  put(names.actual_axes, kAxisNames, telegram.actual_axes);
  put(names.commanded_axes, kAxisNames, telegram.commanded_axes);
  if (telegram.delay) {
    writer << "<" << names.delay << " D=\"";
    writer.integer(*telegram.delay);
    writer << "\"/>" << line;
  }
  writer << "<IPOC>" << telegram.ipoc.text() << "</IPOC>" << line << "</" << names.robot << ">";
  return writer.size();
}

}  // namespace prehend::drivers::kuka_rsi
