#include "prehend/shape/completion_options.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace prehend::shape {

using std::numbers::pi;

void check(const CompletionOptions& options) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("CompletionOptions." + what);
  };
  require(options.orientations >= 1 && options.orientations % 2 == 1,
          "orientations must be odd and >= 1");
  require(options.max_angle > 0 && options.max_angle <= pi / 2, "max_angle must be in (0, pi/2]");
  require(options.shifts >= 2, "shifts must be >= 2");
  require(std::isfinite(options.min_shift) && options.min_shift < options.max_shift &&
              std::isfinite(options.max_shift),
          "min_shift must be less than max_shift");
  require(options.thinning >= 0 && options.thinning <= 0.2, "thinning must be in [0, 0.2]");
  require(options.planes >= 1, "planes must be >= 1");
  require(options.alternatives >= 0, "alternatives must be >= 0");
  require(options.max_tilt >= 0 && options.max_tilt <= pi / 4, "max_tilt must be in [0, pi/4]");
  require(options.reference_fraction > 0 && std::isfinite(options.reference_fraction),
          "reference_fraction must be > 0");
  require(options.depth_tolerance > 0 && std::isfinite(options.depth_tolerance),
          "depth_tolerance must be > 0");
  require(options.fill_holes >= 0 && options.fill_holes <= 1, "fill_holes must be in [0, 1]");
  require(options.max_contradicted >= 0 && options.max_contradicted <= 1,
          "max_contradicted must be in [0, 1]");
  require(options.min_support >= 0 && options.min_support <= 1, "min_support must be in [0, 1]");
  for (const auto& [value, name] : {std::pair{options.outside_weight, "outside_weight"},
                                    {options.in_front_weight, "in_front_weight"},
                                    {options.support_weight, "support_weight"},
                                    {options.oblique_weight, "oblique_weight"},
                                    {options.depth_prior_weight, "depth_prior_weight"},
                                    {options.tilt_gain, "tilt_gain"},
                                    {options.max_second_vote, "max_second_vote"},
                                    {options.alternative_vote, "alternative_vote"}}) {
    require(value >= 0 && std::isfinite(value), std::string(name) + " must be >= 0");
  }
}

CompletionOptions as_published() {
  CompletionOptions options;
  options.vote = VoteKind::kPublished;
  options.published_start = true;
  options.orientations = 7;
  options.shifts = 5;
  options.max_angle = pi / 9;
  options.thinning = 0;
  options.refine = false;
  options.max_tilt = 0;
  options.planes = 1;
  options.second_plane = false;
  options.drop_contradicted = false;
  options.fill_holes = 0;
  options.max_contradicted = 1;
  options.min_support = 0;
  return options;
}

}  // namespace prehend::shape
