#include "prehend/fidelity/shape_settings.h"

#include <charconv>
#include <optional>
#include <string>

namespace prehend::fidelity {
namespace {

using geometry::InputError;

[[noreturn]] void refuse(const std::string& knob, const std::string& value) {
  throw InputError("The knob '" + knob + "' of a shape setting cannot be '" + value + "'",
                   "See prehend/fidelity/shape_settings.h");
}

template <typename Number>
Number number(const std::string& knob, const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) refuse(knob, text);
  return value;
}

bool one_of(const std::string& knob, const std::string& text, const char* yes, const char* no) {
  if (text != yes && text != no) refuse(knob, text);
  return text == yes;
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
    } else if (knob == "refine") {
      options.completion.refine = one_of(knob, value, "yes", "no");
    } else if (knob == "spacing") {
      options.model.cloud.spacing = number<double>(knob, value);
    } else if (knob == "surface") {
      options.model.surface.method = one_of(knob, value, "fast", "pcl")
                                         ? surface::SurfaceMethod::kFastPoisson
                                         : surface::SurfaceMethod::kPclPoisson;
    } else if (knob == "resolution") {
      resolution = number<int>(knob, value);
    } else {
      throw InputError("'" + knob + "' is no knob of a shape setting",
                       "See prehend/fidelity/shape_settings.h");
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
