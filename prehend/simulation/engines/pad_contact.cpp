#include "prehend/simulation/engines/pad_contact.h"

#include <algorithm>

namespace prehend::simulation::engines {

contact::Shape felt_shape(const EngineShape& shape) {
  switch (shape.kind) {
    case EngineShape::Kind::kBox:
      return contact::Shape::box(shape.size);
    case EngineShape::Kind::kSphere:
      return contact::Shape::sphere(shape.radius);
    case EngineShape::Kind::kCylinder:
      return contact::Shape::cylinder(shape.radius, shape.length);
    case EngineShape::Kind::kCapsule:
      return contact::Shape::capsule(shape.radius, shape.length);
  }
  throw std::logic_error("an EngineShape of no kind");
}

contact::TexelLaw mounted_law(const EnginePad& pad, const EngineBody& carrier,
                              const EngineBody& touched) {
  contact::TexelLaw law = pad.law;
  const double friction = std::min(carrier.friction, touched.friction);
  const double ratio = law.static_friction > 0 ? law.dynamic_friction / law.static_friction : 1.0;
  law.static_friction = friction;
  law.dynamic_friction = ratio * friction;
  return law;
}

}  // namespace prehend::simulation::engines
