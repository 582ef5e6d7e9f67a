// Compiled once for each instruction set by Highway's foreach_target.h, which includes it again.
#include "prehend/robot/branch_kernel.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/robot/branch_kernel.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace prehend::robot::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kBranches>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using Vector = BranchArm::Vector;

constexpr double kDoubtful = 1e-10;  // of a squared sine: where single roots are not sure

struct Lanes3 {
  V x, y, z;
};

HWY_INLINE V set(double value) { return hn::Set(D(), value); }

HWY_INLINE double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// a + s b
HWY_INLINE Vector add(const Vector& a, double s, const Vector& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
HWY_INLINE Vector across(const Vector& v, const Vector& axis) {
  return add(v, -dot(axis, v), axis);
}

HWY_INLINE V dot(const Lanes3& a, const Lanes3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V dot(const Lanes3& a, const Vector& b) {
  return hn::MulAdd(a.x, set(b[0]), hn::MulAdd(a.y, set(b[1]), hn::Mul(a.z, set(b[2]))));
}
HWY_INLINE Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
/// k + c a + s b
HWY_INLINE Lanes3 combine(const Vector& k, V c, const Vector& a, V s, const Vector& b) {
  return {hn::MulAdd(c, set(a[0]), hn::MulAdd(s, set(b[0]), set(k[0]))),
          hn::MulAdd(c, set(a[1]), hn::MulAdd(s, set(b[1]), set(k[1]))),
          hn::MulAdd(c, set(a[2]), hn::MulAdd(s, set(b[2]), set(k[2])))};
}
/// v turned about a unit axis.
HWY_INLINE Lanes3 turned(const Vector& axis, V c, V s, const Vector& v) {
  const double along = dot(axis, v);
  return combine({along * axis[0], along * axis[1], along * axis[2]}, c, across(v, axis), s,
                 cross(axis, v));
}
HWY_INLINE Lanes3 turned(const Vector& axis, V c, V s, const Lanes3& v) {
  const V along = hn::Mul(dot(v, axis), hn::Sub(set(1), c));
  const Lanes3 h{set(axis[0]), set(axis[1]), set(axis[2])};
  const Lanes3 side = cross(h, v);
  return {hn::MulAdd(h.x, along, hn::MulAdd(v.x, c, hn::Mul(side.x, s))),
          hn::MulAdd(h.y, along, hn::MulAdd(v.y, c, hn::Mul(side.y, s))),
          hn::MulAdd(h.z, along, hn::MulAdd(v.z, c, hn::Mul(side.z, s)))};
}

/// Cephes' rational approximation (S. L. Moshier), within 3e-16 of the angle. @pre not both 0.
HWY_INLINE V arcus_tangent(V y, V x) {
  const V ax = hn::Abs(x), ay = hn::Abs(y), zero = hn::Zero(D());
  const V small = hn::Min(ax, ay), large = hn::Max(ax, ay);
  const M beyond = hn::Gt(small, hn::Mul(set(0.66), large));
  const V t = hn::Div(hn::IfThenElse(beyond, hn::Sub(small, large), small),
                      hn::IfThenElse(beyond, hn::Add(small, large), large));
  const V z = hn::Mul(t, t);
  V p = hn::MulAdd(set(-8.750608600031904122785e-1), z, set(-1.615753718733365076637e1));
  p = hn::MulAdd(p, z, set(-7.500855792314704667340e1));
  p = hn::MulAdd(p, z, set(-1.228866684490136173410e2));
  p = hn::MulAdd(p, z, set(-6.485021904942025371773e1));
  V q = hn::Add(z, set(2.485846490142306297962e1));
  q = hn::MulAdd(q, z, set(1.650270098316988542046e2));
  q = hn::MulAdd(q, z, set(4.328810604912902668951e2));
  q = hn::MulAdd(q, z, set(4.853903996359136964868e2));
  q = hn::MulAdd(q, z, set(1.945506571482613964425e2));
  V angle = hn::MulAdd(hn::Mul(t, z), hn::Div(p, q), t);
  angle = hn::Add(angle, hn::IfThenElseZero(beyond, set(0.78539816339744830962)));
  angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(set(1.57079632679489661923), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(set(3.14159265358979323846), angle), angle);
  return hn::CopySign(angle, y);
}

/// Cosine and sine of the roots of a cos + b sin = c, one for each sign.
struct Root {
  V cosine, sine;
  M exists;
};

HWY_INLINE Root root(double a, double b, V c, V sign, bool& is_doubtful) {
  const double squared = a * a + b * b;
  const V left = hn::NegMulAdd(c, c, set(squared));
  is_doubtful = is_doubtful || !hn::AllFalse(D(), hn::Lt(hn::Abs(left), set(kDoubtful * squared)));
  const M exists = hn::Gt(left, hn::Zero(D()));
  const V w = hn::Mul(sign, hn::Sqrt(hn::IfThenElseZero(exists, left)));
  const V inverse = set(1 / squared);
  return {hn::Mul(inverse, hn::MulSub(set(a), c, hn::Mul(set(b), w))),
          hn::Mul(inverse, hn::MulAdd(set(b), c, hn::Mul(set(a), w))), exists};
}

/// Sine and cosine, of one length, of the angle about `axis` from `from` to `to`.
struct Arc {
  V sine, cosine;
};
HWY_INLINE Arc arc_about(const Vector& axis, const Lanes3& from, const Lanes3& to) {
  return {dot(cross(from, to), axis), hn::NegMulAdd(dot(from, axis), dot(to, axis), dot(from, to))};
}

void solve_lanes(const BranchArm& arm, const BranchInput& in, std::size_t first_lane,
                 BranchOutput& out) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  double signs[3][kBranches];
  for (std::size_t i = 0; i < kBranches; ++i) {
    for (std::size_t bit = 0; bit < 3; ++bit) signs[bit][i] = (i >> bit) & 1u ? -1 : 1;
  }
  const auto sign = [&](std::size_t bit) { return hn::LoadU(d, signs[bit] + first_lane); };
  const Vector &h1 = arm.axis[0], &h2 = arm.axis[1], &h3 = arm.axis[2];
  const auto rotate = [&in](const Vector& v) -> Vector {
    return {in.R[0] * v[0] + in.R[1] * v[1] + in.R[2] * v[2],
            in.R[3] * v[0] + in.R[4] * v[1] + in.R[5] * v[2],
            in.R[6] * v[0] + in.R[7] * v[1] + in.R[8] * v[2]};
  };
  const Vector u = add(add(rotate(arm.wrist), 1, in.t), -1, arm.point0);
  const double high = dot(h1, u);
  const Vector flat = add(u, -high, h1);
  const double side = dot(h2, add(arm.wrist, -1, arm.point0)) - high * dot(h1, h2);
  const Root first =
      root(dot(h2, flat), dot(cross(h1, h2), flat), set(side), sign(0), out.is_doubtful);
  // The wrist from the second axis, before the first turned, and across the second.
  const Vector constant = add(add(arm.point0, high, h1), -1, arm.point1);
  const Vector minus = cross(u, h1);
  const Lanes3 target =
      combine(across(constant, h2), first.cosine, across(flat, h2), first.sine, across(minus, h2));
  const V squared = dot(target, target);
  const V rest = hn::Mul(
      set(0.5), hn::Sub(squared, set(dot(arm.upper, arm.upper) + dot(arm.lower, arm.lower))));
  const Vector bent = cross(h3, arm.lower);
  const Root third =
      root(dot(arm.upper, arm.lower), dot(arm.upper, bent), rest, sign(1), out.is_doubtful);
  const Lanes3 from = combine(arm.upper, third.cosine, arm.lower, third.sine, bent);
  const Arc second = arc_about(h2, from, target);
  const V inverse = hn::Div(set(1), squared);
  const V c2 = hn::Mul(second.cosine, inverse), s2 = hn::Mul(second.sine, inverse);
  // Both turns about the second axis in one.
  const V s3 = hn::Mul(third.sine, set(std::copysign(1.0, dot(h2, h3))));
  const V c23 = hn::MulSub(c2, third.cosine, hn::Mul(s2, s3));
  const V s23 = hn::MulAdd(s2, third.cosine, hn::Mul(c2, s3));
  const Vector &a = arm.axis[3], &b = arm.axis[4], &c = arm.axis[5];
  const Lanes3 v =
      turned(h2, c23, hn::Neg(s23), turned(h1, first.cosine, hn::Neg(first.sine), rotate(c)));
  const double fixed = dot(a, b) * dot(b, c);
  const Root fifth = root(dot(a, c) - fixed, dot(a, cross(b, c)), hn::Sub(dot(v, a), set(fixed)),
                          sign(2), out.is_doubtful);
  const Arc fourth = arc_about(a, turned(b, fifth.cosine, fifth.sine, c), v);
  const Lanes3 x = turned(h1, first.cosine, first.sine, turned(h2, c23, s23, a));
  const Lanes3 back{dot(x, Vector{in.R[0], in.R[3], in.R[6]}),
                    dot(x, Vector{in.R[1], in.R[4], in.R[7]}),
                    dot(x, Vector{in.R[2], in.R[5], in.R[8]})};
  const Arc sixth = arc_about(c, turned(b, fifth.cosine, hn::Neg(fifth.sine), a), back);
  const V angle[6] = {
      arcus_tangent(first.sine, first.cosine), arcus_tangent(second.sine, second.cosine),
      arcus_tangent(third.sine, third.cosine), arcus_tangent(fourth.sine, fourth.cosine),
      arcus_tangent(fifth.sine, fifth.cosine), arcus_tangent(hn::Neg(sixth.sine), sixth.cosine)};
  const V whole = set(6.28318530717958647692), rounding = set(1e-9);
  M good = hn::And(first.exists, hn::And(third.exists, fifth.exists));
  V distance = hn::Zero(d);
  for (std::size_t j = 0; j < 6; ++j) {
    const V seed = set(in.seed[j]);
    const V low = hn::Sub(set(arm.low[j]), rounding), top = hn::Add(set(arm.high[j]), rounding);
    V q = hn::NegMulAdd(hn::Round(hn::Mul(hn::Sub(angle[j], seed), set(0.159154943091895335769))),
                        whole, angle[j]);
    const V less = hn::Sub(q, whole);
    q = hn::IfThenElse(hn::And(hn::Gt(q, top), hn::Ge(less, low)), less, q);
    const V more = hn::Add(q, whole);
    q = hn::IfThenElse(hn::And(hn::Lt(q, low), hn::Le(more, top)), more, q);
    good = hn::And(good, hn::And(hn::Ge(q, low), hn::Le(q, top)));
    hn::StoreU(q, d, out.q[j].data() + first_lane);
    distance = hn::MulAdd(hn::Sub(q, seed), hn::Sub(q, seed), distance);
  }
  hn::StoreU(distance, d, out.distance.data() + first_lane);
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, good, bits);
  out.within |= static_cast<std::uint32_t>(bits[0] & ((1u << lanes) - 1)) << first_lane;
}

void solve_branches(const BranchArm& arm, const BranchInput& input, BranchOutput& output) {
  output.within = 0;
  output.is_doubtful = false;
  for (std::size_t lane = 0; lane < kBranches; lane += hn::Lanes(D())) {
    solve_lanes(arm, input, lane, output);
  }
}

}  // namespace prehend::robot::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::robot {
namespace {

HWY_EXPORT(solve_branches);

}  // namespace

void solve_branches(const BranchArm& arm, const BranchInput& input, BranchOutput& output) {
  HWY_DYNAMIC_DISPATCH(solve_branches)(arm, input, output);
}

}  // namespace prehend::robot
#endif
