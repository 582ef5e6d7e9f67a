// Compiled once for each instruction set by Highway's foreach_target.h, which includes it again.
#include "prehend/motion/nearest_kernel.h"

#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/motion/nearest_kernel.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prehend::motion::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::size_t nearest_point(const float* blocks, std::size_t count, const float* q,
                          std::size_t joints) {
  const hn::CappedTag<float, kBatch> d;
  const hn::RebindToSigned<decltype(d)> di;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  // One part of all blocks at a time; the best of each lane first.
  for (std::size_t part = 0; part < kBatch; part += lanes) {
    auto nearest = hn::Set(d, least);
    auto index = hn::Set(di, -1);
    for (std::size_t first = 0; first < count; first += kBatch) {
      const float* block = blocks + first * joints + part;
      auto sum = hn::Zero(d);
      for (std::size_t j = 0; j < joints; ++j) {
        const auto way = hn::Sub(hn::LoadU(d, block + j * kBatch), hn::Set(d, q[j]));
        sum = hn::MulAdd(way, way, sum);
      }
      const auto nearer = hn::Lt(sum, nearest);
      nearest = hn::IfThenElse(nearer, sum, nearest);
      index = hn::IfThenElse(hn::RebindMask(di, nearer),
                             hn::Set(di, static_cast<std::int32_t>(first)), index);
    }
    float distances[kBatch];
    std::int32_t firsts[kBatch];
    hn::StoreU(nearest, d, distances);
    hn::StoreU(index, di, firsts);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const std::size_t point = static_cast<std::size_t>(firsts[lane]) + part + lane;
      if (firsts[lane] < 0 ||
          !(distances[lane] < least || (distances[lane] == least && point < best))) {
        continue;
      }
      least = distances[lane];
      best = point;
    }
  }
  return best;
}

}  // namespace prehend::motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::motion {
namespace {

HWY_EXPORT(nearest_point);

}  // namespace

std::size_t nearest_point(const float* blocks, std::size_t count, const float* q,
                          std::size_t joints) {
  return HWY_DYNAMIC_DISPATCH(nearest_point)(blocks, count, q, joints);
}

}  // namespace prehend::motion
#endif
