#include "prehend/text/knob.h"

#include <fmt/format.h>

namespace prehend::text {

std::string range_text(double least, double most, std::string_view unit) {
  return fmt::format("within {:g} and {:g}{}{}", least, most, unit.empty() ? "" : " ", unit);
}

}  // namespace prehend::text
