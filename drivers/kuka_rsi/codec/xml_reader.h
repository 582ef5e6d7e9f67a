#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace prehend::drivers::kuka_rsi {

struct XmlAttribute {
  std::string_view name, value;
};

/// Reads the XML that RSI telegrams consist of, an event at a time, and keeps nothing but views of
/// the text: elements, attributes and plain text. What telegrams never have is refused, as it is
/// what attacks are made of: declarations, document types, comments, CDATA, entities and character
/// references. Sizes are bounded by constants. It allocates nothing.
class XmlReader {
 public:
  static constexpr std::size_t kLongestText = 4096;  // bytes; a telegram is below 1500
  static constexpr std::size_t kLongestName = 32;
  static constexpr std::size_t kMostDepth = 4;  // a telegram has 2
  static constexpr std::size_t kMostAttributes = 16;

  enum class Event {
    kStart,  ///< of the element name() with attributes(); <a/> is a start and an end
    kText,   ///< between tags, more than white space
    kEnd,    ///< of the element name()
    kDone,   ///< the text is over, and was right
    kWrong,  ///< see problem(); so is everything that follows
  };

  /// `text` must outlive the reader.
  explicit XmlReader(std::string_view text);

  Event next();
  std::string_view name() const { return name_; }
  std::span<const XmlAttribute> attributes() const {
    return std::span(attributes_).first(attribute_count_);
  }
  std::string_view text() const { return text_; }
  /// What is wrong, in words; "" while nothing is.
  const char* problem() const { return problem_; }
  /// How many elements are open, the present one counted from its start to its end.
  std::size_t depth() const { return depth_; }

 private:
  Event wrong(const char* why);
  Event read_start();
  Event read_end();
  bool read_attribute();
  std::string_view read_name();
  void skip_space();
  bool at(char c) const { return !left_.empty() && left_.front() == c; }

  std::string_view left_;
  std::string_view name_, text_;
  std::array<XmlAttribute, kMostAttributes> attributes_;
  std::size_t attribute_count_ = 0;
  std::array<std::string_view, kMostDepth> open_;
  std::size_t depth_ = 0;
  bool ends_at_once_ = false;  // <a/>
  bool has_root_ = false;
  const char* problem_ = "";
};

}  // namespace prehend::drivers::kuka_rsi
