// Compiled once for each instruction set by Highway's foreach_target.h, which includes it again.
#include "prehend/motion/batch_kernel.h"

#include <cstddef>
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

/// What a frame does on its way from the middle of a piece to its end: a point at p goes `way` and
/// the cross product of `turn` and p.
struct Twist {
  Point turn, way;
};

HWY_INLINE Point cross(const Point& a, const Point& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

HWY_INLINE Point minus(const Point& a, const Point& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

HWY_INLINE V length(const Point& p) { return hn::Sqrt(squared(p.x, p.y, p.z)); }

HWY_INLINE Point scaled(const Point& p, V by) {
  return {hn::Mul(p.x, by), hn::Mul(p.y, by), hn::Mul(p.z, by)};
}

/// @param after the pose of the frame after the joint, which moves by `way`
HWY_INLINE Twist move_on(const Twist& before, const Pose& after, bool is_revolute, float way) {
  const Point axis = scaled(after.c, set(way));
  if (!is_revolute) return {before.turn, add(before.way, axis)};
  return {add(before.turn, axis), add(before.way, cross(after.t, axis))};
}

/// By how much the balls of a node at p are larger on a sweep, at most.
HWY_INLINE V swell(const Twist& twist, const BatchScene::Node& node, const Point& p, float bow) {
  const V way = length(add(twist.way, cross(twist.turn, p)));
  const V all = hn::MulAdd(length(twist.turn), set(node.spread), way);
  return hn::Max(hn::Zero(D()), hn::Add(all, set(bow)));
}

/// Where the joints' frames are, and, on a sweep, where they go.
template <bool kSwept>
struct Frames {
  Pose poses[17];
  Twist twists[kSwept ? 17 : 1];
  const SweepBounds* bounds = nullptr;

  HWY_INLINE void find(const BatchScene& scene, const float* q) {
    const D d;
    const V zero = hn::Zero(d), one = set(1);
    poses[0].a = {one, zero, zero};
    poses[0].b = {zero, one, zero};
    poses[0].c = {zero, zero, one};
    poses[0].t = {zero, zero, zero};
    if constexpr (kSwept) {
      twists[0].turn = twists[0].way = {zero, zero, zero};
    }
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      move(poses[j], scene.joints[j], hn::LoadU(d, q + j * kBatch), poses[j + 1]);
      if constexpr (kSwept) {
        twists[j + 1] =
            move_on(twists[j], poses[j + 1], scene.joints[j].is_revolute, bounds->way[j]);
      }
    }
  }

  /// Towards obstacles.
  HWY_INLINE V swell_in_world(int joint, const BatchScene::Node& node, const Point& p) const {
    if constexpr (!kSwept) return hn::Zero(D());
    const auto at = static_cast<std::size_t>(joint + 1);
    return swell(twists[at], node, p, bounds->bow_in_world[at]);
  }
};

/// Lanes that touch, and on a sweep those that may (all of the former among them).
struct Lanes {
  M touch, may;
};

HWY_INLINE V over(const BatchScene::Face& face, const Point& p) {
  return hn::MulAdd(p.x, set(face.x),
                    hn::MulAdd(p.y, set(face.y), hn::MulSub(p.z, set(face.z), set(face.offset))));
}

HWY_INLINE V beyond(V coordinate, float half) { return hn::Sub(hn::Abs(coordinate), set(half)); }

/// Square of the distance from a box, of which these are the distances beyond its sides.
HWY_INLINE V outside(V x, V y, V z) {
  const V zero = hn::Zero(D());
  return squared(hn::Max(x, zero), hn::Max(y, zero), hn::Max(z, zero));
}

/// The least that a ball counts for when only what is certainly far is sorted out.
constexpr float kLeastReach = 1e-6f;

HWY_INLINE M is_near_bounds(const BatchScene::Obstacle& obstacle, const Point& p, V reach) {
  const V x = beyond(hn::Sub(p.x, set(obstacle.center[0])), obstacle.half[0]);
  const V y = beyond(hn::Sub(p.y, set(obstacle.center[1])), obstacle.half[1]);
  const V z = beyond(hn::Sub(p.z, set(obstacle.center[2])), obstacle.half[2]);
  const V most = hn::Max(reach, set(kLeastReach));
  return hn::Lt(outside(x, y, z), hn::Mul(most, most));
}

HWY_INLINE V coordinate(const BatchScene::Obstacle& box, std::size_t row, const Point& p) {
  return hn::MulAdd(p.x, set(box.R[3 * row]),
                    hn::MulAdd(p.y, set(box.R[3 * row + 1]),
                               hn::MulAdd(p.z, set(box.R[3 * row + 2]), set(box.t[row]))));
}

/// Lanes in which something within `reach` of p may touch the obstacle: quick, never too few.
HWY_INLINE M is_near(const BatchScene& scene, const BatchScene::Obstacle& obstacle, const Point& p,
                     V reach) {
  using Kind = BatchScene::Obstacle::Kind;
  switch (obstacle.kind) {
    case Kind::kPlane:
      return hn::Lt(over(scene.faces[static_cast<std::size_t>(obstacle.first)], p), reach);
    case Kind::kBox: {
      const V most = hn::Max(reach, set(kLeastReach));
      return hn::Lt(outside(beyond(coordinate(obstacle, 0, p), obstacle.sides[0]),
                            beyond(coordinate(obstacle, 1, p), obstacle.sides[1]),
                            beyond(coordinate(obstacle, 2, p), obstacle.sides[2])),
                    hn::Mul(most, most));
    }
    default:
      return is_near_bounds(obstacle, p, reach);
  }
}

/// Signed distance of p from the obstacle, as CollisionWorld's; of a convex piece, no less than
/// `enough` may be any such value.
HWY_INLINE V distance(const BatchScene& scene, const BatchScene::Obstacle& obstacle, const Point& p,
                      V enough) {
  using Kind = BatchScene::Obstacle::Kind;
  const D d;
  switch (obstacle.kind) {
    case Kind::kBox: {
      const V x = beyond(coordinate(obstacle, 0, p), obstacle.sides[0]);
      const V y = beyond(coordinate(obstacle, 1, p), obstacle.sides[1]);
      const V z = beyond(coordinate(obstacle, 2, p), obstacle.sides[2]);
      const V inside = hn::Min(hn::Zero(d), hn::Max(x, hn::Max(y, z)));
      return hn::Add(hn::Sqrt(outside(x, y, z)), inside);
    }
    case Kind::kSphere: {
      const BatchScene::Ball& ball = obstacle.ball;
      return hn::Sub(
          length({hn::Sub(p.x, set(ball.x)), hn::Sub(p.y, set(ball.y)), hn::Sub(p.z, set(ball.z))}),
          set(ball.radius));
    }
    default: {
      V most = set(-1e30f);
      for (int i = obstacle.first; i < obstacle.last; ++i) {
        most = hn::Max(most, over(scene.faces[static_cast<std::size_t>(i)], p));
        if (hn::AllTrue(d, hn::Ge(most, enough))) break;
      }
      return most;
    }
  }
}

/// Adds the lanes in which balls of the tree touch the obstacle. Those that may already are not
/// looked at again.
template <bool kSwept>
HWY_INLINE void walk(const BatchScene& scene, const Frames<kSwept>& frames,
                     const BatchScene::Tree& tree, const BatchScene::Obstacle& obstacle,
                     Lanes& lanes) {
  const D d;
  const Pose& X = frames.poses[tree.joint + 1];
  const float margin = obstacle.margin[static_cast<std::size_t>(tree.part)];
  for (int i = tree.first; i < tree.last;) {
    const BatchScene::Node& node = scene.nodes[static_cast<std::size_t>(i)];
    const Point p = at(X, node.ball);
    const V reach = set(node.ball.radius + margin);
    const V most = kSwept ? hn::Add(reach, frames.swell_in_world(tree.joint, node, p)) : reach;
    const M near = hn::AndNot(lanes.may, is_near(scene, obstacle, p, most));
    if (hn::AllFalse(d, near)) {
      i = node.next;
      continue;
    }
    ++i;
    if (node.leaf < 0) continue;
    const V from = distance(scene, obstacle, p, most);
    const M may = hn::And(near, hn::Lt(from, most));
    lanes.may = hn::Or(lanes.may, may);
    if constexpr (kSwept) lanes.touch = hn::Or(lanes.touch, hn::And(may, hn::Lt(from, reach)));
  }
  if constexpr (!kSwept) lanes.touch = lanes.may;
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

/// Two trees of the robot, as they move against each other.
template <bool kSwept>
class Meeting {
 public:
  HWY_INLINE Meeting(const BatchScene& scene, const Frames<kSwept>& frames,
                     const BatchScene::TreePair& pair)
      : scene_(scene),
        pair_(pair),
        first_(scene.trees[static_cast<std::size_t>(pair.a)]),
        second_(scene.trees[static_cast<std::size_t>(pair.b)]),
        X_(frames.poses[first_.joint + 1]),
        Y_(frames.poses[second_.joint + 1]) {
    if constexpr (!kSwept) return;
    const auto a = static_cast<std::size_t>(first_.joint + 1);
    const auto b = static_cast<std::size_t>(second_.joint + 1);
    twist_ = {minus(frames.twists[b].turn, frames.twists[a].turn),
              minus(frames.twists[b].way, frames.twists[a].way)};
    bow_ = frames.bounds->bow[a * (SweepBounds::kMost + 1) + b];
  }

  /// Adds the lanes in which balls touch. Nodes that are near are taken apart, the larger first.
  /// @param p, q centres of the trees' roots
  HWY_INLINE void add_lanes(const Point& p, const Point& q, Lanes& lanes) {
    count_ = 0;
    take(first_.first, second_.first, p, q, lanes);
    while (count_ > 0) {
      const NodePair pair = pairs_[--count_];
      const BatchScene::Node &a = node(pair.a), &b = node(pair.b);
      if (b.leaf >= 0 || (a.leaf < 0 && a.ball.radius > b.ball.radius)) {
        const Point at_b = at(Y_, b.ball);
        for (int child = pair.a + 1; child < a.next; child = node(child).next) {
          take(child, pair.b, at(X_, node(child).ball), at_b, lanes);
        }
      } else {
        const Point at_a = at(X_, a.ball);
        for (int child = pair.b + 1; child < b.next; child = node(child).next) {
          take(pair.a, child, at_a, at(Y_, node(child).ball), lanes);
        }
      }
    }
  }

 private:
  const BatchScene::Node& node(int i) const { return scene_.nodes[static_cast<std::size_t>(i)]; }

  /// Looks whether two nodes, with centres p and q, are as near as balls that touch can be; balls
  /// that are count, others are kept.
  HWY_INLINE void take(int i, int k, const Point& p, const Point& q, Lanes& lanes) {
    const BatchScene::Node &a = node(i), &b = node(k);
    const M near = hn::AndNot(lanes.may, are_nearer(p, q, most(a, b, q)));
    if (hn::AllFalse(D(), near)) return;
    if (a.leaf < 0 || b.leaf < 0) {
      pairs_[count_++] = {i, k};
      return;
    }
    if (!pair_.must_not.empty() &&
        !pair_.must_not[static_cast<std::size_t>(a.leaf * second_.leaves + b.leaf)]) {
      return;
    }
    lanes.may = hn::Or(lanes.may, near);
    const M touch = are_nearer(p, q, set(a.ball.radius + b.ball.radius));
    lanes.touch = hn::Or(lanes.touch, hn::And(near, touch));
  }

  /// Of the way of `b`, seen from `a`, which stands still there.
  HWY_INLINE V most(const BatchScene::Node& a, const BatchScene::Node& b, const Point& q) const {
    const V reach = set(a.ball.radius + b.ball.radius);
    return kSwept ? hn::Add(reach, swell(twist_, b, q, bow_)) : reach;
  }
  static HWY_INLINE M are_nearer(const Point& p, const Point& q, V reach) {
    const Point way = minus(p, q);
    return hn::Lt(squared(way.x, way.y, way.z), hn::Mul(reach, reach));
  }

  const BatchScene& scene_;
  const BatchScene::TreePair& pair_;
  const BatchScene::Tree &first_, &second_;
  const Pose &X_, &Y_;
  Twist twist_;
  float bow_ = 0;
  // Each of two trees is at most 31 nodes deep, and a node has at most 8 under it. Not set to
  // anything before it is used: that would take longer than all else.
  struct NodePair {
    int a, b;
  };
  NodePair pairs_[2 * 31 * 8];
  int count_ = 0;
};

/// `roots`: room for 3 x kBatch numbers for each tree.
template <bool kSwept>
HWY_INLINE Lanes touching(const BatchScene& scene, const float* q, bool stop_at_first,
                          const SweepBounds* bounds, float* roots) {
  const D d;
  Frames<kSwept> frames;
  frames.bounds = bounds;
  frames.find(scene, q);
  Lanes lanes{hn::FirstN(d, 0), hn::FirstN(d, 0)};
  const auto is_done = [&] {
    return (stop_at_first && !hn::AllFalse(d, lanes.touch)) || hn::AllTrue(d, lanes.may);
  };
  for (std::size_t t = 0; t < scene.trees.size(); ++t) {
    const BatchScene::Tree& tree = scene.trees[t];
    const BatchScene::Node& root = scene.nodes[static_cast<std::size_t>(tree.first)];
    const Point p = at(frames.poses[tree.joint + 1], root.ball);
    store(p, roots, t);
    if (tree.joint < 0) continue;  // what stands with the base never moves
    const V reach = hn::Add(set(root.ball.radius), frames.swell_in_world(tree.joint, root, p));
    for (const int i : tree.obstacles) {
      const BatchScene::Obstacle& obstacle = scene.obstacles[static_cast<std::size_t>(i)];
      const V far = hn::Add(reach, set(obstacle.margin[static_cast<std::size_t>(tree.part)]));
      const M near = obstacle.kind == BatchScene::Obstacle::Kind::kPlane
                         ? is_near(scene, obstacle, p, far)
                         : is_near_bounds(obstacle, p, far);
      if (hn::AllFalse(d, hn::AndNot(lanes.may, near))) continue;
      walk<kSwept>(scene, frames, tree, obstacle, lanes);
      if (is_done()) return lanes;
    }
  }
  for (const BatchScene::TreePair& pair : scene.tree_pairs) {
    const auto a = static_cast<std::size_t>(pair.a), b = static_cast<std::size_t>(pair.b);
    Meeting<kSwept>(scene, frames, pair).add_lanes(load(roots, a), load(roots, b), lanes);
    if (is_done()) return lanes;
  }
  return lanes;
}

float* room_for_roots(const BatchScene& scene) {
  thread_local std::vector<float> room;
  room.resize(3 * kBatch * scene.trees.size());
  return room.data();
}

HWY_INLINE std::uint32_t bits_of(M mask, std::size_t lanes, std::size_t first) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), mask, bits);
  return static_cast<std::uint32_t>(bits[0] & ((1u << lanes) - 1)) << first;
}

std::uint32_t touching_lanes(const BatchScene& scene, const float* q, bool stop_at_first) {
  const std::size_t lanes = hn::Lanes(D());
  float* roots = room_for_roots(scene);
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < kBatch; first += lanes) {
    const Lanes touch = touching<false>(scene, q + first, stop_at_first, nullptr, roots);
    result |= bits_of(touch.touch, lanes, first);
    if (stop_at_first && result != 0) break;
  }
  return result;
}

SweptLanes swept_lanes(const BatchScene& scene, const float* q, const SweepBounds& bounds) {
  const std::size_t lanes = hn::Lanes(D());
  float* roots = room_for_roots(scene);
  SweptLanes result;
  for (std::size_t first = 0; first < kBatch && result.touch == 0; first += lanes) {
    const Lanes swept = touching<true>(scene, q + first, true, &bounds, roots);
    result.touch |= bits_of(swept.touch, lanes, first);
    result.may_touch |= bits_of(swept.may, lanes, first);
  }
  return result;
}

}  // namespace prehend::motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace prehend::motion {
namespace {

HWY_EXPORT(touching_lanes);
HWY_EXPORT(swept_lanes);

}  // namespace

std::uint32_t touching_lanes(const BatchScene& scene, const float* q, bool stop_at_first) {
  return HWY_DYNAMIC_DISPATCH(touching_lanes)(scene, q, stop_at_first);
}

SweptLanes swept_lanes(const BatchScene& scene, const float* q, const SweepBounds& bounds) {
  return HWY_DYNAMIC_DISPATCH(swept_lanes)(scene, q, bounds);
}

}  // namespace prehend::motion
#endif
