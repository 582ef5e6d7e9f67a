#pragma once

#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// Replaces `grid`, a right-hand side f, by the u of mean 0 with L u = f - mean(f), L the
/// seven-point Laplacian for spacing 1 on the grid continued periodically. By a fast Fourier
/// transform (FFTW), divided by L's eigenvalues sum_axis 2 cos(2 pi k / n) - 2. O(n log n) for n
/// nodes; the same input gives the same bits on the same machine.
/// @pre grid's sizes are even.
void solve_poisson(ScalarGrid& grid);

}  // namespace prehend::surface
