#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/formats/loss_report.h"

namespace tinyxml2 {
class XMLElement;
}

// XML of which is known what was read of it.
namespace prehend::robot::formats {

class TrackedXml;

/// An element. What is asked for counts as kept. Cheap to copy; lives as long as its document.
class XmlElement {
 public:
  XmlElement(TrackedXml& document, const tinyxml2::XMLElement& element)
      : document_(&document), element_(&element) {}

  std::string name() const;
  /// "FILE:LINE"
  std::string place() const;
  std::optional<std::string> attribute(const char* name) const;
  /// @throws geometry::InputError with the place when it is missing, or no number
  std::string needed(const char* name) const;
  std::optional<double> number(const char* name) const;
  double needed_number(const char* name) const;
  std::optional<std::vector<double>> numbers(const char* name, std::size_t count) const;
  /// The text in it; empty: none.
  std::string text() const;
  double text_number() const;
  std::vector<double> text_numbers(std::size_t count) const;
  std::optional<XmlElement> child(const char* name) const;
  std::vector<XmlElement> children(const char* name) const;
  std::vector<XmlElement> children() const;

  /// It and all below and of it are accounted for by words.
  void drop(const std::string& why) const;
  void approximate(const std::string& how) const;
  /// An attribute of it.
  void drop_attribute(const char* name, const std::string& why) const;
  [[noreturn]] void fail(const std::string& wrong, const std::string& mend) const;

 private:
  friend class TrackedXml;
  std::string path() const;
  TrackedXml* document_;
  const tinyxml2::XMLElement* element_;
};

/// @throws geometry::InputError for words that are not `count` finite numbers; 0: any count
std::vector<double> parse_numbers(const std::string& text, std::size_t count,
                                  const std::string& place);

/// A document. Entities of its own are not expanded, so that none can grow; elements are at most
/// 100 deep, a file has at most 64 MiB and a million elements and attributes.
class TrackedXml {
 public:
  /// @throws geometry::InputError with file, line and what is wrong when it is no XML.
  TrackedXml(const std::string& text, std::string file, LossReport& loss);
  /// A file's, or of an archive (.zae) the document that its manifest.xml names.
  static TrackedXml read(const std::filesystem::path& file, LossReport& loss);
  ~TrackedXml();
  TrackedXml(TrackedXml&&) noexcept;

  XmlElement root();
  /// The element with that attribute `id`, wherever it is; it and all around it count as kept.
  std::optional<XmlElement> by_id(const std::string& id);
  /// That of "#id"; none for an address in another document, too.
  std::optional<XmlElement> by_url(const std::string& url) {
    return url.starts_with('#') ? by_id(url.substr(1)) : std::nullopt;
  }
  /// Names of elements and attributes are found whatever their case.
  void ignore_case();
  /// Everything that nobody asked for is dropped, and said to be, with the outermost element of
  /// each part.
  void finish();

 private:
  friend class XmlElement;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace prehend::robot::formats
