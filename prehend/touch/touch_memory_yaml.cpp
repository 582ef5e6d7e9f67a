#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/whole_file.h"
#include "prehend/text/yaml_map.h"
#include "prehend/touch/touch_memory.h"

namespace prehend::touch {
namespace {

constexpr std::size_t kLongestFile = 1 << 20;  // bytes, of strict YAML
constexpr int kFileVersion = 1;

std::string digits_of(const Imprint& imprint) {
  std::string digits;
  for (const double pressed : imprint.pressed) {
    digits.push_back(static_cast<char>('0' + std::lround(9 * pressed)));
  }
  return digits;
}

std::vector<double> numbers_in(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (std::string word; stream >> word;) {
    std::size_t used = 0;
    const double number = std::stod(word, &used);
    if (used != word.size() || !std::isfinite(number)) throw std::invalid_argument(word);
    numbers.push_back(number);
  }
  return numbers;
}

using Places = std::vector<Eigen::Vector2d>;

class MemoryReader {
 public:
  MemoryReader(const std::filesystem::path& file, TouchMemory* memory)
      : file_(file), memory_(memory) {}

  void read() {
    text::YamlMap map(text::load_yaml_map(file_), file_, "memory");
    int version = 0;
    map.read("version", version);
    if (version != kFileVersion) {
      map.fail("version", fmt::format("is {}", version),
               fmt::format("This program reads {}", kFileVersion));
    }
    for (const YAML::Node& node : map.child("layouts")) {
      text::YamlMap layout(node, file_, "layouts");
      const std::vector<double> x = numbers(layout, "x"), y = numbers(layout, "y");
      if (x.size() != y.size() || x.empty())
        layout.fail("x", "is not as long as y", "Save it anew");
      layouts_.emplace_back();
      for (std::size_t i = 0; i < x.size(); ++i) layouts_.back().emplace_back(x[i], y[i]);
      layout.finish();
    }
    for (const YAML::Node& node : map.child("things")) {
      text::YamlMap thing(node, file_, "things");
      std::string name;
      thing.read("name", name);
      for (const YAML::Node& press : thing.child("presses")) read_press(press, name);
      thing.finish();
    }
    map.finish();
  }

 private:
  std::vector<double> numbers(text::YamlMap& map, const std::string& key) {
    std::string text;
    map.read(key, text);
    try {
      return numbers_in(text);
    } catch (const std::exception&) {
      map.fail(key, "is no row of numbers", "Save the memory anew");
    }
  }

  void read_press(const YAML::Node& node, const std::string& name) {
    text::YamlMap map(node, file_, "presses");
    const std::vector<double> features = numbers(map, "features");
    RememberedPress press;
    press.features = Eigen::Map<const Eigen::VectorXd>(features.data(),
                                                       static_cast<Eigen::Index>(features.size()));
    for (const YAML::Node& imprint : map.child("imprints")) {
      text::YamlMap one(imprint, file_, "imprints");
      int layout = -1;
      std::string digits;
      one.read("layout", layout);
      one.read("pressed", digits);
      one.finish();
      if (layout < 0 || layout >= static_cast<int>(layouts_.size())) {
        one.fail("layout", "is none of the file's layouts", "Save the memory anew");
      }
      Imprint read{layouts_[layout], {}};
      for (const char digit : digits) {
        if (digit < '0' || digit > '9') one.fail("pressed", "has what is no digit", "Save it anew");
        read.pressed.push_back((digit - '0') / 9.0);
      }
      if (read.pressed.size() != read.places.size()) {
        one.fail("pressed", "is not as long as its layout", "Save the memory anew");
      }
      press.imprints.push_back(std::move(read));
    }
    map.finish();
    try {
      memory_->teach(name, press);
    } catch (const std::invalid_argument& error) {
      map.fail("features", error.what(), "Save the memory anew");
    }
  }

  const std::filesystem::path& file_;
  TouchMemory* memory_;
  std::vector<Places> layouts_;
};

}  // namespace

void TouchMemory::save(const std::filesystem::path& file) const {
  std::vector<Places> layouts;
  const auto layout_of = [&](const Imprint& imprint) {
    const auto found = std::find(layouts.begin(), layouts.end(), imprint.places);
    if (found != layouts.end()) return found - layouts.begin();
    layouts.push_back(imprint.places);
    return static_cast<std::ptrdiff_t>(layouts.size()) - 1;
  };
  std::string things;
  for (const auto& [name, presses] : things_) {
    std::string quoted;
    for (const char c : name) quoted += c == '\'' ? "''" : std::string(1, c);
    things += fmt::format("  - name: '{}'\n    presses:\n", quoted);
    for (const RememberedPress& press : presses) {
      things += fmt::format("      - features: '{:.6g}'\n        imprints:\n",
                            fmt::join(press.features, " "));
      for (const Imprint& imprint : press.imprints) {
        things += fmt::format("          - {{layout: {}, pressed: '{}'}}\n", layout_of(imprint),
                              digits_of(imprint));
      }
    }
  }
  std::string text = fmt::format(
      "# What was taught by touch (prehend/touch/touch_memory.h). x, y [m]: places of texels;\n"
      "# pressed: of each, 0 to 9; features: of the grasp.\nversion: {}\nlayouts:{}\n",
      kFileVersion, layouts.empty() ? " []" : "");
  for (const Places& places : layouts) {
    for (const int k : {0, 1}) {
      text += k == 0 ? "  - x: '" : "    y: '";
      for (const Eigen::Vector2d& place : places) text += fmt::format("{:.5g} ", place[k]);
      text += "'\n";
    }
  }
  text += things_.empty() ? "things: []" : "things:\n" + things;
  if (text.size() > kLongestFile) {
    throw geometry::InputError(
        fmt::format("{}: the memory has {} bytes and could not be read again", file.string(),
                    text.size()),
        fmt::format("Forget some things: a file may have {} bytes", kLongestFile));
  }
  geometry::write_whole_file(file, text, "The memory of touch");
}

TouchMemory TouchMemory::load(const std::filesystem::path& file, RecogniseBy by) {
  TouchMemory memory(by);
  MemoryReader(file, &memory).read();
  return memory;
}

}  // namespace prehend::touch
