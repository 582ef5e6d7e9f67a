#include "prehend/robot/formats/tracked_xml.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <sstream>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include <strings.h>
#include <tinyxml2.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/archive.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/text/xml_size.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;

constexpr std::uintmax_t kMostBytes = 64 << 20;

}  // namespace

struct TrackedXml::State {
  tinyxml2::XMLDocument document;
  std::string file;
  LossReport* loss = nullptr;
  std::unordered_set<const void*> read;  // elements and attributes
  std::unordered_set<const void*> told;  // elements of which all is accounted for
  bool ignores_case = false;
  std::optional<std::unordered_map<std::string, const tinyxml2::XMLElement*>> ids;

  void collect_ids(const tinyxml2::XMLElement& element) {
    if (const char* id = element.Attribute("id")) ids->emplace(id, &element);
    for (const auto* child = element.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      collect_ids(*child);
    }
  }

  bool is_called(const char* name, const char* wanted) const {
    return ignores_case ? strcasecmp(name, wanted) == 0 : std::strcmp(name, wanted) == 0;
  }
  const tinyxml2::XMLAttribute* attribute(const tinyxml2::XMLElement& element,
                                          const char* name) const {
    const auto* found = element.FirstAttribute();
    while (found && !is_called(found->Name(), name)) found = found->Next();
    return found;
  }
  /// The first child of that name, or the next after `before`; of any name for null.
  const tinyxml2::XMLElement* child(const tinyxml2::XMLElement& element, const char* name,
                                    const tinyxml2::XMLElement* before = nullptr) const {
    const auto* found = before ? before->NextSiblingElement() : element.FirstChildElement();
    while (found && name && !is_called(found->Name(), name)) found = found->NextSiblingElement();
    return found;
  }

  void finish(const tinyxml2::XMLElement& element, const std::string& path) {
    if (told.count(&element) != 0) return;
    const std::string place = file + ":" + std::to_string(element.GetLineNum());
    if (read.count(&element) == 0) {
      loss->drop(place, path, "nothing here is made of it");
      return;
    }
    loss->keep(path);
    for (const auto* attribute = element.FirstAttribute(); attribute;
         attribute = attribute->Next()) {
      const std::string name = path + "/@" + attribute->Name();
      if (std::string_view(attribute->Name()).starts_with("xmlns")) continue;
      if (read.count(attribute) != 0) {
        loss->keep(name);
      } else if (told.count(attribute) == 0) {
        loss->drop(place, name, "nothing here is made of it");
      }
    }
    for (const auto* child = element.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      finish(*child, path + "/" + child->Name());
    }
  }
};

std::vector<double> parse_numbers(const std::string& text, std::size_t count,
                                  const std::string& place) {
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    double number = 0;
    const char* begin = word.data() + (word.front() == '+' ? 1 : 0);
    const auto parsed = std::from_chars(begin, word.data() + word.size(), number);
    if (parsed.ec != std::errc() || parsed.ptr != word.data() + word.size() ||
        !std::isfinite(number)) {
      throw InputError(place + ": '" + word + "' is no number", "Mend the file");
    }
    numbers.push_back(number);
  }
  if (count != 0 && numbers.size() != count) {
    throw InputError(place + ": '" + text + "' has " + std::to_string(numbers.size()) +
                         " numbers instead of " + std::to_string(count),
                     "Mend the file");
  }
  return numbers;
}

TrackedXml::TrackedXml(const std::string& text, std::string file, LossReport& loss)
    : state_(std::make_unique<State>()) {
  state_->file = std::move(file);
  state_->loss = &loss;
  if (text.size() > kMostBytes) {
    throw InputError(state_->file + " is larger than 64 MiB: no robot's file", "Check the path");
  }
  text::refuse_xml_bomb(text, state_->file);
  if (state_->document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS ||
      !state_->document.RootElement()) {
    const char* words = state_->document.ErrorStr();
    throw InputError(state_->file + ":" + std::to_string(state_->document.ErrorLineNum()) +
                         " is no well-formed XML: " + (words ? words : "it has no element"),
                     "Mend it (xmllint names the place, too)");
  }
}

TrackedXml TrackedXml::read(const std::filesystem::path& file, LossReport& loss) {
  const std::string bytes = whole_file(file);
  if (!is_archive(bytes)) return {bytes, file.string(), loss};
  LossReport of_manifest;
  TrackedXml manifest(file_of_archive(file, "manifest.xml"), file.string() + "/manifest.xml",
                      of_manifest);
  std::string name = manifest.root().text();
  name = name.substr(0, name.find('#'));
  if (name.starts_with("./")) name.erase(0, 2);
  return {file_of_archive(file, name), file.string() + "/" + name, loss};
}

TrackedXml::~TrackedXml() = default;
TrackedXml::TrackedXml(TrackedXml&&) noexcept = default;

XmlElement TrackedXml::root() {
  const auto* element = state_->document.RootElement();
  state_->read.insert(element);
  return {*this, *element};
}

std::optional<XmlElement> TrackedXml::by_id(const std::string& id) {
  State& state = *state_;
  if (!state.ids) {
    state.ids.emplace();
    state.collect_ids(*state.document.RootElement());
  }
  const auto found = state.ids->find(id);
  if (found == state.ids->end()) return std::nullopt;
  for (const tinyxml2::XMLNode* node = found->second; node && node->ToElement();
       node = node->Parent()) {
    state.read.insert(node->ToElement());
  }
  state.read.insert(found->second->FindAttribute("id"));
  return XmlElement(*this, *found->second);
}

void TrackedXml::ignore_case() { state_->ignores_case = true; }

void TrackedXml::finish() {
  const auto* root = state_->document.RootElement();
  state_->finish(*root, root->Name());
}

std::string XmlElement::name() const { return element_->Name(); }

std::string XmlElement::place() const {
  return document_->state_->file + ":" + std::to_string(element_->GetLineNum());
}

std::string XmlElement::path() const {
  std::string path = element_->Name();
  for (const auto* above = element_->Parent(); above && above->ToElement();
       above = above->Parent()) {
    path = std::string(above->ToElement()->Name()) + "/" + path;
  }
  return path;
}

std::optional<std::string> XmlElement::attribute(const char* name) const {
  const auto* found = document_->state_->attribute(*element_, name);
  if (!found) return std::nullopt;
  document_->state_->read.insert(found);
  return found->Value();
}

std::string XmlElement::needed(const char* name) const {
  auto value = attribute(name);
  if (!value) fail("<" + this->name() + "> has no " + name, "Give it");
  return std::move(*value);
}

std::optional<double> XmlElement::number(const char* name) const {
  const auto value = numbers(name, 1);
  return value ? std::optional(value->front()) : std::nullopt;
}

double XmlElement::needed_number(const char* name) const {
  return parse_numbers(needed(name), 1, place() + ", " + name).front();
}

std::optional<std::vector<double>> XmlElement::numbers(const char* name, std::size_t count) const {
  const auto value = attribute(name);
  if (!value) return std::nullopt;
  return parse_numbers(*value, count, place() + ", " + name);
}

std::string XmlElement::text() const {
  const char* text = element_->GetText();
  std::string_view all = text ? text : "";
  while (!all.empty() && std::isspace(static_cast<unsigned char>(all.front())))
    all.remove_prefix(1);
  while (!all.empty() && std::isspace(static_cast<unsigned char>(all.back()))) all.remove_suffix(1);
  return std::string(all);
}

double XmlElement::text_number() const { return text_numbers(1).front(); }

std::vector<double> XmlElement::text_numbers(std::size_t count) const {
  return parse_numbers(text(), count, place() + ", <" + name() + ">");
}

std::optional<XmlElement> XmlElement::child(const char* name) const {
  const auto* found = document_->state_->child(*element_, name);
  if (!found) return std::nullopt;
  document_->state_->read.insert(found);
  return XmlElement(*document_, *found);
}

std::vector<XmlElement> XmlElement::children(const char* name) const {
  std::vector<XmlElement> all;
  const auto& state = *document_->state_;
  for (const auto* found = state.child(*element_, name); found;
       found = state.child(*element_, name, found)) {
    document_->state_->read.insert(found);
    all.push_back({*document_, *found});
  }
  return all;
}

std::vector<XmlElement> XmlElement::children() const { return children(nullptr); }

void XmlElement::drop(const std::string& why) const {
  document_->state_->told.insert(element_);
  document_->state_->loss->drop(place(), path(), why);
}

void XmlElement::approximate(const std::string& how) const {
  document_->state_->told.insert(element_);
  document_->state_->loss->approximate(place(), path(), how);
}

void XmlElement::drop_attribute(const char* name, const std::string& why) const {
  const auto* found = document_->state_->attribute(*element_, name);
  if (!found) return;
  document_->state_->told.insert(found);
  document_->state_->loss->drop(place(), path() + "/@" + name, why);
}

void XmlElement::fail(const std::string& wrong, const std::string& mend) const {
  throw InputError(place() + ": " + wrong, mend);
}

}  // namespace prehend::robot::formats
