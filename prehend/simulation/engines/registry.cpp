#include "prehend/simulation/engines/registry.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include <dlfcn.h>

#include "prehend/simulation/engines/native_engine.h"
#include "prehend/simulation/engines/substepped_pads.h"

namespace prehend::simulation::engines {
namespace {

Engine* create_native() { return std::make_unique<NativeEngine>().release(); }

}  // namespace

std::vector<std::filesystem::path> engine_folders() {
  std::vector<std::filesystem::path> folders;
  if (const char* variable = std::getenv("PREHEND_ENGINES")) {
    std::istringstream list(variable);
    for (std::string folder; std::getline(list, folder, ':');) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
    return folders;
  }
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) folders.push_back(program.parent_path().parent_path() / "lib/prehend/engines");
  return folders;
}

EngineRegistry::EngineRegistry() : EngineRegistry(engine_folders()) {}

EngineRegistry::EngineRegistry(const std::vector<std::filesystem::path>& folders) {
  entries_.push_back({"native", create_native});
  std::vector<std::filesystem::path> files;
  for (const auto& folder : folders) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".so") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    // Never closed: engines made by it may live as long as the program.
    void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      problems_.push_back({file, dlerror()});
      continue;
    }
    const auto interface = reinterpret_cast<int (*)()>(dlsym(library, "prehend_engine_interface"));
    const auto create = reinterpret_cast<Engine* (*)()>(dlsym(library, "prehend_create_engine"));
    if (!interface || !create) {
      problems_.push_back({file, "exports no prehend_engine_interface and prehend_create_engine"});
      continue;
    }
    if (interface() != kEngineInterface) {
      problems_.push_back({file, "is built for interface " + std::to_string(interface()) +
                                     ", this prehend has " + std::to_string(kEngineInterface)});
      continue;
    }
    const std::string name = std::unique_ptr<Engine>(create())->name();
    if (has(name)) {
      problems_.push_back({file, "there is an engine '" + name + "' already"});
      continue;
    }
    entries_.push_back({name, create});
  }
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return a.name < b.name; });
}

std::vector<std::string> EngineRegistry::names() const {
  std::vector<std::string> names;
  for (const Entry& entry : entries_) names.push_back(entry.name);
  return names;
}

bool EngineRegistry::has(const std::string& name) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const Entry& entry) { return entry.name == name; });
}

std::unique_ptr<Engine> EngineRegistry::create(const std::string& name) const {
  for (const Entry& entry : entries_) {
    if (entry.name != name) continue;
    std::unique_ptr<Engine> engine(entry.create());
    // `native` couples pads itself.
    if (entry.create == create_native) return engine;
    return std::make_unique<SubsteppedPads>(std::move(engine));
  }
  std::string known;
  for (const Entry& entry : entries_) known += (known.empty() ? "" : ", ") + entry.name;
  std::string message = "there is no engine '" + name + "'; there are " + known;
  for (const EngineProblem& problem : problems_) {
    message += "; " + problem.file.filename().string() + " cannot be used: " + problem.reason;
  }
  throw std::invalid_argument(message);
}

}  // namespace prehend::simulation::engines
