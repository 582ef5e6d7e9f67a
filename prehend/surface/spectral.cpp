#include "prehend/surface/spectral.h"

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <stdexcept>
#include <vector>

#include <fftw3.h>

namespace prehend::surface {
namespace {

struct Plans {
  fftwf_plan forward = nullptr;
  fftwf_plan backward = nullptr;

  Plans() = default;
  Plans(const Plans&) = delete;
  Plans& operator=(const Plans&) = delete;
  ~Plans() {
    if (forward != nullptr) fftwf_destroy_plan(forward);
    if (backward != nullptr) fftwf_destroy_plan(backward);
  }
};

/// In-place plans for a size, kept for the process. Planning is not thread-safe, running is.
const Plans& plans_for(ScalarGrid& grid) {
  static std::mutex mutex;
  static std::map<std::array<int, 3>, Plans> known;
  const Eigen::Vector3i& n = grid.size();
  const std::lock_guard lock(mutex);
  Plans& plans = known[{n.x(), n.y(), n.z()}];
  if (plans.forward == nullptr) {
    auto* complex = reinterpret_cast<fftwf_complex*>(grid.data());
    // An estimate, not a measurement: the choice of algorithm decides over the last bits.
    plans.forward = fftwf_plan_dft_r2c_3d(n.z(), n.y(), n.x(), grid.data(), complex, FFTW_ESTIMATE);
    plans.backward =
        fftwf_plan_dft_c2r_3d(n.z(), n.y(), n.x(), complex, grid.data(), FFTW_ESTIMATE);
  }
  if (plans.forward == nullptr || plans.backward == nullptr) {
    throw std::runtime_error("FFTW could not plan a transform");
  }
  return plans;
}

float eigenvalue(int k, int n) {
  return static_cast<float>(2 * std::cos(2 * EIGEN_PI * k / n) - 2);
}

std::vector<float> eigenvalues(int n) {
  std::vector<float> values(n);
  for (int k = 0; k < n; ++k) values[k] = eigenvalue(k, n);
  return values;
}

}  // namespace

void solve_poisson(ScalarGrid& grid) {
  const Plans& plans = plans_for(grid);
  const Eigen::Vector3i& n = grid.size();
  auto* spectrum = reinterpret_cast<fftwf_complex*>(grid.data());
  fftwf_execute_dft_r2c(plans.forward, grid.data(), spectrum);
  std::vector<float> along_x(grid.pitch());
  for (int i = 0; i < grid.pitch(); ++i) along_x[i] = eigenvalue(i / 2, n.x());
  const std::vector<float> along_y = eigenvalues(n.y());
  const std::vector<float> along_z = eigenvalues(n.z());
  const float scale = 1.f / (static_cast<float>(n.x()) * n.y() * n.z());
  std::vector<float> factors(grid.pitch());
  for (int z = 0; z < n.z(); ++z) {
    for (int y = 0; y < n.y(); ++y) {
      const float sum = along_y[y] + along_z[z];
      // Twice each, for the real and the imaginary part.
      for (int i = 0; i < grid.pitch(); ++i) factors[i] = scale / (along_x[i] + sum);
      float* row = &grid.at(0, y, z);
      for (int i = 0; i < grid.pitch(); ++i) row[i] *= factors[i];
    }
  }
  grid.data()[0] = 0;  // the mean
  grid.data()[1] = 0;
  fftwf_execute_dft_c2r(plans.backward, spectrum, grid.data());
}

}  // namespace prehend::surface
