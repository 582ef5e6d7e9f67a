#include "prehend/surface/band.h"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace prehend::surface {
namespace {

/// One bit for each node.
class NodeSet {
 public:
  explicit NodeSet(const Eigen::Vector3i& size)
      : size_(size),
        words_((size.x() + 63) / 64),
        bits_(static_cast<std::size_t>(words_) * size.y() * size.z()) {}

  std::uint64_t* row(int y, int z) {
    return bits_.data() + (static_cast<std::size_t>(z) * size_.y() + y) * words_;
  }
  void set(int x, int y, int z) { row(y, z)[x / 64] |= std::uint64_t{1} << x % 64; }

  /// Adds the neighbours along x.
  void widen_rows() {
    for (std::size_t start = 0; start < bits_.size(); start += words_) {
      std::uint64_t* word = bits_.data() + start;
      std::uint64_t before = 0;
      for (int i = 0; i < words_; ++i) {
        const std::uint64_t here = word[i];
        const std::uint64_t after = i + 1 < words_ ? word[i + 1] : 0;
        word[i] = here | here << 1 | here >> 1 | before >> 63 | after << 63;
        before = here;
      }
    }
  }

  /// Adds the neighbours `step` words away within blocks of `block` words.
  void widen(std::size_t step, std::size_t block) {
    std::vector<std::uint64_t> wider = bits_;
    for (std::size_t start = 0; start < bits_.size(); start += block) {
      for (std::size_t i = start + step; i < start + block; ++i) {
        wider[i] |= bits_[i - step];
        wider[i - step] |= bits_[i];
      }
    }
    bits_.swap(wider);
  }

  void widen_all() {
    widen_rows();
    widen(words_, static_cast<std::size_t>(words_) * size_.y());
    widen(static_cast<std::size_t>(words_) * size_.y(), bits_.size());
  }

  bool contains(int x, int y, int z) { return (row(y, z)[x / 64] >> x % 64 & 1) != 0; }

 private:
  Eigen::Vector3i size_;
  int words_;  // of a row
  std::vector<std::uint64_t> bits_;
};

}  // namespace

std::vector<NodeRun> band_about(const std::vector<Eigen::Vector3f>& points,
                                const Eigen::Vector3i& size, int reach) {
  NodeSet nodes(size);
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3i cell = p.cast<int>();
    for (int corner = 0; corner < 8; ++corner) {
      nodes.set(cell.x() + (corner & 1), cell.y() + (corner >> 1 & 1), cell.z() + (corner >> 2));
    }
  }
  for (int i = 0; i < reach; ++i) nodes.widen_all();
  std::vector<NodeRun> runs;
  for (int z = 1; z + 1 < size.z(); ++z) {
    for (int y = 1; y + 1 < size.y(); ++y) {
      for (int x = 1; x + 1 < size.x();) {
        const std::uint64_t rest = nodes.row(y, z)[x / 64] >> x % 64;
        if (rest == 0) {
          x += 64 - x % 64;
          continue;
        }
        x += std::countr_zero(rest);
        const int begin = x;
        while (x + 1 < size.x() && nodes.contains(x, y, z)) ++x;
        if (x > begin) runs.push_back({begin, y, z, x - begin});
        if (x == begin) break;  // only the border is left
      }
    }
  }
  return runs;
}

}  // namespace prehend::surface
