#pragma once

#include <stdexcept>
#include <string>

namespace prehend::text {

/// Bad input from outside (a file, a cloud, a parameter): one message that names the thing, the
/// place and the mend. Thrown by library code; nodes log it, publish a diagnostic and go on.
class InputError : public std::runtime_error {
 public:
  /// `thing` names the input and what is wrong with it, `mend` says what the user can do.
  /// what() is "thing. mend." in one line.
  InputError(const std::string& thing, const std::string& mend)
      : std::runtime_error(thing + ". " + mend + "."), problem_(thing) {}

  /// Without the mend.
  const std::string& problem() const { return problem_; }

 private:
  std::string problem_;
};

}  // namespace prehend::text
