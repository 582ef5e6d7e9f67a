#include "prehend/belief/load_belief.h"

#include <cmath>

#include <fmt/format.h>

#include "prehend/geometry/gravity.h"
#include "prehend/text/require.h"

namespace prehend::belief {
namespace {

using grasp::Interval;

void check_load(const LoadEvidence& one) {
  const text::Require require{"LoadEvidence."};
  const auto positive = [&](const std::optional<double>& value, const char* what) {
    require(!value || (std::isfinite(*value) && *value >= 0), what);
  };
  positive(one.weight, "weight must be finite and not negative");
  positive(one.weight_deviation, "weight_deviation must be finite and not negative");
  positive(one.held_share, "held_share must be finite and not negative");
  positive(one.slipped_share, "slipped_share must be finite and not negative");
  positive(one.borne, "borne must be finite and not negative");
}

std::string interval_in_words(const Interval& interval) {
  if (!std::isfinite(interval.high)) return fmt::format("at least {:.2g}", interval.low);
  if (!(interval.low > 0)) return fmt::format("at most {:.2g}", interval.high);
  return fmt::format("{:.2g} to {:.2g}", interval.low, interval.high);
}

}  // namespace

void LoadBeliefOptions::validate() const {
  const text::Require require{"LoadBeliefOptions."};
  require(std::isfinite(weight_resolution) && weight_resolution >= 0,
          "weight_resolution must not be negative");
  require(std::isfinite(significance) && significance > 0, "significance must be positive");
  require(std::isfinite(pad_gain) && pad_gain >= 0 && pad_gain < 1,
          "pad_gain must be from 0 to below 1");
  require(std::isfinite(acceleration) && acceleration >= 0, "acceleration must not be negative");
}

LoadBelief load_belief(const std::vector<LoadEvidence>& evidence,
                       const LoadBeliefOptions& options) {
  options.validate();
  Interval mass, friction;
  for (const LoadEvidence& one : evidence) {
    check_load(one);
    if (one.weight) {
      const double off = options.significance * one.weight_deviation + options.weight_resolution;
      mass = mass.narrowed({std::max(0.0, *one.weight - off) / geometry::kGravity,
                            (*one.weight + off) / geometry::kGravity});
    }
    if (one.borne) {
      const double least = (1 - options.pad_gain) * *one.borne - options.weight_resolution;
      mass.low =
          std::max(mass.low, std::max(0.0, least) / (geometry::kGravity + options.acceleration));
    }
    if (one.held_share)
      friction.low = std::max(friction.low, *one.held_share / (1 + options.pad_gain));
    if (one.slipped_share) {
      friction.high = std::min(friction.high, *one.slipped_share * (1 + options.pad_gain));
    }
  }
  LoadBelief belief;
  if (mass.is_empty()) {
    belief.contradiction =
        fmt::format("what it weighed contradicts itself (at least {:.2g} kg and at most {:.2g} kg)",
                    mass.low, mass.high);
  } else if (friction.is_empty()) {
    belief.contradiction = fmt::format(
        "how it held and slipped contradicts itself (a friction of at least {:.2g} and at most "
        "{:.2g})",
        friction.low, friction.high);
  } else {
    belief.bounds = {mass, friction};
  }
  return belief;
}

std::string in_words(const grasp::LoadBounds& bounds) {
  std::string words;
  if (bounds.mass.is_known()) words = interval_in_words(bounds.mass) + " kg";
  if (bounds.friction.is_known()) {
    words += (words.empty() ? "friction " : ", friction ") + interval_in_words(bounds.friction);
  }
  return words;
}

}  // namespace prehend::belief
