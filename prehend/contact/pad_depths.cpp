#include "prehend/contact/pad_depths.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "prehend/contact/mesh_rays.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "prehend/contact/pad_depths.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace prehend::contact::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Parallel rays of a flat pad on a box: slabs. o = start of the texel's ray in B as an affine
// function of its position, `origin` + x `ux` + y `uy`.
bool FlatPadOnBox(const PadLayout& pad, const Eigen::Vector3d& half, const double* origin,
                  const double* ux, const double* uy, const double* direction, double limit,
                  double* depths) {
  const hn::CappedTag<double, PadLayout::kLanes> d;
  using V = hn::Vec<decltype(d)>;
  const V zero = hn::Zero(d), thickness = hn::Set(d, pad.thickness());
  const V far = hn::Set(d, PadState::kFar), limits = hn::Set(d, limit);
  bool any = false;
  for (std::size_t i = 0; i < pad.padded_size(); i += hn::Lanes(d)) {
    const V x = hn::LoadU(d, &pad.x[i]), y = hn::LoadU(d, &pad.y[i]);
    V enter = hn::Set(d, -std::numeric_limits<double>::infinity());
    V exit = hn::Set(d, std::numeric_limits<double>::infinity());
    for (int axis = 0; axis < 3; ++axis) {
      const V o = hn::MulAdd(x, hn::Set(d, ux[axis]),
                             hn::MulAdd(y, hn::Set(d, uy[axis]), hn::Set(d, origin[axis])));
      // A ray along the slab is inside it for ever or never; a finite slope keeps 0 * inf away.
      const double slope =
          direction[axis] != 0 ? 1 / direction[axis] : std::numeric_limits<double>::max();
      const V inverse = hn::Set(d, std::clamp(slope, -1e300, 1e300));
      const V a = hn::Mul(hn::Sub(hn::Set(d, -half[axis]), o), inverse);
      const V b = hn::Mul(hn::Sub(hn::Set(d, half[axis]), o), inverse);
      enter = hn::Max(enter, hn::Min(a, b));
      exit = hn::Min(exit, hn::Max(a, b));
    }
    const V distance = hn::Max(zero, enter);
    const auto hit =
        hn::And(hn::And(hn::Le(enter, exit), hn::Ge(exit, zero)), hn::Le(distance, limits));
    any = any || !hn::AllFalse(d, hit);
    hn::StoreU(hn::IfThenElse(hit, hn::Sub(thickness, distance), far), d, depths + i);
  }
  return any;
}

}  // namespace prehend::contact::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::contact {
namespace {

HWY_EXPORT(FlatPadOnBox);

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Matrix<double, 3, 4> rounded(const geometry::RigidTransform& X) {
  const auto to_grid = [](double value, double grid) { return grid * std::round(value / grid); };
  Eigen::Matrix<double, 3, 4> result;
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) result(row, k) = to_grid(X.linear()(row, k), 10 * MeshHits::kGrid);
    result(row, 3) = to_grid(X.translation()[row], MeshHits::kGrid);
  }
  return result;
}

// The triangles that rays meet at the rounded pose.
void cast_rays(const PadLayout& pad, const MeshRays& mesh, MeshHits& hits) {
  const Eigen::Matrix3d R_BP = hits.rounded_X_PB.leftCols<3>().transpose();
  const Eigen::Vector3d p_BP = -(R_BP * hits.rounded_X_PB.col(3));
  hits.triangles.resize(pad.padded_size());
  hits.edge_on.resize(pad.padded_size());
  MeshRays::Packet packet;
  static_assert(PadLayout::kLanes == MeshRays::kPacket);
  for (std::size_t i = 0; i < pad.padded_size(); i += MeshRays::kPacket) {
    for (int k = 0; k < MeshRays::kPacket; ++k) {
      const Eigen::Vector3d n = pad.normal(i + k);
      const Eigen::Vector3d origin = p_BP + R_BP * (pad.position(i + k) - pad.thickness() * n);
      const Eigen::Vector3d direction = R_BP * n;
      packet.ox[k] = origin.x();
      packet.oy[k] = origin.y();
      packet.oz[k] = origin.z();
      packet.dx[k] = direction.x();
      packet.dy[k] = direction.y();
      packet.dz[k] = direction.z();
      packet.active[k] = i + k < pad.size();
    }
    mesh.first_hits(packet, hits.limit);
    for (int k = 0; k < MeshRays::kPacket; ++k) {
      hits.triangles[i + k] = packet.triangle[k];
      hits.edge_on[i + k] = packet.distance[k];
    }
  }
}

bool mesh_depths(const PadLayout& pad, const MeshRays& mesh, const geometry::RigidTransform& X_PB,
                 double limit, MeshHits& hits, PadState& state) {
  const Eigen::Matrix<double, 3, 4> key = rounded(X_PB);
  if (hits.limit < limit || key != hits.rounded_X_PB) {
    hits.rounded_X_PB = key;
    // Further than asked for, so that a next query that looks further finds it here; what is beyond
    // its limit is left out below.
    hits.limit = 2 * limit;
    cast_rays(pad, mesh, hits);
  }
  const geometry::RigidTransform X_BP = X_PB.inverse(Eigen::Isometry);
  bool any = false;
  std::fill(state.depth.begin(), state.depth.end(), PadState::kFar);
  for (std::size_t i = 0; i < pad.size(); ++i) {
    const int triangle = hits.triangles[i];
    if (triangle == MeshRays::kNone || pad.scale[i] == 0) continue;
    double distance = hits.edge_on[i];
    if (triangle != MeshRays::kEdgeOn) {
      const Eigen::Vector3d n = pad.normal(i);
      distance = mesh.plane_distance(X_BP * (pad.position(i) - pad.thickness() * n),
                                     X_BP.linear() * n, triangle, limit);
    }
    if (!(distance <= limit)) continue;
    state.depth[i] = pad.thickness() - distance;
    any = true;
  }
  return any;
}

// Bounds in P of a box in B.
Eigen::AlignedBox3d bounds_in(const geometry::RigidTransform& X_PB,
                              const Eigen::AlignedBox3d& box_B) {
  const Eigen::Vector3d center = X_PB * box_B.center();
  const Eigen::Vector3d half = X_PB.linear().cwiseAbs() * (0.5 * box_B.sizes());
  return {center - half, center + half};
}

}  // namespace

PadReach::PadReach(const PadLayout& pad) {
  for (std::size_t i = 0; i < pad.size(); ++i) {
    rays_P.extend(pad.position(i));
    rays_P.extend(pad.position(i) - pad.thickness() * pad.normal(i));
  }
}

bool find_depths(const PadLayout& pad, const PadReach& reach, const Shape& shape,
                 const geometry::RigidTransform& X_PB, double look_ahead, PadState& state,
                 bool gated, MeshHits* hits) {
  const double limit = pad.thickness() + look_ahead;
  if (gated && !shape.bounds().isEmpty()) {
    // Rounding in either of the two ways to compute a point cannot exceed this.
    const double slack = 1e-9 * (1 + X_PB.translation().norm());
    Eigen::AlignedBox3d rays = reach.rays_P;
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(look_ahead + slack);
    rays.min() -= margin;
    rays.max() += margin;
    if (!rays.intersects(bounds_in(X_PB, shape.bounds()))) {
      std::fill(state.depth.begin(), state.depth.end(), PadState::kFar);
      return false;
    }
  }
  if (shape.kind() == Shape::Kind::kMesh) {
    MeshHits unremembered;
    return mesh_depths(pad, shape.mesh_rays(), X_PB, limit, hits ? *hits : unremembered, state);
  }
  const geometry::RigidTransform X_BP = X_PB.inverse(Eigen::Isometry);
  if (pad.is_flat() && shape.kind() == Shape::Kind::kBox) {
    const Eigen::Vector3d origin = X_BP * Eigen::Vector3d(0, 0, -pad.thickness());
    const Eigen::Matrix3d R = X_BP.linear();
    return HWY_DYNAMIC_DISPATCH(FlatPadOnBox)(pad, shape.half_size(), origin.data(),
                                              R.col(0).data(), R.col(1).data(), R.col(2).data(),
                                              limit, state.depth.data());
  }
  bool any = false;
  std::fill(state.depth.begin() + static_cast<std::ptrdiff_t>(pad.size()), state.depth.end(),
            PadState::kFar);
  for (std::size_t i = 0; i < pad.size(); ++i) {
    state.depth[i] = PadState::kFar;
    if (pad.scale[i] == 0) continue;
    const Eigen::Vector3d n = pad.normal(i);
    const double distance = shape.ray_distance(X_BP * (pad.position(i) - pad.thickness() * n),
                                               X_BP.linear() * n, limit);
    if (!(distance < kInfinity)) continue;
    state.depth[i] = pad.thickness() - distance;
    any = true;
  }
  return any;
}

}  // namespace prehend::contact
#endif  // HWY_ONCE
