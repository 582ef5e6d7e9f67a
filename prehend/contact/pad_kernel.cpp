#include "prehend/contact/pad_kernel.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "prehend/contact/foam.h"
#include "prehend/contact/texel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/contact/pad_kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

#include "hwy/contrib/math/math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace prehend::contact::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, PadLayout::kLanes>;
using V = hn::Vec<D>;

// Point of contact, and velocity of the touched body there along the texel's normal and tangents.
struct Motion {
  V cx, cy, cz;
  V normal, u, v;
};

template <bool kFlat>
HWY_INLINE Motion MotionAt(const PadLayout& pad, const PadState& state, const Vector6& twist,
                           std::size_t i) {
  const D d;
  const V depth = hn::LoadU(d, &state.depth[i]);
  const V vx = hn::Set(d, twist[0]), vy = hn::Set(d, twist[1]), vz = hn::Set(d, twist[2]);
  const V wx = hn::Set(d, twist[3]), wy = hn::Set(d, twist[4]), wz = hn::Set(d, twist[5]);
  Motion m;
  if constexpr (kFlat) {
    m.cx = hn::LoadU(d, &pad.x[i]);
    m.cy = hn::LoadU(d, &pad.y[i]);
    m.cz = hn::Neg(depth);
  } else {
    m.cx = hn::NegMulAdd(hn::LoadU(d, &pad.nx[i]), depth, hn::LoadU(d, &pad.x[i]));
    m.cy = hn::NegMulAdd(hn::LoadU(d, &pad.ny[i]), depth, hn::LoadU(d, &pad.y[i]));
    m.cz = hn::NegMulAdd(hn::LoadU(d, &pad.nz[i]), depth, hn::LoadU(d, &pad.z[i]));
  }
  const V x = hn::Add(vx, hn::MulSub(wy, m.cz, hn::Mul(wz, m.cy)));
  const V y = hn::Add(vy, hn::MulSub(wz, m.cx, hn::Mul(wx, m.cz)));
  const V z = hn::Add(vz, hn::MulSub(wx, m.cy, hn::Mul(wy, m.cx)));
  if constexpr (kFlat) {
    m.u = x;
    m.v = y;
    m.normal = z;
  } else {
    const auto along = [&](const auto& ax, const auto& ay, const auto& az) HWY_ATTR {
      return hn::MulAdd(hn::LoadU(d, &ax[i]), x,
                        hn::MulAdd(hn::LoadU(d, &ay[i]), y, hn::Mul(hn::LoadU(d, &az[i]), z)));
    };
    m.u = along(pad.ux, pad.uy, pad.uz);
    m.v = along(pad.vx, pad.vy, pad.vz);
    m.normal = along(pad.nx, pad.ny, pad.nz);
  }
  return m;
}

// Texels' depth rates, for the laws that are linearised one by one.
template <bool kFlat>
void DepthRates(const PadLayout& pad, const PadState& state, const Vector6& twist, double* rates) {
  const D d;
  for (std::size_t i = 0; i < pad.padded_size(); i += hn::Lanes(d)) {
    hn::StoreU(hn::Neg(MotionAt<kFlat>(pad, state, twist, i).normal), d, rates + i);
  }
}

// Decay D of the bristles, see linearise_friction.
HWY_INLINE V Decay(const TexelLaw& law, double h, V force, V speed, V trial_length, V outward) {
  const D d;
  const V one = hn::Set(d, 1.0);
  V friction = hn::Set(d, law.dynamic_friction);
  if (law.static_friction != law.dynamic_friction) {
    const V ratio = hn::Mul(speed, hn::Set(d, 1 / law.stribeck_velocity));
    friction = hn::MulAdd(hn::Set(d, law.static_friction - law.dynamic_friction),
                          hn::Exp(d, hn::Neg(hn::Mul(ratio, ratio))), friction);
  }
  const V g = hn::Mul(force, friction);
  const V load = hn::Mul(hn::Set(d, law.bristle_stiffness), trial_length);
  V slide = hn::Mul(hn::Set(d, h * law.bristle_stiffness), speed);
  if (law.bristle_law == BristleLaw::kElastoPlastic) {
    V t = hn::Mul(hn::Sub(hn::Div(load, g), hn::Set(d, law.elastic_limit)),
                  hn::Set(d, 1 / (1 - law.elastic_limit)));
    t = hn::Min(hn::Max(t, hn::Zero(d)), one);
    const V alpha = hn::Mul(hn::Mul(t, t), hn::NegMulAdd(hn::Set(d, 2.0), t, hn::Set(d, 3.0)));
    slide = hn::IfThenElseZero(hn::Gt(outward, hn::Zero(d)), hn::Mul(slide, alpha));
  }
  V decay = hn::Add(one, hn::Div(slide, g));
  if (law.return_map) {
    decay = hn::Max(decay, hn::Div(load, hn::Mul(force, hn::Set(d, law.static_friction))));
  }
  return hn::IfThenElse(hn::Gt(g, hn::Zero(d)), decay, one);
}

// Sums over texels of T [1, c, c c'], (B - T) m m' with m = (n, c x n), and of constant wrenches.
enum Sum {
  kT,
  kTx,
  kTy,
  kTz,
  kTxx,
  kTyy,
  kTzz,
  kTxy,
  kTxz,
  kTyz,
  kForce,                // 3
  kTorque = kForce + 3,  // 3
  kM = kTorque + 3,      // lower triangle of 6 x 6, row by row
  kSums = kM + 21
};

template <bool kFlat>
int RespondTexels(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
                  const PadState& state, PadScratch& scratch, double* sums) {
  const D d;
  const V zero = hn::Zero(d);
  // Offset and damping are given.
  const bool tabled = law.normal_law != NormalLaw::kLinear || law.memory.terms() > 0;
  const V stiffness = hn::Set(d, law.stiffness), damping = hn::Set(d, law.damping);
  const V gap_damping = hn::Set(d, h * law.stiffness);
  const V hs = hn::Set(d, h);
  const V gain_at_rest = hn::Set(d, law.bristle_stiffness + law.bristle_damping / h);
  const V gain_loss = hn::Set(d, law.bristle_damping / h);
  const V drag_at_rest = hn::Set(d, h * law.bristle_stiffness + law.bristle_damping);
  const V viscous = hn::Set(d, law.viscous_friction);
  const bool frictionless = law.static_friction == 0;
  V sum[kSums];
  for (V& s : sum) s = zero;
  std::size_t pressing = 0;
  for (std::size_t i = 0; i < pad.padded_size(); i += hn::Lanes(d)) {
    const V depth = hn::LoadU(d, &state.depth[i]);
    const Motion m = MotionAt<kFlat>(pad, state, twist, i);
    V offset, resistance;
    if (tabled) {
      offset = hn::LoadU(d, &scratch.normal_offset[i]);
      resistance = hn::LoadU(d, &scratch.normal_damping[i]);
    } else {
      offset = hn::Mul(stiffness, depth);
      resistance = hn::Add(gap_damping, hn::IfThenElseZero(hn::Gt(depth, zero), damping));
    }
    const V force = hn::NegMulAdd(resistance, m.normal, offset);
    const V scale = hn::LoadU(d, &pad.scale[i]);
    const auto presses = hn::And(hn::Gt(force, zero), hn::Gt(scale, zero));
    if (hn::AllFalse(d, presses)) {
      for (auto* array : {&scratch.normal_offset, &scratch.normal_damping, &scratch.bristle_gain,
                          &scratch.tangential_damping, &scratch.inverse_decay}) {
        hn::StoreU(zero, d, array->data() + i);
      }
      continue;
    }
    pressing += hn::CountTrue(d, presses);

    const V zu = hn::LoadU(d, &state.bristle_u[i]), zv = hn::LoadU(d, &state.bristle_v[i]);
    const V tu = hn::MulAdd(hs, m.u, zu), tv = hn::MulAdd(hs, m.v, zv);  // elastic trial
    const V speed = hn::Sqrt(hn::MulAdd(m.u, m.u, hn::Mul(m.v, m.v)));
    const V trial = hn::Sqrt(hn::MulAdd(tu, tu, hn::Mul(tv, tv)));
    const V outward = hn::MulAdd(tu, m.u, hn::Mul(tv, m.v));
    const V inverse_decay = hn::IfThenElseZero(
        presses, hn::Div(hn::Set(d, 1.0), Decay(law, h, force, speed, trial, outward)));
    V gain = zero, drag = zero;
    if (!frictionless) {
      gain = hn::IfThenElseZero(presses, hn::MulSub(gain_at_rest, inverse_decay, gain_loss));
      drag = hn::IfThenElseZero(presses, hn::MulAdd(drag_at_rest, inverse_decay, viscous));
    }
    offset = hn::IfThenElseZero(presses, offset);
    resistance = hn::IfThenElseZero(presses, resistance);
    hn::StoreU(offset, d, &scratch.normal_offset[i]);
    hn::StoreU(resistance, d, &scratch.normal_damping[i]);
    hn::StoreU(gain, d, &scratch.bristle_gain[i]);
    hn::StoreU(drag, d, &scratch.tangential_damping[i]);
    hn::StoreU(inverse_decay, d, &scratch.inverse_decay[i]);

    const V T = hn::Mul(scale, drag);
    const V E = hn::Sub(hn::Mul(scale, resistance), T);
    const V N = hn::Mul(scale, offset);
    const V su = hn::Mul(scale, hn::Mul(gain, zu)), sv = hn::Mul(scale, hn::Mul(gain, zv));
    const V Tx = hn::Mul(T, m.cx), Ty = hn::Mul(T, m.cy), Tz = hn::Mul(T, m.cz);
    sum[kT] = hn::Add(sum[kT], T);
    sum[kTx] = hn::Add(sum[kTx], Tx);
    sum[kTy] = hn::Add(sum[kTy], Ty);
    sum[kTz] = hn::Add(sum[kTz], Tz);
    sum[kTxx] = hn::MulAdd(Tx, m.cx, sum[kTxx]);
    sum[kTyy] = hn::MulAdd(Ty, m.cy, sum[kTyy]);
    sum[kTzz] = hn::MulAdd(Tz, m.cz, sum[kTzz]);
    sum[kTxy] = hn::MulAdd(Tx, m.cy, sum[kTxy]);
    sum[kTxz] = hn::MulAdd(Tx, m.cz, sum[kTxz]);
    sum[kTyz] = hn::MulAdd(Ty, m.cz, sum[kTyz]);
    V fx, fy, fz;
    if constexpr (kFlat) {
      fx = hn::Neg(su);
      fy = hn::Neg(sv);
      fz = N;
    } else {
      const auto along = [&](const auto& n, const auto& u, const auto& v) HWY_ATTR {
        return hn::NegMulAdd(
            hn::LoadU(d, &v[i]), sv,
            hn::NegMulAdd(hn::LoadU(d, &u[i]), su, hn::Mul(hn::LoadU(d, &n[i]), N)));
      };
      fx = along(pad.nx, pad.ux, pad.vx);
      fy = along(pad.ny, pad.uy, pad.vy);
      fz = along(pad.nz, pad.uz, pad.vz);
    }
    sum[kForce] = hn::Add(sum[kForce], fx);
    sum[kForce + 1] = hn::Add(sum[kForce + 1], fy);
    sum[kForce + 2] = hn::Add(sum[kForce + 2], fz);
    sum[kTorque] = hn::Add(sum[kTorque], hn::MulSub(m.cy, fz, hn::Mul(m.cz, fy)));
    sum[kTorque + 1] = hn::Add(sum[kTorque + 1], hn::MulSub(m.cz, fx, hn::Mul(m.cx, fz)));
    sum[kTorque + 2] = hn::Add(sum[kTorque + 2], hn::MulSub(m.cx, fy, hn::Mul(m.cy, fx)));
    if constexpr (kFlat) {
      // m = (0, 0, 1, cy, -cx, 0); index of (row, column): kM + row (row + 1) / 2 + column
      const V Ex = hn::Mul(E, m.cx), Ey = hn::Mul(E, m.cy);
      sum[kM + 5] = hn::Add(sum[kM + 5], E);
      sum[kM + 8] = hn::Add(sum[kM + 8], Ey);
      sum[kM + 9] = hn::MulAdd(Ey, m.cy, sum[kM + 9]);
      sum[kM + 12] = hn::Sub(sum[kM + 12], Ex);
      sum[kM + 13] = hn::NegMulAdd(Ey, m.cx, sum[kM + 13]);
      sum[kM + 14] = hn::MulAdd(Ex, m.cx, sum[kM + 14]);
    } else {
      const V nx = hn::LoadU(d, &pad.nx[i]), ny = hn::LoadU(d, &pad.ny[i]);
      const V nz = hn::LoadU(d, &pad.nz[i]);
      const V row[6] = {nx,
                        ny,
                        nz,
                        hn::MulSub(m.cy, nz, hn::Mul(m.cz, ny)),
                        hn::MulSub(m.cz, nx, hn::Mul(m.cx, nz)),
                        hn::MulSub(m.cx, ny, hn::Mul(m.cy, nx))};
      for (int r = 0, k = kM; r < 6; ++r) {
        const V Er = hn::Mul(E, row[r]);
        for (int c = 0; c <= r; ++c, ++k) sum[k] = hn::MulAdd(Er, row[c], sum[k]);
      }
    }
  }
  for (int k = 0; k < kSums; ++k) sums[k] = hn::GetLane(hn::SumOfLanes(d, sum[k]));
  return static_cast<int>(pressing);
}

template <bool kFlat>
void AdvanceTexels(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
                   PadState& state, const PadScratch& scratch) {
  const D d;
  const V zero = hn::Zero(d), hs = hn::Set(d, h);
  for (std::size_t i = 0; i < pad.padded_size(); i += hn::Lanes(d)) {
    const V inverse_decay = hn::LoadU(d, &scratch.inverse_decay[i]);
    const Motion m = MotionAt<kFlat>(pad, state, twist, i);
    const V scale = hn::LoadU(d, &pad.scale[i]);
    const V zu = hn::LoadU(d, &state.bristle_u[i]), zv = hn::LoadU(d, &state.bristle_v[i]);
    const V force = hn::Max(zero, hn::NegMulAdd(hn::LoadU(d, &scratch.normal_damping[i]), m.normal,
                                                hn::LoadU(d, &scratch.normal_offset[i])));
    const V gain = hn::LoadU(d, &scratch.bristle_gain[i]);
    const V drag = hn::LoadU(d, &scratch.tangential_damping[i]);
    hn::StoreU(hn::Mul(scale, force), d, &state.normal_force[i]);
    hn::StoreU(hn::Mul(scale, hn::MulAdd(gain, zu, hn::Mul(drag, m.u))), d, &state.friction_u[i]);
    hn::StoreU(hn::Mul(scale, hn::MulAdd(gain, zv, hn::Mul(drag, m.v))), d, &state.friction_v[i]);
    V u = hn::Mul(inverse_decay, hn::MulAdd(hs, m.u, zu));
    V v = hn::Mul(inverse_decay, hn::MulAdd(hs, m.v, zv));
    if (law.return_map) {
      const V length = hn::Sqrt(hn::MulAdd(u, u, hn::Mul(v, v)));
      const V limit = hn::Mul(force, hn::Set(d, law.static_friction / law.bristle_stiffness));
      const V cut = hn::IfThenElse(hn::Gt(length, limit), hn::Div(limit, length), hn::Set(d, 1.0));
      u = hn::Mul(u, cut);
      v = hn::Mul(v, cut);
    }
    hn::StoreU(u, d, &state.bristle_u[i]);
    hn::StoreU(v, d, &state.bristle_v[i]);
  }
}

int Respond(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
            const PadState& state, PadScratch& scratch, double* sums) {
  return pad.is_flat() ? RespondTexels<true>(pad, law, h, twist, state, scratch, sums)
                       : RespondTexels<false>(pad, law, h, twist, state, scratch, sums);
}

void Advance(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
             PadState& state, const PadScratch& scratch) {
  if (pad.is_flat()) {
    AdvanceTexels<true>(pad, law, h, twist, state, scratch);
  } else {
    AdvanceTexels<false>(pad, law, h, twist, state, scratch);
  }
}

void Rates(const PadLayout& pad, const PadState& state, const Vector6& twist, double* rates) {
  if (pad.is_flat()) {
    DepthRates<true>(pad, state, twist, rates);
  } else {
    DepthRates<false>(pad, state, twist, rates);
  }
}

const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace prehend::contact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::contact {
namespace {

HWY_EXPORT(Respond);
HWY_EXPORT(Advance);
HWY_EXPORT(Rates);
HWY_EXPORT(TargetName);

using HWY_NAMESPACE::Sum;

Eigen::Matrix3d cross_matrix(double x, double y, double z) {
  Eigen::Matrix3d m;
  m << 0, -z, y, z, 0, -x, -y, x, 0;
  return m;
}

// From the sums of RespondTexels: T J'J + (B - T) m m' with J = [1, -[c]x].
void fill(const double* s, PadResponse& response) {
  for (int i = 0; i < 6; ++i) response.constant[i] = s[Sum::kForce + i];
  Matrix6& A = response.resistance;
  for (int r = 0, k = Sum::kM; r < 6; ++r) {
    for (int c = 0; c <= r; ++c, ++k) A(r, c) = A(c, r) = s[k];
  }
  A.topLeftCorner<3, 3>().diagonal().array() += s[Sum::kT];
  const Eigen::Matrix3d C = cross_matrix(s[Sum::kTx], s[Sum::kTy], s[Sum::kTz]);
  A.topRightCorner<3, 3>() -= C;
  A.bottomLeftCorner<3, 3>() += C;
  const double xx = s[Sum::kTxx], yy = s[Sum::kTyy], zz = s[Sum::kTzz];
  const double xy = s[Sum::kTxy], xz = s[Sum::kTxz], yz = s[Sum::kTyz];
  Eigen::Matrix3d turning;
  turning << yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy;
  A.bottomRightCorner<3, 3>() += turning;
}

// The laws whose slope changes with depth or with what was, one texel at a time.
void linearise_normal(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
                      const PadState& state, PadScratch& scratch) {
  std::vector<double>& rates = scratch.inverse_decay;  // free until the vector pass
  HWY_DYNAMIC_DISPATCH(Rates)(pad, state, twist, rates.data());
  if (law.memory.terms() > 0) {
    return linearise_foam(pad, law, h, rates.data(), state, scratch.normal_offset.data(),
                          scratch.normal_damping.data());
  }
  for (std::size_t i = 0; i < pad.padded_size(); ++i) {
    const double depth = state.depth[i], rate = rates[i];
    const NormalResponse normal = normal_response(law, depth + h * rate, rate);
    const bool touches = depth > 0;
    const double slope = h * normal.stiffness + (touches ? normal.damping : 0.0);
    scratch.normal_damping[i] = slope;
    scratch.normal_offset[i] =
        normal.force - (touches ? 0.0 : normal.damping * rate) - slope * rate;
  }
}

}  // namespace

void respond(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist_guess,
             const PadState& state, PadScratch& scratch, PadResponse& response) {
  if (law.normal_law != NormalLaw::kLinear || law.memory.terms() > 0) {
    linearise_normal(pad, law, h, twist_guess, state, scratch);
  }
  double sums[Sum::kSums];
  response.pressing = HWY_DYNAMIC_DISPATCH(Respond)(pad, law, h, twist_guess, state, scratch, sums);
  fill(sums, response);
}

void advance(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
             PadState& state, PadScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(Advance)(pad, law, h, twist, state, scratch);
  if (law.memory.terms() == 0) return;
  std::vector<double>& rates = scratch.inverse_decay;  // not needed any more
  HWY_DYNAMIC_DISPATCH(Rates)(pad, state, twist, rates.data());
  advance_foam(pad, law, h, rates.data(), state);
}

void release(PadState& state) {
  for (auto* values : {&state.bristle_u, &state.bristle_v, &state.normal_force, &state.friction_u,
                       &state.friction_v}) {
    std::fill(values->begin(), values->end(), 0.0);
  }
}

void release(const PadLayout& pad, const TexelLaw& law, double h, PadState& state) {
  release(state);
  if (law.memory.terms() > 0) advance_foam(pad, law, h, nullptr, state);
}

Vector6 explicit_step(const PadLayout& pad, const TexelLaw& law, double h, const Vector6& twist,
                      PadState& state) {
  Vector6 wrench = Vector6::Zero();
  const std::vector<double> at_rest(law.memory.terms() > 0 ? pad.padded_size() : 0, 0.0);
  std::vector<double> offset(at_rest), slope(at_rest);
  if (law.memory.terms() > 0) {
    advance_foam(pad, law, h, at_rest.data(), state);
    state.foam_due = 0;
    linearise_foam(pad, law, 0, at_rest.data(), state, offset.data(), slope.data());
    state.foam_due = 1;
  }
  for (std::size_t i = 0; i < pad.size(); ++i) {
    const Eigen::Vector3d n = pad.normal(i), u = pad.first_tangent(i), v = pad.second_tangent(i);
    const Eigen::Vector3d c = pad.position(i) - state.depth[i] * n;
    const Eigen::Vector3d velocity = twist.head<3>() + Eigen::Vector3d(twist.tail<3>()).cross(c);
    const double fn = offset.empty() ? normal_force(law, state.depth[i], -n.dot(velocity))
                                     : std::max(0.0, offset[i] - slope[i] * n.dot(velocity));
    Eigen::Vector2d friction = Eigen::Vector2d::Zero(), bristle = Eigen::Vector2d::Zero();
    if (fn > 0) {
      const Eigen::Vector2d slip(u.dot(velocity), v.dot(velocity));
      bristle = Eigen::Vector2d(state.bristle_u[i], state.bristle_v[i]);
      const Eigen::Vector2d rate = bristle_rate(law, bristle, slip, fn);
      friction = friction_force(law, bristle, rate, slip);
      bristle += h * rate;
      if (law.return_map) bristle = return_mapped(law, fn, bristle);
    }
    state.normal_force[i] = pad.scale[i] * fn;
    state.friction_u[i] = pad.scale[i] * friction.x();
    state.friction_v[i] = pad.scale[i] * friction.y();
    state.bristle_u[i] = bristle.x();
    state.bristle_v[i] = bristle.y();
    const Eigen::Vector3d force = pad.scale[i] * (fn * n - friction.x() * u - friction.y() * v);
    wrench.head<3>() += force;
    wrench.tail<3>() += c.cross(force);
  }
  return wrench;
}

std::string vector_target() { return HWY_DYNAMIC_DISPATCH(TargetName)(); }

}  // namespace prehend::contact
#endif  // HWY_ONCE
