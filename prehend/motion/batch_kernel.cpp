// Compiled once for each instruction set by Highway's foreach_target.h, which includes it again.
#include "prehend/motion/batch_kernel.h"

#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/motion/batch_kernel.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prehend::motion::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kBatch>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using DI = hn::RebindToSigned<D>;

struct Point {
  V x, y, z;
};

/// Columns of the rotation, and the origin, in the base frame.
struct Pose {
  Point a, b, c, t;
};

HWY_INLINE V set(float value) { return hn::Set(D(), value); }

HWY_INLINE Point combine(const Pose& X, float x, float y, float z) {
  const V vx = set(x), vy = set(y), vz = set(z);
  return {hn::MulAdd(X.a.x, vx, hn::MulAdd(X.b.x, vy, hn::Mul(X.c.x, vz))),
          hn::MulAdd(X.a.y, vx, hn::MulAdd(X.b.y, vy, hn::Mul(X.c.y, vz))),
          hn::MulAdd(X.a.z, vx, hn::MulAdd(X.b.z, vy, hn::Mul(X.c.z, vz)))};
}

HWY_INLINE Point add(const Point& a, const Point& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

HWY_INLINE Point at(const Pose& X, const BatchScene::Ball& ball) {
  return add(combine(X, ball.x, ball.y, ball.z), X.t);
}

HWY_INLINE V squared(V x, V y, V z) { return hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))); }

/// Reduced to a quarter turn by Cody and Waite's method in three parts of pi/2, then Cephes'
/// minimax polynomials (S. L. Moshier): within 2e-7 for |x| < 1000.
HWY_INLINE void sine_cosine(V x, V& sine, V& cosine) {
  const D d;
  const DI di;
  const V turns = hn::Round(hn::Mul(x, set(0.636619772f)));
  const auto quarter = hn::ConvertTo(di, turns);
  V r = hn::NegMulAdd(turns, set(1.5703125f), x);
  r = hn::NegMulAdd(turns, set(4.837512969970703e-4f), r);
  r = hn::NegMulAdd(turns, set(7.549789948768648e-8f), r);
  const V r2 = hn::Mul(r, r);
  V s = hn::MulAdd(set(-1.9515295891e-4f), r2, set(8.3321608736e-3f));
  s = hn::MulAdd(s, r2, set(-1.6666654611e-1f));
  s = hn::MulAdd(hn::Mul(s, r2), r, r);
  V c = hn::MulAdd(set(2.443315711809948e-5f), r2, set(-1.388731625493765e-3f));
  c = hn::MulAdd(c, r2, set(4.166664568298827e-2f));
  c = hn::MulAdd(hn::Mul(c, r2), r2, hn::NegMulAdd(set(0.5f), r2, set(1.0f)));
  const auto one = hn::Set(di, 1), two = hn::Set(di, 2);
  const M odd = hn::RebindMask(d, hn::Eq(hn::And(quarter, one), one));
  const M minus_sine = hn::RebindMask(d, hn::Eq(hn::And(quarter, two), two));
  const M minus_cosine = hn::RebindMask(d, hn::Eq(hn::And(hn::Add(quarter, one), two), two));
  const V swapped_s = hn::IfThenElse(odd, c, s), swapped_c = hn::IfThenElse(odd, s, c);
  sine = hn::IfThenElse(minus_sine, hn::Neg(swapped_s), swapped_s);
  cosine = hn::IfThenElse(minus_cosine, hn::Neg(swapped_c), swapped_c);
}

/// Written in place: a pose that is copied is read in wider pieces than it was written in, which
/// stalls.
HWY_INLINE void move(const Pose& X, const BatchScene::Joint& joint, V q, Pose& after) {
  after.t = add(combine(X, joint.t[0], joint.t[1], joint.t[2]), X.t);
  after.c = combine(X, joint.R[2], joint.R[5], joint.R[8]);
  const Point a = combine(X, joint.R[0], joint.R[3], joint.R[6]);
  const Point b = combine(X, joint.R[1], joint.R[4], joint.R[7]);
  if (!joint.is_revolute) {
    after.a = a;
    after.b = b;
    after.t.x = hn::MulAdd(after.c.x, q, after.t.x);
    after.t.y = hn::MulAdd(after.c.y, q, after.t.y);
    after.t.z = hn::MulAdd(after.c.z, q, after.t.z);
    return;
  }
  V sine, cosine;
  sine_cosine(q, sine, cosine);
  after.a.x = hn::MulAdd(a.x, cosine, hn::Mul(b.x, sine));
  after.a.y = hn::MulAdd(a.y, cosine, hn::Mul(b.y, sine));
  after.a.z = hn::MulAdd(a.z, cosine, hn::Mul(b.z, sine));
  after.b.x = hn::MulSub(b.x, cosine, hn::Mul(a.x, sine));
  after.b.y = hn::MulSub(b.y, cosine, hn::Mul(a.y, sine));
  after.b.z = hn::MulSub(b.z, cosine, hn::Mul(a.z, sine));
}

/// Lanes in which two balls with these centres and this sum of radii touch.
HWY_INLINE M touch(const Point& p, V x, V y, V z, float reach) {
  return hn::Lt(squared(hn::Sub(p.x, x), hn::Sub(p.y, y), hn::Sub(p.z, z)), set(reach * reach));
}

HWY_INLINE V over(const BatchScene::Face& face, const Point& p) {
  return hn::MulAdd(p.x, set(face.x),
                    hn::MulAdd(p.y, set(face.y), hn::MulSub(p.z, set(face.z), set(face.offset))));
}

/// Lanes in which a ball at p may touch the obstacle: quick, and never too few. `reach`: its radius
/// and the margin.
HWY_INLINE M may_touch(const BatchScene& scene, const BatchScene::Obstacle& obstacle,
                       const Point& p, float reach) {
  const D d;
  if (obstacle.kind == BatchScene::Obstacle::Kind::kPlane) {
    return hn::Lt(over(scene.faces[static_cast<std::size_t>(obstacle.first)], p), set(reach));
  }
  const float far = obstacle.bound.radius + reach;
  if (!(far > 0)) return hn::FirstN(d, 0);
  return touch(p, set(obstacle.bound.x), set(obstacle.bound.y), set(obstacle.bound.z), far);
}

HWY_INLINE V coordinate(const BatchScene::Obstacle& box, std::size_t row, const Point& p) {
  return hn::MulAdd(p.x, set(box.R[3 * row]),
                    hn::MulAdd(p.y, set(box.R[3 * row + 1]),
                               hn::MulAdd(p.z, set(box.R[3 * row + 2]), set(box.t[row]))));
}

/// Lanes of those that may_touch() for which it is so.
HWY_INLINE M touches(const BatchScene& scene, const BatchScene::Obstacle& obstacle, const Point& p,
                     float reach_m, M near) {
  using Kind = BatchScene::Obstacle::Kind;
  const D d;
  const V reach = set(reach_m);
  if (obstacle.kind == Kind::kBox) {
    const V zero = hn::Zero(d);
    const V x = hn::Sub(hn::Abs(coordinate(obstacle, 0, p)), set(obstacle.half[0]));
    const V y = hn::Sub(hn::Abs(coordinate(obstacle, 1, p)), set(obstacle.half[1]));
    const V z = hn::Sub(hn::Abs(coordinate(obstacle, 2, p)), set(obstacle.half[2]));
    const V outside = hn::Sqrt(squared(hn::Max(x, zero), hn::Max(y, zero), hn::Max(z, zero)));
    const V inside = hn::Min(zero, hn::Max(x, hn::Max(y, z)));
    return hn::And(near, hn::Lt(hn::Add(outside, inside), reach));
  }
  if (obstacle.kind == Kind::kConvex) {
    for (int i = obstacle.first; i < obstacle.last; ++i) {
      near = hn::And(near, hn::Lt(over(scene.faces[static_cast<std::size_t>(i)], p), reach));
      if (hn::AllFalse(d, near)) break;
    }
  }
  return near;  // a plane and a ball are what may_touch() takes them for
}

HWY_INLINE Point load(const float* points, std::size_t index) {
  const D d;
  const float* from = points + 3 * kBatch * index;
  return {hn::LoadU(d, from), hn::LoadU(d, from + kBatch), hn::LoadU(d, from + 2 * kBatch)};
}

HWY_INLINE void store(const Point& p, float* points, std::size_t index) {
  const D d;
  float* to = points + 3 * kBatch * index;
  hn::StoreU(p.x, d, to);
  hn::StoreU(p.y, d, to + kBatch);
  hn::StoreU(p.z, d, to + 2 * kBatch);
}

/// Lanes in which a group's balls touch an obstacle that its bound may.
HWY_INLINE M group_touches(const BatchScene& scene, const BatchScene::Group& group, const Pose& X,
                           const BatchScene::Obstacle& obstacle, float swell) {
  const D d;
  M result = hn::FirstN(d, 0);
  const float margin = obstacle.margin[static_cast<std::size_t>(group.part)] + swell;
  for (int i = group.first; i < group.last; ++i) {
    const BatchScene::Ball& ball = scene.balls[static_cast<std::size_t>(i)];
    const Point p = at(X, ball);
    const M near = may_touch(scene, obstacle, p, ball.radius + margin);
    if (hn::AllFalse(d, near)) continue;
    result = hn::Or(result, touches(scene, obstacle, p, ball.radius + margin, near));
  }
  return result;
}

HWY_INLINE M near_candidate(const BatchScene::Candidate& candidate, const Point& p, float swell) {
  return touch(p, set(candidate.x), set(candidate.y), set(candidate.z), candidate.far + swell);
}

/// Lanes in which a group touches the world.
HWY_INLINE M world_touches(const BatchScene& scene, const BatchScene::Group& group, const Pose& X,
                           const Point& bound, float swell) {
  const D d;
  M result = hn::FirstN(d, 0);
  for (const int i : scene.planes) {
    const BatchScene::Obstacle& plane = scene.obstacles[static_cast<std::size_t>(i)];
    const float reach =
        group.bound.radius + plane.margin[static_cast<std::size_t>(group.part)] + swell;
    if (hn::AllFalse(d, may_touch(scene, plane, bound, reach))) continue;
    result = hn::Or(result, group_touches(scene, group, X, plane, swell));
  }
  for (int i = group.first_candidate; i < group.last_candidate; i += BatchScene::kCandidates) {
    const BatchScene::Candidate* four = &scene.candidates[static_cast<std::size_t>(i)];
    const M near = hn::Or(
        hn::Or(near_candidate(four[0], bound, swell), near_candidate(four[1], bound, swell)),
        hn::Or(near_candidate(four[2], bound, swell), near_candidate(four[3], bound, swell)));
    if (hn::AllFalse(d, near)) continue;
    for (int k = 0; k < BatchScene::kCandidates; ++k) {
      if (four[k].obstacle < 0 || hn::AllFalse(d, near_candidate(four[k], bound, swell))) continue;
      const auto at_obstacle = static_cast<std::size_t>(four[k].obstacle);
      result = hn::Or(result, group_touches(scene, group, X, scene.obstacles[at_obstacle], swell));
    }
  }
  return result;
}

/// `bounds`: room for 3 x kBatch numbers for each group.
M touching(const BatchScene& scene, const float* q, bool stop_at_first, const float* swell,
           float* bounds) {
  const D d;
  const V zero = hn::Zero(d), one = set(1);
  Pose poses[17];
  poses[0].a = {one, zero, zero};
  poses[0].b = {zero, one, zero};
  poses[0].c = {zero, zero, one};
  poses[0].t = {zero, zero, zero};
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    move(poses[j], scene.joints[j], hn::LoadU(d, q + j * kBatch), poses[j + 1]);
  }
  M result = hn::FirstN(d, 0);
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const BatchScene::Group& group = scene.groups[g];
    const Pose& X = poses[group.joint + 1];
    const Point bound = at(X, group.bound);
    store(bound, bounds, g);
    if (group.joint < 0) continue;  // what stands with the base never moves
    const float larger = swell ? swell[group.joint] : 0;
    result = hn::Or(result, world_touches(scene, group, X, bound, larger));
    if (stop_at_first && !hn::AllFalse(d, result)) return result;
  }
  for (const BatchScene::GroupPair& pair : scene.group_pairs) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    const BatchScene::Group &first = scene.groups[a], &second = scene.groups[b];
    const Point other = load(bounds, b);
    const M near =
        touch(load(bounds, a), other.x, other.y, other.z, first.bound.radius + second.bound.radius);
    if (hn::AllFalse(d, near)) continue;
    for (int i = pair.first; i < pair.last; ++i) {
      const BatchScene::BallPair& balls = scene.ball_pairs[static_cast<std::size_t>(i)];
      const Point p = at(poses[second.joint + 1], scene.balls[static_cast<std::size_t>(balls.b)]);
      result = hn::Or(
          result, touch(at(poses[first.joint + 1], scene.balls[static_cast<std::size_t>(balls.a)]),
                        p.x, p.y, p.z, balls.reach));
    }
    if (stop_at_first && !hn::AllFalse(d, result)) return result;
  }
  return result;
}

std::uint32_t touching_lanes(const BatchScene& scene, const float* q, bool stop_at_first,
                             const float* swell) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  thread_local std::vector<float> room;
  room.resize(3 * kBatch * scene.groups.size());
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < kBatch; first += lanes) {
    const M mask = touching(scene, q + first, stop_at_first, swell, room.data());
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, mask, bits);
    result |= static_cast<std::uint32_t>(bits[0] & ((1u << lanes) - 1)) << first;
    if (stop_at_first && result != 0) break;
  }
  return result;
}

}  // namespace prehend::motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::motion {
namespace {

HWY_EXPORT(touching_lanes);

}  // namespace

std::uint32_t touching_lanes(const BatchScene& scene, const float* q, bool stop_at_first,
                             const float* swell) {
  return HWY_DYNAMIC_DISPATCH(touching_lanes)(scene, q, stop_at_first, swell);
}

}  // namespace prehend::motion
#endif
