// Compiled once for each instruction set by Highway's foreach_target.h, which includes it again.
#include "prehend/grasp/closing/distance_kernel.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/grasp/closing/distance_kernel.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prehend::grasp::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kEight = 8;
using D = hn::CappedTag<float, kEight>;
using V = hn::Vec<D>;

struct Points {
  V x, y, z;
};

HWY_INLINE V set(float value) { return hn::Set(D(), value); }
HWY_INLINE Points from(const Points& p, const float* origin) {
  return {hn::Sub(p.x, set(origin[0])), hn::Sub(p.y, set(origin[1])), hn::Sub(p.z, set(origin[2]))};
}
HWY_INLINE V dot(const Points& p, const float* v) {
  return hn::MulAdd(p.x, set(v[0]), hn::MulAdd(p.y, set(v[1]), hn::Mul(p.z, set(v[2]))));
}
HWY_INLINE V squared(const Points& p) {
  return hn::MulAdd(p.x, p.x, hn::MulAdd(p.y, p.y, hn::Mul(p.z, p.z)));
}

/// Eight points, the corners of a cube: bit 0 of a point's number is its x, bit 1 its y, bit 2 its
/// z. points() are as many as a vector holds, from number `lane` on.
struct Cube {
  alignas(64) float x[kEight], y[kEight], z[kEight];

  Cube(float low_x, float low_y, float low_z, float side) {
    for (std::size_t i = 0; i < kEight; ++i) {
      x[i] = low_x + (i & 1 ? side : 0);
      y[i] = low_y + (i & 2 ? side : 0);
      z[i] = low_z + (i & 4 ? side : 0);
    }
  }
  HWY_INLINE Points points(std::size_t lane) const {
    return {hn::LoadU(D(), x + lane), hn::LoadU(D(), y + lane), hn::LoadU(D(), z + lane)};
  }
};

HWY_INLINE V squared_distance(const BlockTriangle& triangle, const Points& p) {
  V least = set(std::numeric_limits<float>::infinity());
  V inside = least;  // of the side that a point is farthest outside of, or nearest to
  for (const BlockTriangle::Side& side : triangle.sides) {
    const Points beside = from(p, side.from);
    const V along = hn::Min(
        hn::Max(hn::Mul(dot(beside, side.way), set(side.per_squared)), hn::Zero(D())), set(1));
    const Points off{hn::NegMulAdd(along, set(side.way[0]), beside.x),
                     hn::NegMulAdd(along, set(side.way[1]), beside.y),
                     hn::NegMulAdd(along, set(side.way[2]), beside.z)};
    least = hn::Min(least, squared(off));
    inside = hn::Min(inside, dot(beside, side.inward));
  }
  if (!triangle.has_area) return least;
  const V height = dot(from(p, triangle.centroid), triangle.normal);
  return hn::IfThenElse(hn::Ge(inside, hn::Zero(D())), hn::Mul(height, height), least);
}

void measure_block(std::span<const BlockTriangle> triangles, std::span<const int> near,
                   const BlockPlace& place, float* scratch, DistanceBlock& block) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  constexpr float kDiagonal = 1.7320508f;
  const float cell = place.cell;
  // What each eighth's middle is from a triangle at least, and from the nearest at most.
  const Cube middles(place.first[0] + cell / 2, place.first[1] + cell / 2,
                     place.first[2] + cell / 2, 2 * cell);
  alignas(64) float most[kEight];
  for (std::size_t lane = 0; lane < kEight; lane += lanes) {
    const Points p = middles.points(lane);
    V nearest = set(place.most + kDiagonal * cell);
    for (std::size_t i = 0; i < near.size(); ++i) {
      const BlockTriangle& triangle = triangles[static_cast<std::size_t>(near[i])];
      const V distance = hn::Sqrt(squared(from(p, triangle.centroid)));
      nearest = hn::Min(nearest, distance);
      hn::StoreU(hn::Sub(distance, set(triangle.radius)), d, scratch + kEight * i + lane);
    }
    hn::StoreU(nearest, d, most + lane);
  }
  for (std::size_t eighth = 0; eighth < kEight; ++eighth) {
    const std::size_t low[3] = {2 * (eighth & 1), eighth & 2, (eighth & 4) / 2};
    const Cube nodes(place.first[0] + cell * static_cast<float>(low[0]),
                     place.first[1] + cell * static_cast<float>(low[1]),
                     place.first[2] + cell * static_cast<float>(low[2]), cell);
    const float reach = (most[eighth] + kDiagonal * cell) * (1 + 1e-5f);
    alignas(64) float least[kEight];
    for (std::size_t lane = 0; lane < kEight; lane += lanes) {
      const Points p = nodes.points(lane);
      V found = set(std::numeric_limits<float>::infinity());
      for (std::size_t i = 0; i < near.size(); ++i) {
        if (scratch[kEight * i + eighth] > reach) continue;
        found = hn::Min(found, squared_distance(triangles[static_cast<std::size_t>(near[i])], p));
      }
      hn::StoreU(hn::Sqrt(found), d, least + lane);
    }
    for (std::size_t i = 0; i < kEight; ++i) {
      const std::size_t x = low[0] + (i & 1), y = low[1] + (i & 2) / 2, z = low[2] + (i & 4) / 4;
      block[(z * kBlockSide + y) * kBlockSide + x] = least[i];
    }
  }
}

}  // namespace prehend::grasp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::grasp {
namespace {

HWY_EXPORT(measure_block);

}  // namespace

void measure_block(std::span<const BlockTriangle> triangles, std::span<const int> near,
                   const BlockPlace& place, float* scratch, DistanceBlock& block) {
  HWY_DYNAMIC_DISPATCH(measure_block)(triangles, near, place, scratch, block);
}

}  // namespace prehend::grasp
#endif
