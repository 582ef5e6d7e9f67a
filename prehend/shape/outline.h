#pragma once

#include "prehend/geometry/image.h"

namespace prehend::shape {

/// Whether the mask touches the image's border: what it shows may go on beside the image.
bool reaches_border(const geometry::MaskImage& mask);

/// Share of the mask's outline that what is nearer cuts off, in [0, 1]. `nearer`: depth [m] of what
/// stands before the object, 0 elsewhere, of the mask's size.
double hidden_outline_share(const geometry::MaskImage& mask, const geometry::DepthImage& nearer);

}  // namespace prehend::shape
