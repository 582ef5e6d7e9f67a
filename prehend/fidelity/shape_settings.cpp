#include "prehend/fidelity/shape_settings.h"

#include <optional>
#include <string>

#include "prehend/fidelity/knobs.h"

namespace prehend::fidelity {
namespace {

constexpr const char* kShapeSubject = "shape";

template <typename Number>
Number number(const std::string& knob, const std::string& text) {
  return knob_number<Number>(kShapeSubject, knob, text);
}

bool one_of(const std::string& knob, const std::string& text, const char* yes, const char* no) {
  return knob_is(kShapeSubject, knob, text, yes, no);
}

}  // namespace

ShapeOptions shape_options(const Setting& setting) {
  ShapeOptions options;
  std::optional<int> resolution;
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "thinning") {
      options.completion.thinning = number<double>(knob, value);
    } else if (knob == "orientations") {
      options.completion.orientations = number<int>(knob, value);
    } else if (knob == "shifts") {
      options.completion.shifts = number<int>(knob, value);
    } else if (knob == "alternatives") {
      options.completion.alternatives = number<int>(knob, value);
    } else if (knob == "refine") {
      options.completion.refine = one_of(knob, value, "yes", "no");
    } else if (knob == "spacing") {
      options.model.cloud.spacing = number<double>(knob, value);
    } else if (knob == "surface") {
      options.model.surface.method = one_of(knob, value, "fast", "pcl")
                                         ? surface::SurfaceMethod::kFastPoisson
                                         : surface::SurfaceMethod::kPclPoisson;
    } else if (knob == "pieces") {
      options.model.convex_pieces.concavity = number<double>(knob, value);
    } else if (knob == "resolution") {
      resolution = number<int>(knob, value);
    } else {
      unknown_knob(kShapeSubject, knob);
    }
  }
  if (resolution) {
    if (options.model.surface.method == surface::SurfaceMethod::kFastPoisson) {
      options.model.surface.fast_poisson.resolution = *resolution;
    } else {
      options.model.surface.pcl_poisson.depth = *resolution;
    }
  }
  return options;
}

}  // namespace prehend::fidelity
