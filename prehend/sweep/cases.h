#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "prehend/sweep/description.h"

namespace prehend::sweep {

/// One run of the program.
struct Case {
  std::string name;  // "object=mug,seed=3,sample=7": stable, unique, a file's name
  std::vector<std::pair<std::string, std::string>> values;  // of each parameter
};

/// The cases of a description, made when they are asked for.
class Cases {
 public:
  /// `description` must outlive it.
  explicit Cases(const Description& description);

  std::int64_t size() const { return size_; }
  /// @pre 0 <= index < size()
  Case at(std::int64_t index) const;
  /// Its program's arguments; `folder` is the case's own.
  std::vector<std::string> arguments(const Case& one, const std::filesystem::path& folder) const;

 private:
  const Description& description_;
  std::int64_t size_ = 0;
};

/// The names in braces of an argument. @throws InputError for a brace without its partner.
std::vector<std::string> placeholders(const std::string& argument);

/// Characters that are safe in files' names stay; others become '_', with a hash of `text` behind.
std::string file_safe(const std::string& text);

/// Whether `name` is what `pattern` says: * any characters, ? any one, [abc] one of them.
bool matches(const std::string& pattern, const std::string& name);

}  // namespace prehend::sweep
