#include "eval/touch/imprints.h"

#include <array>
#include <cmath>
#include <map>

namespace prehend::eval::touch {
namespace {

using Eigen::Vector2d;

constexpr double kCell = 0.0005;      // m
constexpr double kHoleDepth = 0.008;  // m, more than the pads' foam gives way
constexpr double kArm = 0.0084;       // m, width of bars

bool in_box(const Vector2d& p, double x, double y, double width, double height) {
  return std::abs(p.x() - x) < width / 2 && std::abs(p.y() - y) < height / 2;
}
bool in_disc(const Vector2d& p, double y, double radius) {
  return std::hypot(p.x(), p.y() - y) < radius;
}

bool cross(const Vector2d& p) {
  return in_box(p, 0, 0, kArm, 0.0252) || in_box(p, 0, 0, 0.0252, kArm);
}
bool square(const Vector2d& p) { return in_box(p, 0, 0, 0.0168, 0.0168); }
bool disc(const Vector2d& p) { return in_disc(p, 0, 0.0119); }
bool triangle(const Vector2d& p) {
  constexpr double kSide = 0.028;
  const double height = kSide * std::sqrt(3) / 2;
  return p.y() > -height / 3 && p.y() < 2 * height / 3 - std::abs(p.x()) * std::sqrt(3);
}
bool bar(const Vector2d& p) { return in_box(p, 0, 0, kArm, 0.028); }
bool angle(const Vector2d& p) {
  return in_box(p, -kArm, 0, kArm, 0.0252) || in_box(p, 0, -kArm, 0.0252, kArm);
}
bool ring(const Vector2d& p) { return in_disc(p, 0, 0.0133) && !in_disc(p, 0, 0.0056); }
bool tee(const Vector2d& p) {
  return in_box(p, 0, kArm, 0.0252, kArm) || in_box(p, 0, 0, kArm, 0.0252);
}
bool two_discs(const Vector2d& p) {
  return in_disc(p, 0.0091, 0.0056) || in_disc(p, -0.0091, 0.0056);
}
bool half_disc(const Vector2d& p) { return in_disc(p, -0.0056, 0.0147) && p.y() > -0.0056; }

bool hexagon(const Vector2d& p) {
  constexpr double kApothem = 0.011;
  const double x = std::abs(p.x()), y = std::abs(p.y());
  return y < kApothem && x * std::sqrt(3) / 2 + y / 2 < kApothem;
}
bool ellipse(const Vector2d& p) { return std::hypot(p.x() / 0.0084, p.y() / 0.014) < 1; }
bool rectangle(const Vector2d& p) { return in_box(p, 0, 0, 0.014, 0.0235); }
bool zed(const Vector2d& p) {
  return in_box(p, -kArm / 2, kArm, 2 * kArm, kArm) || in_box(p, 0, 0, kArm, 3 * kArm) ||
         in_box(p, kArm / 2, -kArm, 2 * kArm, kArm);
}
bool channel(const Vector2d& p) {
  return in_box(p, 0, -kArm, 0.0252, kArm) || in_box(p, -kArm, 0, kArm, 0.0252) ||
         in_box(p, kArm, 0, kArm, 0.0252);
}
bool aitch(const Vector2d& p) {
  return in_box(p, 0, 0, 0.0252, kArm) || in_box(p, -kArm, 0, kArm, 0.0252) ||
         in_box(p, kArm, 0, kArm, 0.0252);
}
bool star(const Vector2d& p) {  // of three points
  const double turn = std::atan2(p.y(), p.x());
  return p.norm() < 0.0095 + 0.0045 * std::cos(3 * turn);
}
bool three_discs(const Vector2d& p) {
  constexpr double kOut = 0.0085;
  const auto near = [&](double x, double y) { return std::hypot(p.x() - x, p.y() - y) < 0.0056; };
  return near(0, kOut) || near(kOut * std::sqrt(3) / 2, -kOut / 2) ||
         near(-kOut * std::sqrt(3) / 2, -kOut / 2);
}
bool quarter_disc(const Vector2d& p) {
  const Vector2d q = p + Vector2d::Constant(0.0085);
  return q.x() > 0 && q.y() > 0 && q.norm() < 0.021;
}
bool chevron(const Vector2d& p) {
  const double y = p.y() + std::abs(p.x());
  return std::abs(p.x()) < 0.0126 && y > 0 && y < 0.0119;
}

}  // namespace

const std::vector<Hole>& holes_to_choose_on() {
  static const std::vector<Hole> kHoles{
      {"hexagon", hexagon}, {"ellipse", ellipse},         {"rectangle", rectangle},
      {"zed", zed},         {"channel", channel},         {"aitch", aitch},
      {"star", star},       {"three discs", three_discs}, {"quarter disc", quarter_disc},
      {"chevron", chevron}};
  return kHoles;
}

const std::vector<Hole>& holes() {
  static const std::vector<Hole> kHoles{
      {"cross", cross},        {"square", square}, {"disc", disc},
      {"triangle", triangle},  {"bar", bar},       {"angle", angle},
      {"ring", ring},          {"tee", tee},       {"two discs", two_discs},
      {"half disc", half_disc}};
  return kHoles;
}

geometry::TriangleMesh perforated_block(const Eigen::Vector3d& size, const BlockSide& plus_y,
                                        const BlockSide& minus_y) {
  const int columns = static_cast<int>(std::lround(size.x() / kCell));
  const int rows = static_cast<int>(std::lround(size.z() / kCell));
  const Vector2d step(size.x() / columns, size.z() / rows);
  const auto corner = [&](double i, double k) {
    return Vector2d(i * step.x() - size.x() / 2, k * step.y() - size.z() / 2);
  };
  geometry::TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  const std::array<double, 4> heights{-size.y() / 2, kHoleDepth - size.y() / 2,
                                      size.y() / 2 - kHoleDepth, size.y() / 2};
  const auto vertex = [&](int i, int level, int k) {
    const auto [entry, is_new] =
        known.try_emplace({i, level, k}, static_cast<int>(mesh.vertices.size()));
    const Vector2d p = corner(i, k);
    if (is_new) mesh.vertices.emplace_back(p.x(), heights[level], p.y());
    return entry->second;
  };
  const auto quad = [&](bool turned, int a, int b, int c, int d) {
    if (turned) std::swap(b, d);
    mesh.triangles.emplace_back(a, b, c);
    mesh.triangles.emplace_back(a, c, d);
  };
  for (const bool plus : {false, true}) {
    const BlockSide& side = plus ? plus_y : minus_y;
    const int face = plus ? 3 : 0, floor = plus ? 2 : 1;
    const auto hole = [&](int i, int k) {
      return i >= 0 && k >= 0 && i < columns && k < rows && side.hole &&
             side.hole->contains(corner(i + 0.5, k + 0.5) - side.center);
    };
    for (int i = 0; i < columns; ++i) {
      for (int k = 0; k < rows; ++k) {
        const int y = hole(i, k) ? floor : face;
        quad(plus, vertex(i, y, k), vertex(i + 1, y, k), vertex(i + 1, y, k + 1),
             vertex(i, y, k + 1));
        if (!hole(i, k)) continue;
        // Walls, seen from inside the hole.
        const auto wall = [&](int i0, int k0, int i1, int k1) {
          quad(plus, vertex(i0, face, k0), vertex(i1, face, k1), vertex(i1, floor, k1),
               vertex(i0, floor, k0));
        };
        if (!hole(i, k - 1)) wall(i, k, i + 1, k);
        if (!hole(i + 1, k)) wall(i + 1, k, i + 1, k + 1);
        if (!hole(i, k + 1)) wall(i + 1, k + 1, i, k + 1);
        if (!hole(i - 1, k)) wall(i, k + 1, i, k);
      }
    }
  }
  // The sides, as high as the block: from face to face.
  for (int i = 0; i < columns; ++i) {
    quad(false, vertex(i, 0, 0), vertex(i, 3, 0), vertex(i + 1, 3, 0), vertex(i + 1, 0, 0));
    quad(false, vertex(i, 0, rows), vertex(i + 1, 0, rows), vertex(i + 1, 3, rows),
         vertex(i, 3, rows));
  }
  for (int k = 0; k < rows; ++k) {
    quad(false, vertex(0, 0, k), vertex(0, 0, k + 1), vertex(0, 3, k + 1), vertex(0, 3, k));
    quad(false, vertex(columns, 0, k), vertex(columns, 3, k), vertex(columns, 3, k + 1),
         vertex(columns, 0, k + 1));
  }
  return mesh;
}

}  // namespace prehend::eval::touch
