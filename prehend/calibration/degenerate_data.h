#pragma once

#include <string>

#include "prehend/geometry/errors.h"

namespace prehend::calibration {

/// Data from which the unknowns do not follow, however exact they are. The degeneracy has a name
/// ("all views parallel"), with which what() begins.
class DegenerateData : public geometry::InputError {
 public:
  /// what() is "name: detail. mend."
  DegenerateData(const std::string& name, const std::string& detail, const std::string& mend)
      : geometry::InputError(name + ": " + detail, mend), name_(name) {}

  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

}  // namespace prehend::calibration
