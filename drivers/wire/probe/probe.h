#pragma once

#include <string>

namespace prehend::drivers {

/// What asking a device showed. Asking never moves hardware, changes no setting and, where the
/// device talks already (somebody uses it), sends nothing at all.
struct Probe {
  enum class Result {
    kAnswers,  ///< it is there and fit for use
    kWarns,    ///< it is there, but something has to be done before use
    kSilent,   ///< it does not answer, or something else does
  };
  Result result = Result::kSilent;
  std::string what;  ///< one line
  std::string mend;  ///< what to do; empty when it answers
};

}  // namespace prehend::drivers
