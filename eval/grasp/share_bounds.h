#pragma once

#include <string>

namespace prehend::eval {

/// 95 % interval of a share, after Wilson ("Probable inference, the law of succession, and
/// statistical inference", 1927), as if trials had nothing to do with one another.
struct ShareBounds {
  double low = 0, high = 1;
};
/// @pre 0 <= held <= tried; of none tried it is anything.
ShareBounds share_bounds(int held, int tried);

/// "81.5 to 90.2", in percent.
std::string to_string(const ShareBounds& bounds);

}  // namespace prehend::eval
