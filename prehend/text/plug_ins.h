#pragma once

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "prehend/text/nearest_match.h"

// Things that are chosen by name, some of them in shared libraries that are found at run time.
namespace prehend::text {

/// A plug-in that is there but cannot be used, and why.
struct PlugInProblem {
  std::filesystem::path file;
  std::string reason;
};

/// Where plug-ins of a kind ("engine") are: the folders of the environment variable PREHEND_ENGINES
/// (separated by ':'), and then those that ship, ../lib/prehend/engines beside the running program.
std::vector<std::filesystem::path> plug_in_folders(const std::string& kind);

/// A loaded library, which is never closed: what was made by it may live as long as the program.
struct PlugIn {
  std::filesystem::path file;
  void* create = nullptr;  // its function prehend_create_KIND
};

/// Loads the shared libraries (*.so) of `folders`, in their order and by name in each, that export
/// `extern "C"` int prehend_KIND_interface(), equal to `interface`, and prehend_create_KIND().
/// Others are `problems`. A folder that is not there is empty.
std::vector<PlugIn> load_plug_ins(const std::string& kind, int interface,
                                  const std::vector<std::filesystem::path>& folders,
                                  std::vector<PlugInProblem>* problems);

/// Things with a name(), by name: those that are built in and those of plug-ins. The library's
/// function prehend_create_KIND gives a `new Thing`.
template <class Thing>
class NamedPlugIns {
 public:
  using Create = Thing* (*)();

  /// @param built_in found first. Of plug-ins of one name the first counts, the others are
  /// problems.
  NamedPlugIns(std::string kind, int interface, const std::vector<std::filesystem::path>& folders,
               std::vector<std::pair<std::string, Create>> built_in)
      : kind_(std::move(kind)), entries_(std::move(built_in)) {
    for (const PlugIn& plug_in : load_plug_ins(kind_, interface, folders, &problems_)) {
      const auto create = reinterpret_cast<Create>(plug_in.create);
      const std::unique_ptr<Thing> first(create());
      const std::string name = first ? first->name() : "";
      if (name.empty()) {
        problems_.push_back({plug_in.file, "makes nothing that has a name"});
        continue;
      }
      if (has(name)) {
        problems_.push_back({plug_in.file, "its name '" + name + "' is taken already"});
        continue;
      }
      entries_.emplace_back(name, create);
    }
    std::sort(entries_.begin(), entries_.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
  }

  std::vector<std::string> names() const {  // sorted
    std::vector<std::string> names;
    for (const auto& [name, create] : entries_) names.push_back(name);
    return names;
  }
  bool has(const std::string& name) const {
    return std::any_of(entries_.begin(), entries_.end(),
                       [&](const auto& entry) { return entry.first == name; });
  }
  /// @throws std::invalid_argument naming the nearest, all that there are, and those that cannot be
  /// used.
  Create find(const std::string& name) const {
    for (const auto& [known, create] : entries_) {
      if (known == name) return create;
    }
    std::string message = "there is no " + kind_ + " '" + name + "'";
    if (const auto nearest = nearest_match(name, names())) {
      message += "; the nearest is '" + *nearest + "'";
    }
    message += "; there are ";
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      message += (i == 0 ? "" : ", ") + entries_[i].first;
    }
    for (const PlugInProblem& problem : problems_) {
      message += "; " + problem.file.filename().string() + " cannot be used: " + problem.reason;
    }
    throw std::invalid_argument(message);
  }
  const std::vector<PlugInProblem>& problems() const { return problems_; }

 private:
  std::string kind_;
  std::vector<std::pair<std::string, Create>> entries_;
  std::vector<PlugInProblem> problems_;
};

}  // namespace prehend::text
