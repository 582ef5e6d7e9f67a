#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>

#include <Eigen/Core>

namespace prehend::surface {

/// Single-precision numbers on the nodes of a dense grid, x fastest. A row holds `pitch` numbers,
/// of which the first size.x() are nodes: the two more are what an in-place real transform needs.
class ScalarGrid {
 public:
  ScalarGrid() = default;
  /// Nodes along x, y, z, each >= 1. The numbers are not set.
  explicit ScalarGrid(const Eigen::Vector3i& size)
      : size_(size),
        pitch_(2 * (size.x() / 2 + 1)),
        values_(static_cast<float*>(std::aligned_alloc(64, (bytes() + 63) / 64 * 64))) {
    if (!values_) throw std::bad_alloc();
  }

  const Eigen::Vector3i& size() const { return size_; }
  int pitch() const { return pitch_; }
  std::ptrdiff_t slab() const { return static_cast<std::ptrdiff_t>(pitch_) * size_.y(); }
  std::size_t count() const { return static_cast<std::size_t>(slab()) * size_.z(); }
  std::ptrdiff_t index(int x, int y, int z) const { return z * slab() + y * pitch_ + x; }

  float* data() { return values_.get(); }
  const float* data() const { return values_.get(); }
  float& at(int x, int y, int z) { return values_[index(x, y, z)]; }
  float at(int x, int y, int z) const { return values_[index(x, y, z)]; }
  void fill(float value) { std::fill(data(), data() + count(), value); }

 private:
  struct Free {
    void operator()(float* memory) const { std::free(memory); }
  };
  std::size_t bytes() const { return count() * sizeof(float); }

  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  int pitch_ = 0;
  std::unique_ptr<float[], Free> values_;
};

}  // namespace prehend::surface
