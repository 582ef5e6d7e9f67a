#include "eval/varied_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "eval/household_objects.h"
#include "eval/implicit_mesh.h"
#include "eval/varied_shapes.h"

namespace prehend::eval {
namespace {

using Eigen::Vector3d;
using Mesh = std::shared_ptr<const geometry::TriangleMesh>;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kApart = 0.005;  // m

// Bodies at their places, of which one is the scene's object.
struct Group {
  std::vector<Mesh> meshes;
  std::vector<char> symmetric;
  std::size_t object = 0;
};

double extent(const geometry::TriangleMesh& mesh, int axis) {
  return geometry::bounds(mesh).sizes()[axis];
}

simulation::Texture texture(Drawn& drawn) {
  using Pattern = simulation::Texture::Pattern;
  static constexpr Pattern kPatterns[] = {Pattern::kNoise, Pattern::kStripes, Pattern::kLabel};
  simulation::Texture made;
  made.pattern = kPatterns[drawn.one_of(3)];
  for (int k = 0; k < 3; ++k) made.color[k] = drawn.between(0.15, 0.85);
  for (int k = 0; k < 3; ++k) made.second_color[k] = drawn.between(0.5, 0.95);
  made.contrast = drawn.between(0.2, 0.5);
  return made;
}

// Equal, similar or different ones.
std::vector<simulation::Texture> textures(std::size_t count, Drawn& drawn) {
  std::vector<simulation::Texture> made{texture(drawn)};
  const int how = drawn.one_of(3);
  while (made.size() < count) {
    simulation::Texture next = how == 2 ? texture(drawn) : made.front();
    if (how == 1) {
      for (Vector3d* color : {&next.color, &next.second_color}) {
        for (int k = 0; k < 3; ++k) {
          (*color)[k] = std::clamp((*color)[k] + drawn.between(-0.1, 0.1), 0.0, 1.0);
        }
      }
    }
    made.push_back(next);
  }
  for (simulation::Texture& one : made)
    one.seed = static_cast<std::uint32_t>(drawn.one_of(1 << 30));
  return made;
}

// Any of what stands firmly by itself and is no thinner than what stands beside it.
DrawnKind upright_kind(Drawn& drawn) {
  static constexpr DrawnKind kKinds[] = {
      DrawnKind::kBox,      DrawnKind::kBox,       DrawnKind::kCylinder, DrawnKind::kCup,
      DrawnKind::kBottle,   DrawnKind::kProfileL,  DrawnKind::kProfileT, DrawnKind::kWedge,
      DrawnKind::kCylinder, DrawnKind::kRevolution};
  return kKinds[drawn.one_of(10)];
}

// Two whose outlines meet along y, or leave a gap.
Group pair(double gap, bool level, Drawn& drawn) {
  Group made;
  const double size = drawn.length(0.05, 0.18);
  DrawnSolid first, second;
  if (level) {  // as books: flush with each other on top
    const double high = size * drawn.between(0.5, 1);
    first = drawn_box({size, size * drawn.between(0.3, 0.9), high});
    second = drawn_box({size * drawn.between(0.7, 1), size * drawn.between(0.3, 0.9), high});
  } else {
    first = drawn_solid(upright_kind(drawn), size, drawn);
    second = drawn_solid(upright_kind(drawn), size * drawn.between(0.6, 1.2), drawn);
  }
  const double yaw = first.round && drawn.chance(0.5) ? drawn.between(0, 90) * kDegree : 0;
  const Mesh turned = placed(*second.mesh, Vector3d::Zero(), yaw);
  // What is round touches only where it is widest.
  const bool slides = !first.round && !second.round && yaw == 0;
  const double along = slides ? drawn.between(-0.2, 0.2) * extent(*first.mesh, 0) : 0;
  const double y = geometry::bounds(*first.mesh).max().y() - geometry::bounds(*turned).min().y();
  made.meshes = {first.mesh, placed(*turned, {along, y + gap, 0})};
  made.symmetric = {first.symmetric, second.symmetric};
  made.object = static_cast<std::size_t>(drawn.one_of(2));
  return made;
}

// Boxes or cylinders on each other, anything on top.
Group stack(int count, Drawn& drawn) {
  Group made;
  const bool round = drawn.chance(0.25);
  Vector3d room(drawn.length(0.09, 0.2), drawn.length(0.08, 0.16), 0);  // of the next one
  if (round) room.y() = room.x();
  Vector3d foot = Vector3d::Zero();
  for (int k = 0; k < count; ++k) {
    const double width = std::min(room.x(), room.y());
    const double height = std::min({drawn.length(0.025, 0.1), 0.3 / count, 1.2 * width});
    const bool top = k + 1 == count;
    DrawnSolid next =
        round ? drawn_cylinder(width / 2, height) : drawn_box({room.x(), room.y(), height});
    if (top && drawn.chance(0.4)) next = drawn_solid(upright_kind(drawn), width, drawn);
    made.meshes.push_back(placed(*next.mesh, foot));
    made.symmetric.push_back(next.symmetric);
    foot.z() += extent(*next.mesh, 2);
    // The next one's sides are flush with this one's or up to 30 mm within them; few put cans
    // exactly on each other.
    const Vector3d before = room;
    if (round) {
      const double smaller = drawn.between(0, 0.04), most = std::min(smaller / 2, 0.012);
      room.x() = room.y() = std::max(room.x() - smaller, 0.5 * room.x());
      if (drawn.chance(0.7)) {
        foot.x() += drawn.between(-most, most);
        foot.y() += drawn.between(-most, most);
      }
      continue;
    }
    for (int axis = 0; axis < 2; ++axis) {
      const double low = drawn.chance(0.4) ? 0 : drawn.between(0.003, 0.03);
      const double high = drawn.chance(0.4) ? 0 : drawn.between(0.003, 0.03);
      const double scale = std::min(1.0, 0.4 * before[axis] / std::max(low + high, 1e-9));
      room[axis] -= scale * (low + high);
      foot[axis] += scale * (low - high) / 2;
    }
  }
  made.object = static_cast<std::size_t>(drawn.one_of(count));
  return made;
}

// A can, bottle or bar whose side touches a box's edge, its foot on the table.
Group leaning(Drawn& drawn) {
  const double long_side = drawn.length(0.1, 0.22), half = long_side * drawn.between(0.08, 0.17);
  const double tilt = drawn.between(25, 65) * kDegree;
  const double edge = long_side * std::sin(tilt) * drawn.between(0.45, 0.85);  // m high
  const double cosine = std::cos(tilt), sine = std::sin(tilt);
  const bool round = drawn.chance(0.6);
  Eigen::Matrix3d R;  // the body's z along the slope, its y along the edge
  R << -sine, 0, cosine, 0, 1, 0, cosine, 0, sine;
  const Vector3d origin(0, 0, half * cosine);
  const double reach = long_side + half;
  const Implicit body = [=](const Vector3d& p) {
    const Vector3d q = R.transpose() * (p - origin);
    if (!round) {
      return solids::rounded_box(q, {0, 0, long_side / 2}, {2 * half, 3 * half, long_side}, 1e-3);
    }
    return solids::revolution(q, {{0, 0}, {half, 0}, {half, long_side}, {0, long_side}});
  };
  const double cell = std::clamp(long_side / 90, 4e-4, 6e-3);
  const Mesh leans = std::make_shared<geometry::TriangleMesh>(
      mesh_of(body, {Vector3d(-reach, -reach, -0.01), Vector3d(reach, reach, reach + half)}, cell));
  const Vector3d sides(drawn.between(0.04, 0.1), drawn.between(0.08, 0.16), edge);
  const double x = edge / std::tan(tilt) + half * sine;  // of the box's edge
  Group made;
  made.meshes = {leans, placed(*drawn_box(sides).mesh, {x + sides.x() / 2, 0, 0})};
  made.symmetric = {1, 1};
  made.object = drawn.chance(0.75) ? 0 : 1;
  return made;
}

// Something long that lies across a box.
Group lying_on(Drawn& drawn) {
  static constexpr DrawnKind kKinds[] = {DrawnKind::kCapsule, DrawnKind::kTool, DrawnKind::kBottle,
                                         DrawnKind::kRing};
  const Vector3d sides(drawn.between(0.08, 0.18), drawn.between(0.08, 0.14),
                       drawn.between(0.03, 0.1));
  const DrawnKind kind = kKinds[drawn.one_of(4)];
  const DrawnSolid solid = drawn_solid(kind, sides.x() * drawn.between(0.7, 1.3), drawn);
  const geometry::TriangleMesh lies = kind == DrawnKind::kBottle ? lying(*solid.mesh) : *solid.mesh;
  Group made;
  const double yaw = drawn.between(0, 180) * kDegree;
  const Vector3d at(drawn.between(-0.015, 0.015), drawn.between(-0.015, 0.015), sides.z());
  made.meshes = {placed(lies, at, yaw), drawn_box(sides).mesh};
  made.symmetric = {solid.symmetric, 1};
  made.object = drawn.chance(0.7) ? 0 : 1;
  return made;
}

// Boards, boxes and cans before and behind, so that one hides about a third from either side.
Group hidden(Drawn& drawn) {
  const double size = drawn.length(0.08, 0.2);
  const DrawnSolid solid = drawn_solid(upright_kind(drawn), size, drawn);
  const Eigen::AlignedBox3d box = geometry::bounds(*solid.mesh);
  Group made;
  made.meshes = {solid.mesh};
  made.symmetric = {solid.symmetric};
  for (const double side : {1.0, -1.0}) {
    const double width = box.sizes().y() * drawn.between(0.4, 0.7);
    const double high = box.sizes().z() * drawn.between(0.6, 1.1);
    const DrawnSolid before = drawn.chance(0.5) ? drawn_cylinder(std::max(width / 2, 0.008), high)
                                                : drawn_box({0.02, std::max(width, 0.016), high});
    const double deep = extent(*before.mesh, 0);
    const double x = box.max().x() + deep / 2 + drawn.between(0.015, 0.06);
    const double y =
        (box.sizes().y() / 2 - width * drawn.between(0.1, 0.4)) * (drawn.chance(0.5) ? 1 : -1);
    made.meshes.push_back(placed(*before.mesh, {side * x, y, 0}));
    made.symmetric.push_back(1);
  }
  return made;
}

// Draws the scenes of one seed.
class Scenes {
 public:
  explicit Scenes(std::uint64_t seed) : seed_(seed), drawn_(seed * 0x9E3779B97F4A7C15ULL + 1) {}

  std::vector<EvaluationObject> all() {
    for (int k = 0; k < 6; ++k) alone(k, drawn_.length(0.03, 0.3));
    for (const double gap : {0.0, 0.0, kApart}) add("pair", pair(gap, false, drawn_));
    add("level_pair", pair(0, true, drawn_));
    for (const int count : {2, 3, 4}) add(fmt::format("stack_of_{}", count), stack(count, drawn_));
    add("leaning", leaning(drawn_));
    add("lying_on", lying_on(drawn_));
    add("hidden", hidden(drawn_));
    alone(6, drawn_.length(0.06, 0.2));
    Viewing& cut = made_.back().viewing;
    cut.look_aside[drawn_.one_of(2)] = (drawn_.chance(0.5) ? 1 : -1) * drawn_.between(0.75, 0.95);
    made_.back().name += "_cut";
    if (drawn_.chance(0.5)) {
      alone(7, drawn_.length(0.009, 0.02));
      made_.back().viewing.elevation = drawn_.between(45, 75);  // lower, the table's noise hides it
    } else {
      alone(7, drawn_.length(0.35, 0.6));
    }
    return std::move(made_);
  }

 private:
  // Seeds that follow each other go through all kinds.
  void alone(int which, double size) {
    const auto kind = static_cast<DrawnKind>((seed_ * 7 + static_cast<std::uint64_t>(which)) %
                                             static_cast<std::uint64_t>(kDrawnKinds));
    const DrawnSolid solid = drawn_solid(kind, size, drawn_);
    add(name_of(kind), {{solid.mesh}, {solid.symmetric}, 0});
  }

  void add(const std::string& what, const Group& group) {
    EvaluationObject object;
    object.name = fmt::format("s{}_{:02}_{}", seed_, made_.size(), what);
    const Eigen::AlignedBox3d box = geometry::bounds(*group.meshes[group.object]);
    const Vector3d middle(-box.center().x(), -box.center().y(), 0);
    Eigen::AlignedBox3d all;
    for (std::size_t k = 0; k < group.meshes.size(); ++k) {
      Mesh moved = placed(*group.meshes[k], middle);
      all.extend(geometry::bounds(*moved));
      if (k == group.object) {
        object.mesh_B = std::move(moved);
      } else {
        object.viewing.others_B.push_back(std::move(moved));
      }
    }
    object.symmetric = group.symmetric[group.object] != 0;
    object.viewing.textures = textures(group.meshes.size(), drawn_);
    object.viewing.elevation = drawn_.between(15, 75);
    object.viewing.sensor =
        drawn_.chance(0.35) ? DepthSensor::kStructuredLight : DepthSensor::kStereo;
    // So far away that all of it is in view.
    object.viewing.distance = std::clamp(2.6 * all.diagonal().norm(), 0.7, 1.7);
    made_.push_back(std::move(object));
  }

  std::uint64_t seed_;
  Drawn drawn_;
  std::vector<EvaluationObject> made_;
};

}  // namespace

std::vector<EvaluationObject> varied_scenes(std::uint64_t seed) { return Scenes(seed).all(); }

}  // namespace prehend::eval
