#pragma once

#include "prehend/geometry/image.h"

namespace prehend::shape {

/// `mask` with its holes filled: connected regions (4 neighbours) of pixels outside it that do not
/// reach the image's border and are no larger than `largest` times the mask's area.
geometry::MaskImage with_holes_filled(const geometry::MaskImage& mask, double largest);

}  // namespace prehend::shape
