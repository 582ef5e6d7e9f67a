#include "prehend/sweep/cases.h"

#include <fnmatch.h>

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/text/input_error.h"

namespace prehend::sweep {
namespace {

constexpr std::size_t kLongestName = 180;  // files' names have at most 255 bytes

// Calls `plain` with what stands between placeholders and `named` with each of their names.
template <class Plain, class Named>
void walk(const std::string& argument, Plain plain, Named named) {
  for (std::size_t i = 0; i < argument.size(); ++i) {
    const char c = argument[i];
    const bool twice = i + 1 < argument.size() && argument[i + 1] == c;
    if ((c == '{' || c == '}') && twice) {
      plain(c);
      ++i;
    } else if (c == '{') {
      const std::size_t end = argument.find('}', i);
      if (end == std::string::npos) {
        throw text::InputError("The argument '" + argument + "' has a { without its }",
                               "Write {name}, or {{ for a brace");
      }
      named(argument.substr(i + 1, end - i - 1));
      i = end;
    } else if (c == '}') {
      throw text::InputError("The argument '" + argument + "' has a } without its {",
                             "Write {name}, or }} for a brace");
    } else {
      plain(c);
    }
  }
}

}  // namespace

std::vector<std::string> placeholders(const std::string& argument) {
  std::vector<std::string> names;
  walk(
      argument, [](char) {}, [&](const std::string& name) { names.push_back(name); });
  return names;
}

std::string file_safe(const std::string& text) {
  std::string safe = text;
  for (char& c : safe) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (!letter && (std::string_view("._+-").find(c) == std::string_view::npos)) c = '_';
  }
  return safe == text && !text.empty() ? safe : fmt::format("{}~{:016x}", safe, stable_hash(text));
}

bool matches(const std::string& pattern, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

Cases::Cases(const Description& description) : description_(description), size_(1) {
  for (const GridParameter& parameter : description.grid) size_ *= parameter.values.size();
  if (!description.sampled.empty()) size_ *= description.sample_count;
}

Case Cases::at(std::int64_t index) const {
  if (index < 0 || index >= size_) throw std::out_of_range("Cases::at");
  Case one;
  std::int64_t draw = 0;
  if (!description_.sampled.empty()) {
    draw = index % description_.sample_count;
    index /= description_.sample_count;
  }
  for (auto parameter = description_.grid.rbegin(); parameter != description_.grid.rend();
       ++parameter) {
    const std::int64_t size = parameter->values.size();
    one.values.emplace_back(parameter->name, parameter->values.at(index % size));
    index /= size;
  }
  std::reverse(one.values.begin(), one.values.end());
  for (const auto& [name, value] : one.values) {
    one.name += (one.name.empty() ? "" : ",") + name + "=" + file_safe(value);
  }
  if (!description_.sampled.empty()) {
    one.name += (one.name.empty() ? "" : ",") + fmt::format("sample={}", draw);
    for (const SampledParameter& parameter : description_.sampled) {
      one.values.emplace_back(parameter.name,
                              parameter.distribution.draw(description_.sample_seed, parameter.name,
                                                          static_cast<std::uint64_t>(draw)));
    }
  }
  if (one.name.size() > kLongestName) {
    one.name =
        fmt::format("{}~{:016x}", one.name.substr(0, kLongestName - 17), stable_hash(one.name));
  }
  return one;
}

std::vector<std::string> Cases::arguments(const Case& one,
                                          const std::filesystem::path& folder) const {
  std::vector<std::string> words;
  for (const std::string& argument : description_.arguments) {
    std::string& word = words.emplace_back();
    walk(
        argument, [&](char c) { word += c; },
        [&](const std::string& name) {
          if (name == "folder") {
            word += folder.string();
          } else if (name == "case") {
            word += one.name;
          } else {
            word += std::find_if(one.values.begin(), one.values.end(), [&](const auto& value) {
                      return value.first == name;
                    })->second;
          }
        });
  }
  return words;
}

}  // namespace prehend::sweep
