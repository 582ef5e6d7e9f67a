#pragma once

#include "prehend/contact/shape.h"
#include "prehend/contact/texel_law.h"
#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// What pads feel of a body.
contact::Shape felt_shape(const EngineShape& shape);

/// The pad's law with the friction of the two bodies: of theirs the smaller is the static one, the
/// dynamic one keeps the law's ratio.
contact::TexelLaw mounted_law(const EnginePad& pad, const EngineBody& carrier,
                              const EngineBody& touched);

}  // namespace prehend::simulation::engines
