#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "prehend/simulation/engines/engine.h"
#include "prehend/text/plug_ins.h"

namespace prehend::simulation::engines {

/// Engines by name: `native`, and each plug-in (a shared library) in the folders of PREHEND_ENGINES
/// (separated by ':') and in ../lib/prehend/engines beside the running program; of two of one name
/// the first. An engine is added by putting its library there; nothing of prehend is built again.
class EngineRegistry {
 public:
  /// Looks for plug-ins where text::plug_in_folders() says.
  EngineRegistry();
  explicit EngineRegistry(const std::vector<std::filesystem::path>& folders);

  std::vector<std::string> names() const { return engines_.names(); }  // sorted
  bool has(const std::string& name) const { return engines_.has(name); }
  /// @throws std::invalid_argument naming the known engines.
  std::unique_ptr<Engine> create(const std::string& name) const;
  const std::vector<text::PlugInProblem>& problems() const { return engines_.problems(); }

 private:
  text::NamedPlugIns<Engine> engines_;
};

}  // namespace prehend::simulation::engines
