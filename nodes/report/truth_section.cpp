#include "nodes/report/truth_section.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/convert/objects.h"
#include "nodes/report/drawn_model.h"
#include "nodes/report/true_bodies.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/report/section.h"
#include "prehend/surface/deviation.h"

namespace prehend::nodes {
namespace {

constexpr int kSamples = 5000;  // of the true surface
constexpr geometry::Rgb kTruth{40, 40, 40};

// Level, and upright along the line of sight, so that seen and unseen side are in it.
std::vector<std::string> sections_of(const geometry::TriangleMesh& predicted_W,
                                     const geometry::TriangleMesh& true_W,
                                     const geometry::Plane& table_W,
                                     const std::optional<geometry::RigidTransform>& X_WC,
                                     const std::string& name) {
  const Eigen::Vector3d middle_W = geometry::bounds(true_W).center();
  const Eigen::Vector3d up = table_W.normal;
  Eigen::Vector3d sight =
      X_WC ? Eigen::Vector3d(X_WC->translation() - middle_W) : up.unitOrthogonal();
  sight -= sight.dot(up) * up;
  if (!(sight.norm() > 1e-6)) sight = up.unitOrthogonal();  // seen straight from above
  sight.normalize();
  const Eigen::Vector3d across = up.cross(sight);
  const std::vector<report::SectionOutline> outlines{{"predicted", kMirroredColor, &predicted_W},
                                                     {"true", kTruth, &true_W}};
  const std::string side = X_WC ? ", the camera at the right" : "";
  return {report::draw_section(name + ", upright" + side, outlines, {middle_W, sight, up}),
          report::draw_section(name + ", level" + side, outlines, {middle_W, sight, across})};
}

std::string percent_of(double part, double all) {
  return all > 0 ? fmt::format("{:+.0f} %", 100 * (part / all - 1)) : "unknown";
}

}  // namespace

void add_truth(report::Page& page, const Collected& collected) {
  std::optional<geometry::RigidTransform> X_WC;
  if (collected.camera) X_WC = convert::camera_pose(*collected.camera);
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> pictures;
  for (const auto& [id, message] : collected.models) {
    if (!message.valid()) continue;
    const surface::ObjectModel model = convert::from_message(message);
    const std::optional<TrueBody> body = true_body(collected, message, model);
    if (!body) continue;
    const std::optional<geometry::TriangleMesh> mesh_B = true_mesh(collected, body->name);
    if (!mesh_B) continue;
    const geometry::TriangleMesh true_W = geometry::transformed(*mesh_B, body->X_WB);
    const double predicted = geometry::mass_properties(model.mesh_W).volume,
                 real = geometry::mass_properties(true_W).volume;
    const surface::DeviationStatistics off = surface::deviation(
        surface::sample_surface(true_W, kSamples, 1), geometry::MeshQuery(model.mesh_W));
    constexpr double kCubicCentimetre = 1e-6;
    rows.push_back(
        {fmt::format("object {}", id), body->name,
         fmt::format("{:.0f}", predicted / kCubicCentimetre),
         fmt::format("{:.0f} ({})", real / kCubicCentimetre, percent_of(predicted, real)),
         fmt::format("{:.1f}", 1e3 * off.mean), fmt::format("{:.1f}", 1e3 * off.percentile_95)});
    const std::string name = fmt::format("Object {} ({})", id, body->name);
    for (std::string& svg :
         sections_of(model.mesh_W, true_W, convert::from_message(message.table()), X_WC, name)) {
      pictures.push_back(std::move(svg));
    }
  }
  if (rows.empty()) {
    page.add_paragraph("Nothing that was predicted stands where the simulation has a body.");
    return;
  }
  page.add_table({"predicted", "it is", "volume [cm^3]", "true volume (predicted more)",
                  "true surface from the predicted, mean [mm]", "95 % of it within [mm]"},
                 rows);
  page.add_charts(pictures, "Sections through the middle of what is true.");
}

}  // namespace prehend::nodes
