#include "prehend/report/section.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/report/escaped.h"
#include "prehend/text/require.h"

namespace prehend::report {
namespace {

constexpr double kWidth = 360, kHeight = 300, kMargin = 24;  // px
constexpr double kLine = 16;                                 // px, of the legend

void check(const SectionPlane& plane) {
  constexpr double kClose = 1e-6;
  const bool is_plane = plane.origin.allFinite() && std::abs(plane.right.norm() - 1) < kClose &&
                        std::abs(plane.up.norm() - 1) < kClose &&
                        std::abs(plane.right.dot(plane.up)) < kClose;
  text::Require{"SectionPlane: "}(is_plane, "right and up must be unit vectors across one another");
}

std::string color_of(const geometry::Rgb& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

// The largest of 1, 2, 5 times a power of ten that is no longer.
double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= length) return factor * power;
  }
  return power;
}

}  // namespace

std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> section_of(
    const geometry::TriangleMesh& mesh, const SectionPlane& plane) {
  check(plane);
  const Eigen::Vector3d normal = plane.right.cross(plane.up);
  std::vector<double> height;
  for (const Eigen::Vector3d& p : mesh.vertices) height.push_back(normal.dot(p - plane.origin));
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> segments;
  for (const Eigen::Vector3i& corners : mesh.triangles) {
    std::array<Eigen::Vector2d, 2> ends;
    std::size_t found = 0;
    for (int k = 0; k < 3 && found < 2; ++k) {
      const auto a = static_cast<std::size_t>(corners[k]),
                 b = static_cast<std::size_t>(corners[(k + 1) % 3]);
      if ((height[a] >= 0) == (height[b] >= 0)) continue;
      const double share = height[a] / (height[a] - height[b]);
      const Eigen::Vector3d p =
          mesh.vertices[a] + share * (mesh.vertices[b] - mesh.vertices[a]) - plane.origin;
      ends[found++] = Eigen::Vector2d(plane.right.dot(p), plane.up.dot(p));
    }
    if (found == 2) segments.emplace_back(ends[0], ends[1]);
  }
  return segments;
}

std::string draw_section(const std::string& title, const std::vector<SectionOutline>& outlines,
                         const SectionPlane& plane) {
  std::vector<std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>> cuts;
  Eigen::AlignedBox2d box;
  for (const SectionOutline& outline : outlines) {
    cuts.push_back(section_of(*outline.mesh, plane));
    for (const auto& [a, b] : cuts.back()) {
      box.extend(a);
      box.extend(b);
    }
  }
  const double legend = kLine * static_cast<double>(outlines.size());
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" aria-label=\"{2}\"><rect width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" fill=\"#fff\"/><g font-family=\"DejaVu Sans,sans-serif\" "
      "font-size=\"12\"><text x=\"8\" y=\"16\">{2}</text>",
      kWidth, kHeight + legend, escaped(title));
  if (box.isEmpty()) return svg + "<text x=\"8\" y=\"40\">cuts nothing</text></g></svg>";
  const double longest = std::max(box.sizes().maxCoeff(), 1e-6);
  const double scale = std::min((kWidth - 2 * kMargin) / std::max(box.sizes().x(), 1e-6),
                                (kHeight - 3 * kMargin) / std::max(box.sizes().y(), 1e-6));
  const auto place = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(kWidth / 2 + scale * (p.x() - box.center().x()),
                           kHeight / 2 - scale * (p.y() - box.center().y()));
  };
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    std::string path;
    for (const auto& [a, b] : cuts[i]) {
      const Eigen::Vector2d from = place(a), to = place(b);
      path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", from.x(), from.y(), to.x(), to.y());
    }
    const std::string color = color_of(outlines[i].color);
    const double y = kHeight + kLine * (static_cast<double>(i) + 0.5);
    svg += fmt::format(
        "<path d=\"{0}\" stroke=\"{1}\" stroke-width=\"1.6\" fill=\"none\"/><path d=\"M8 "
        "{2:.0f}h18\" "
        "stroke=\"{1}\" stroke-width=\"3\"/><text x=\"32\" y=\"{3:.0f}\">{4}</text>",
        path, color, y - 4, y, escaped(outlines[i].name));
  }
  const double bar = round_length(0.4 * longest);
  svg += fmt::format(
      "<path d=\"M{:.1f} {:.1f}h{:.1f}\" stroke=\"#444\" stroke-width=\"2\"/><text x=\"{:.1f}\" "
      "y=\"{:.1f}\">{:.3g} mm</text></g></svg>",
      kWidth - kMargin - scale * bar, kHeight - 10, scale * bar, kWidth - kMargin - scale * bar,
      kHeight - 16, 1e3 * bar);
  return svg;
}

}  // namespace prehend::report
