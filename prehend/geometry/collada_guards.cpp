#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#include <tinyxml2.h>

#include "prehend/geometry/mesh_guards.h"
#include "prehend/text/xml_size.h"

namespace prehend::geometry {
namespace {

using tinyxml2::XMLElement;

bool is(const XMLElement& element, const char* name) {
  return std::strcmp(element.Name(), name) == 0;
}

std::string attribute(const XMLElement& element, const char* name) {
  const char* const text = element.Attribute(name);
  return text != nullptr ? text : "";
}

template <class Visit>
void visit_all(XMLElement& element, const Visit& visit) {
  visit(element);
  for (auto* one = element.FirstChildElement(); one; one = one->NextSiblingElement()) {
    visit_all(*one, visit);
  }
}

/// The nodes of a file, which Assimp finds by id, or else by name.
class ColladaNodes {
 public:
  ColladaNodes(XMLElement& root, const std::filesystem::path& path) : path_(path) {
    visit_all(root, [this](XMLElement& element) { collect(element); });
    visit_all(root, [this](XMLElement& element) {
      if (is(element, "visual_scene")) expand(element, 0);
    });
  }

 private:
  using Nodes = std::multimap<std::string, const XMLElement*>;

  void collect(const XMLElement& element) {
    if (!is(element, "node")) return;
    if (const char* id = element.Attribute("id")) ids_.emplace(id, &element);
    if (const char* name = element.Attribute("name")) names_.emplace(name, &element);
  }

  void expand(const XMLElement& element, int depth) {
    if (depth > kDeepestLevel) refuse_mesh(path_, "has nodes deeper than 100, or in a ring");
    if (++shown_ > kMostNodes) refuse_mesh(path_, "shows its nodes more than 100,000 times");
    for (const auto* one = element.FirstChildElement(); one; one = one->NextSiblingElement()) {
      if (is(*one, "node")) expand(*one, depth + 1);
      if (!is(*one, "instance_node")) continue;
      const std::string url = attribute(*one, "url");
      if (!url.starts_with('#')) continue;
      const Nodes& known = ids_.count(url.substr(1)) != 0 ? ids_ : names_;
      const auto [first, end] = known.equal_range(url.substr(1));
      for (auto at = first; at != end; ++at) expand(*at->second, depth + 1);
    }
  }

  const std::filesystem::path& path_;
  Nodes ids_, names_;
  std::size_t shown_ = 0;  // nodes, as often as they stand for one
};

/// The lists of numbers, which Assimp believes to be as long as is said elsewhere.
class ColladaNumbers {
 public:
  ColladaNumbers(XMLElement& root, const std::filesystem::path& path) : path_(path) {
    visit_all(root, [this](XMLElement& element) {
      if (is(element, "float_array")) lengths_[attribute(element, "id")] = list_length(element);
    });
    visit_all(root, [this](XMLElement& element) {
      if (is(element, "accessor")) check_accessor(element);
      if (is(element, "p") || is(element, "vcount")) check_whole(element);
    });
  }

 private:
  [[noreturn]] void refuse_at(const XMLElement& element, const std::string& what) const {
    refuse_mesh(path_, "has a <" + std::string(element.Name()) + "> " + what + ", line " +
                           std::to_string(element.GetLineNum()));
  }

  double number(const XMLElement& element, const char* name, double otherwise) const {
    const std::string text = attribute(element, name);
    if (text.empty()) return otherwise;
    constexpr std::size_t kMostDigits = 9;
    if (text.size() > kMostDigits || text.find_first_not_of("0123456789") != std::string::npos) {
      refuse_at(element, "whose '" + std::string(name) + "' is no count");
    }
    return std::strtod(text.c_str(), nullptr);
  }

  /// As it is said: Assimp reads so many.
  double list_length(const XMLElement& array) const {
    const double said = number(array, "count", 0);
    const char* const text = array.GetText();
    if (said > (text != nullptr ? static_cast<double>(std::strlen(text) + 1) / 2 : 0)) {
      refuse_at(array, "with fewer numbers than its count");
    }
    return said;
  }

  void check_accessor(const XMLElement& accessor) const {
    const std::string source = attribute(accessor, "source");
    const auto found = lengths_.find(source.starts_with('#') ? source.substr(1) : source);
    if (found == lengths_.end()) refuse_at(accessor, "of no list of numbers");
    double parts = 0;
    for (const auto* one = accessor.FirstChildElement("param"); one;
         one = one->NextSiblingElement("param")) {
      ++parts;
    }
    const double count = number(accessor, "count", 0);
    const double end = number(accessor, "offset", 0) + (count - 1) * number(accessor, "stride", 1) +
                       std::max(parts, 1.0);
    if (count > 0 && end > found->second) refuse_at(accessor, "beyond its list of numbers");
  }

  /// Assimp takes whole numbers for as long as there is text, and stands still at any other sign.
  void check_whole(const XMLElement& element) const {
    const char* const text = element.GetText();
    if (text != nullptr && std::strspn(text, "0123456789 \t\r\n") != std::strlen(text)) {
      refuse_at(element, "that is no list of whole numbers");
    }
  }

  const std::filesystem::path& path_;
  std::map<std::string, double> lengths_;  // of lists of numbers, by their id
};

/// The meshes of its skins, by the skins' ids; what deforms them is taken out.
std::map<std::string, std::string> without_skins(XMLElement& root) {
  std::map<std::string, std::string> meshes;
  visit_all(root, [&](XMLElement& element) {
    if (!is(element, "controller")) return;
    for (const char* kind : {"skin", "morph"}) {
      if (const auto* one = element.FirstChildElement(kind)) {
        meshes["#" + attribute(element, "id")] = attribute(*one, "source");
      }
    }
  });
  for (const char* library :
       {"library_animations", "library_animation_clips", "library_controllers"}) {
    while (auto* one = root.FirstChildElement(library)) root.DeleteChild(one);
  }
  return meshes;
}

/// A skin may be of a skin.
std::string mesh_of(const std::map<std::string, std::string>& meshes, std::string url) {
  for (std::size_t i = 0; i <= meshes.size(); ++i) {
    const auto found = meshes.find(url);
    if (found == meshes.end()) break;
    url = found->second;
  }
  return url;
}

}  // namespace

std::string sound_collada(const std::filesystem::path& path) {
  const std::string text = text_of(path);
  text::refuse_xml_bomb(text, path.string());
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS ||
      !document.RootElement()) {
    refuse_mesh(path, "could not be read: it is no well-formed XML, line " +
                          std::to_string(document.ErrorLineNum()));
  }
  XMLElement& root = *document.RootElement();
  const auto meshes = without_skins(root);
  visit_all(root, [&](XMLElement& element) {
    if (!is(element, "instance_controller")) return;
    element.SetName("instance_geometry");
    element.SetAttribute("url", mesh_of(meshes, attribute(element, "url")).c_str());
  });
  ColladaNodes(root, path);
  ColladaNumbers(root, path);
  tinyxml2::XMLPrinter printer(nullptr, true);
  document.Print(&printer);
  return {printer.CStr(), static_cast<std::size_t>(printer.CStrSize()) - 1};
}

}  // namespace prehend::geometry
