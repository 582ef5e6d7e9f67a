#pragma once

#include <string>

namespace prehend::text {

/// Two numbers of one sentence that compares them.
struct NumberPair {
  std::string first, second;
};

/// Both with `digits` digits after the point, or with as many more as it takes for them to read
/// differently: "30.0" and "66.0", "30.02" and "30.00". Numbers that are equal to 12 digits after
/// the point read alike.
NumberPair told_apart(double first, double second, int digits);

}  // namespace prehend::text
