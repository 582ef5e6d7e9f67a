#pragma once

#include <charconv>
#include <string>

#include "prehend/geometry/errors.h"

// Reading the values of knobs, for the settings of a stage.
namespace prehend::fidelity {

/// Where the knobs of a subject are: those of a chain's own stages with the chain's.
inline std::string see_knobs(const std::string& subject) {
  const bool is_stage = subject == "seeing" || subject == "segmentation" || subject == "motion";
  return "See prehend/fidelity/" + (is_stage ? "chain" : subject) + "_settings.h";
}

/// @throws geometry::InputError: `knob` of a setting of `subject` cannot be `value`.
[[noreturn]] inline void refuse_knob(const std::string& subject, const std::string& knob,
                                     const std::string& value) {
  throw geometry::InputError(
      "The knob '" + knob + "' of a " + subject + " setting cannot be '" + value + "'",
      see_knobs(subject));
}

[[noreturn]] inline void unknown_knob(const std::string& subject, const std::string& knob) {
  throw geometry::InputError("'" + knob + "' is no knob of a " + subject + " setting",
                             see_knobs(subject));
}

template <typename Number>
Number knob_number(const std::string& subject, const std::string& knob, const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) refuse_knob(subject, knob, text);
  return value;
}

/// True for `yes`, false for `no`; another value is refused.
inline bool knob_is(const std::string& subject, const std::string& knob, const std::string& text,
                    const char* yes, const char* no) {
  if (text != yes && text != no) refuse_knob(subject, knob, text);
  return text == yes;
}

}  // namespace prehend::fidelity
