#include "prehend/simulation/engines/native_engine.h"

#include "prehend/simulation/engines/grasp_engine.h"
#include "prehend/simulation/engines/multibody_engine.h"

namespace prehend::simulation::engines {

NativeEngine::NativeEngine() : engine_(std::make_unique<GraspEngine>()) {}

void NativeEngine::load(const EngineScene& scene) {
  if (GraspEngine::why_not(scene).empty()) {
    engine_ = std::make_unique<GraspEngine>();
  } else {
    engine_ = std::make_unique<MultibodyEngine>();
  }
  engine_->load(scene);
}

}  // namespace prehend::simulation::engines
