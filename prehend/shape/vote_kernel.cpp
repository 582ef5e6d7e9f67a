// Compiled once for each instruction set by Highway's foreach_target.h, which includes it again.
#include "prehend/shape/vote_kernel.h"

#include <algorithm>

#include "prehend/shape/vote.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/shape/vote_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prehend::shape {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::ScalableTag<float>;
using Float = hn::Vec<Floats>;
using Ints = hn::RebindToSigned<Floats>;

// Few enough that single precision sums them to 1e-6, and that three arrays stay in the first
// cache.
constexpr std::size_t kBlock = 1024;

struct Lanes {
  Float outside_points, outside_pixels, nearer_points, nearer;
  Float outside_squared, in_front, coincident, contradicted, hidden, unseen;
};

HWY_INLINE void add_points(const KernelInput& in, const KernelPlane& plane, std::size_t i,
                           hn::Mask<Floats> valid, Lanes& sum) {
  const Floats d;
  const Ints di;
  const Float zero = hn::Zero(d), one = hn::Set(d, 1.f), half = hn::Set(d, 0.5f);
  const Float a = hn::LoadU(d, in.a + i), b = hn::LoadU(d, in.b + i), c = hn::LoadU(d, in.c + i);
  const Float motion =
      hn::MulAdd(hn::Set(d, plane.motion_a), a,
                 hn::MulAdd(hn::Set(d, plane.motion_b), b,
                            hn::MulAdd(hn::Set(d, plane.motion_c), c, hn::Set(d, plane.motion_0))));
  const Float mirrored_a = hn::MulAdd(motion, hn::Set(d, plane.normal_a), a);
  const Float mirrored_b = hn::MulAdd(motion, hn::Set(d, plane.normal_b), b);
  const Float depth =
      hn::Add(hn::MulAdd(motion, hn::Set(d, plane.normal_c), c), hn::Set(d, in.depth_center));
  const hn::Mask<Floats> before_camera = hn::And(valid, hn::Gt(depth, zero));
  // Behind the camera the quotient is of no use, but must stay a number.
  const Float inverse = hn::Div(one, hn::IfThenElse(before_camera, depth, one));
  // The upper left of the ring is 0; truncation rounds, because a half has been added.
  const Float u = hn::Min(hn::Max(hn::MulAdd(mirrored_a, inverse, hn::Set(d, in.center_u)), zero),
                          hn::Set(d, in.last_u));
  const Float v = hn::Min(hn::Max(hn::MulAdd(mirrored_b, inverse, hn::Set(d, in.center_v)), zero),
                          hn::Set(d, in.last_v));
  const auto index =
      hn::Add(hn::Mul(hn::ConvertTo(di, v), hn::Set(di, in.stride)), hn::ConvertTo(di, u));
  const Float value = hn::IfThenElseZero(before_camera, hn::GatherIndex(d, in.map, index));

  const hn::Mask<Floats> inside = hn::Gt(value, zero);
  const Float pixels = hn::Max(hn::Sub(zero, value), zero);
  const Float outside = hn::Mul(hn::Mul(pixels, depth), hn::Set(d, in.inverse_focal_length));
  const Float tolerance = hn::Set(d, in.depth_tolerance);
  const Float per_tolerance = hn::Set(d, 1.f / in.depth_tolerance);
  const Float before = hn::IfThenElseZero(inside, hn::Sub(value, depth));
  const Float relative = hn::Mul(hn::Add(before, hn::Add(outside, outside)), per_tolerance);
  const Float near_surface = hn::Max(hn::NegMulAdd(hn::Abs(before), per_tolerance, one), zero);
  const hn::Mask<Floats> moved =
      hn::And(inside, hn::Gt(hn::Abs(motion), hn::Set(d, in.least_motion)));

  const hn::Mask<Floats> beside = hn::Lt(value, zero);
  const Float distance = hn::IfThenElseZero(beside, hn::Add(pixels, half));
  const hn::Mask<Floats> nearer = hn::Gt(before, hn::Set(d, static_cast<float>(kNearer)));
  sum.outside_points = hn::Add(sum.outside_points, hn::IfThenElseZero(beside, one));
  sum.outside_pixels = hn::MulAdd(distance, distance, sum.outside_pixels);
  sum.nearer_points = hn::Add(sum.nearer_points, hn::IfThenElseZero(nearer, one));
  sum.nearer = hn::Add(sum.nearer, hn::IfThenElseZero(nearer, before));
  sum.outside_squared = hn::MulAdd(outside, outside, sum.outside_squared);
  sum.in_front = hn::Add(sum.in_front, hn::Max(hn::Sub(before, tolerance), zero));
  sum.coincident = hn::Add(sum.coincident, hn::IfThenElseZero(moved, near_surface));
  sum.contradicted =
      hn::Add(sum.contradicted, hn::Min(hn::Max(hn::Sub(relative, half), zero), one));
  sum.hidden = hn::Add(sum.hidden, hn::IfThenElseZero(hn::Lt(before, hn::Neg(tolerance)), one));
  sum.unseen = hn::Add(sum.unseen, hn::IfThenElseZero(hn::And(valid, hn::Eq(value, zero)), one));
}

HWY_INLINE double total(Float lanes) {
  const Floats d;
  HWY_ALIGN float values[HWY_MAX_BYTES / sizeof(float)];
  hn::Store(lanes, d, values);
  double sum = 0;
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) sum += values[i];
  return sum;
}

void sum_votes(const KernelInput& in, const std::vector<KernelPlane>& planes,
               std::vector<KernelSums>& sums) {
  const Floats d;
  const std::size_t lanes = hn::Lanes(d);
  const hn::Mask<Floats> all = hn::FirstN(d, lanes);
  for (std::size_t begin = 0; begin < in.count; begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, in.count);
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const Float zero = hn::Zero(d);
      Lanes sum{zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
      std::size_t i = begin;
      for (; i + lanes <= end; i += lanes) add_points(in, planes[k], i, all, sum);
      if (i < end) add_points(in, planes[k], i, hn::FirstN(d, end - i), sum);
      sums[k].outside_points += total(sum.outside_points);
      sums[k].outside_pixels += total(sum.outside_pixels);
      sums[k].nearer_points += total(sum.nearer_points);
      sums[k].nearer += total(sum.nearer);
      sums[k].outside_squared += total(sum.outside_squared);
      sums[k].in_front += total(sum.in_front);
      sums[k].coincident += total(sum.coincident);
      sums[k].contradicted += total(sum.contradicted);
      sums[k].hidden += total(sum.hidden);
      sums[k].unseen += total(sum.unseen);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace prehend::shape
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::shape {

HWY_EXPORT(sum_votes);

void sum_votes(const KernelInput& input, const std::vector<KernelPlane>& planes,
               std::vector<KernelSums>& sums) {
  HWY_DYNAMIC_DISPATCH(sum_votes)(input, planes, sums);
}

}  // namespace prehend::shape
#endif
