#pragma once

#include "prehend/text/input_error.h"

namespace prehend::geometry {

/// The algorithms' error of bad input; see there.
using text::InputError;

}  // namespace prehend::geometry
