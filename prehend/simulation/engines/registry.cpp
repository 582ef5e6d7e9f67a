#include "prehend/simulation/engines/registry.h"

#include "prehend/simulation/engines/native_engine.h"
#include "prehend/simulation/engines/substepped_pads.h"

namespace prehend::simulation::engines {
namespace {

Engine* create_native() { return std::make_unique<NativeEngine>().release(); }

}  // namespace

EngineRegistry::EngineRegistry() : EngineRegistry(text::plug_in_folders("engine")) {}

EngineRegistry::EngineRegistry(const std::vector<std::filesystem::path>& folders)
    : engines_("engine", kEngineInterface, folders, {{"native", create_native}}) {}

std::unique_ptr<Engine> EngineRegistry::create(const std::string& name) const {
  const auto create = engines_.find(name);
  std::unique_ptr<Engine> engine(create());
  // `native` couples pads itself.
  if (create == create_native) return engine;
  return std::make_unique<SubsteppedPads>(std::move(engine));
}

}  // namespace prehend::simulation::engines
