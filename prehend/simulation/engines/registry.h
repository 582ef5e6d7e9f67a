#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// A plug-in that is there but cannot be used, and why.
struct EngineProblem {
  std::filesystem::path file;
  std::string reason;
};

/// Engines by name: `native`, and each plug-in (a shared library) in the folders of PREHEND_ENGINES
/// (separated by ':') or else in ../lib/prehend/engines beside the running program. An engine is
/// added by putting its library there; nothing of prehend is built again.
class EngineRegistry {
 public:
  /// Looks for plug-ins in engine_folders().
  EngineRegistry();
  explicit EngineRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const;  // sorted
  bool has(const std::string& name) const;
  /// @throws std::invalid_argument naming the known engines.
  std::unique_ptr<Engine> create(const std::string& name) const;
  const std::vector<EngineProblem>& problems() const { return problems_; }

 private:
  struct Entry {
    std::string name;
    Engine* (*create)();
  };
  std::vector<Entry> entries_;
  std::vector<EngineProblem> problems_;
};

/// See EngineRegistry.
std::vector<std::filesystem::path> engine_folders();

}  // namespace prehend::simulation::engines
