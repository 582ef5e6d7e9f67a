#include "msgs/convert/foxglove_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "msgs/convert/foxglove_geometry.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using Eigen::Vector3d;

// What a vertex rests on, by SurfaceOrigin.
::foxglove::Color origin_color(char origin) {
  switch (origin) {
    case msgs::SURFACE_SEEN:
      return foxglove_color(0.30, 0.69, 0.31);
    case msgs::SURFACE_PREDICTED:
      return foxglove_color(0.13, 0.59, 0.95);
    case msgs::SURFACE_TOUCHED:
      return foxglove_color(1.0, 0.60, 0.0);
    default:
      return foxglove_color(0.62, 0.62, 0.62);
  }
}

// For objects without a colour of their own, told apart by sight.
constexpr std::array<std::array<std::uint8_t, 3>, 8> kPalette{{{31, 119, 180},
                                                               {255, 127, 14},
                                                               {44, 160, 44},
                                                               {214, 39, 40},
                                                               {148, 103, 189},
                                                               {140, 86, 75},
                                                               {227, 119, 194},
                                                               {188, 189, 34}}};

constexpr std::size_t kPointStride = 20;

void add_field(::foxglove::PointCloud& cloud, const char* name, std::uint32_t offset,
               ::foxglove::PackedElementField::NumericType type) {
  ::foxglove::PackedElementField& field = *cloud.add_fields();
  field.set_name(name);
  field.set_offset(offset);
  field.set_type(type);
}

void append_points(const msgs::ObjectHypothesis& object, std::string& data) {
  const msgs::PointCloud& cloud = object.cloud();
  const std::size_t stride = cloud.stride(), least = cloud.has_color() ? 16 : 12;
  if (cloud.data().size() != cloud.count() * stride || (cloud.count() > 0 && stride < least)) {
    throw geometry::InputError("A cloud's data has another size than its counts say", kSenderMend);
  }
  const auto& plain = kPalette[object.id() % kPalette.size()];
  const auto number =
      static_cast<std::uint16_t>(std::min<std::uint32_t>(object.id(), kNoObject - 1));
  std::size_t to = data.size();
  data.resize(to + cloud.count() * kPointStride);
  for (std::size_t i = 0; i < cloud.count(); ++i) {
    const char* from = cloud.data().data() + i * stride;
    float xyz[3];
    std::memcpy(xyz, from, sizeof xyz);
    if (!std::isfinite(xyz[0] + xyz[1] + xyz[2])) continue;
    char* out = data.data() + to;
    std::memcpy(out, xyz, sizeof xyz);
    if (cloud.has_color()) {
      std::memcpy(out + 12, from + 12, 3);
    } else {
      std::memcpy(out + 12, plain.data(), 3);
    }
    out[15] = static_cast<char>(255);
    std::memcpy(out + 16, &number, sizeof number);
    to += kPointStride;
  }
  data.resize(to);
}

void add_text(::foxglove::SceneEntity& entity, const Vector3d& place, const std::string& text) {
  ::foxglove::TextPrimitive& primitive = *entity.add_texts();
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = place;
  *primitive.mutable_pose() = foxglove_pose(X);
  primitive.set_billboard(true);
  primitive.set_font_size(14);
  primitive.set_scale_invariant(true);
  *primitive.mutable_color() = foxglove_color(0.9, 0.2, 0.2);
  primitive.set_text(text);
}

void add_sphere(::foxglove::SceneEntity& entity, const Vector3d& center, double diameter,
                const ::foxglove::Color& color) {
  ::foxglove::SpherePrimitive& sphere = *entity.add_spheres();
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.translation() = center;
  *sphere.mutable_pose() = foxglove_pose(X);
  *sphere.mutable_size() = foxglove_vector(Vector3d::Constant(diameter));
  *sphere.mutable_color() = color;
}

std::string grasp_id(std::uint32_t object, int rank) {
  return fmt::format("grasp/{}/{}", object, rank);
}

std::string no_grasp_id(std::uint32_t object) { return fmt::format("grasp/{}/none", object); }

std::string ledger_text(const msgs::GraspPlan& plan) {
  std::string text;
  for (const msgs::RejectionCount& rejection : plan.rejections()) {
    text +=
        fmt::format("{}{} x {}{}", text.empty() ? "" : "; ", rejection.count(), rejection.reason(),
                    rejection.nearest_miss().empty() ? "" : " (" + rejection.nearest_miss() + ")");
  }
  return text;
}

// The chance that the object is lifted with this grasp, where the plan knows it.
std::optional<double> success_of(const msgs::GraspPlan& plan, int rank) {
  for (const msgs::Choice& choice : plan.choices()) {
    if (choice.act() == msgs::Choice::GRASP && choice.grasp() == rank) return choice.success();
  }
  return std::nullopt;
}

::foxglove::SceneEntity grasp_entity(const msgs::GraspPlan& plan, int rank, double share) {
  const msgs::Grasp& grasp = plan.grasps(rank);
  auto entity = foxglove_entity(grasp_id(plan.id(), rank), object_frame(plan.id()),
                                plan.header().stamp(), true);
  const auto color = foxglove_color(1 - share, 0.2 + 0.6 * share, 0.2, rank == 0 ? 1.0 : 0.5);
  const geometry::RigidTransform X_WG = from_message(grasp.x_wg());
  const Vector3d approach = from_message(grasp.approach_direction());
  if (approach.norm() > 0.5) {
    constexpr double kShaft = 0.06, kHead = 0.02;  // m
    ::foxglove::ArrowPrimitive& arrow = *entity.add_arrows();
    *arrow.mutable_pose() =
        foxglove_pose_along(X_WG.translation() - (kShaft + kHead) * approach, approach);
    arrow.set_shaft_length(kShaft);
    arrow.set_shaft_diameter(0.004);
    arrow.set_head_length(kHead);
    arrow.set_head_diameter(0.010);
    *arrow.mutable_color() = color;
  }
  for (const msgs::Vector3& contact : grasp.contacts()) {
    add_sphere(entity, from_message(contact), 0.008, color);
  }
  if (grasp.contacts().empty() && grasp.pregrasp_opening() > 0) {
    // Jaws: where their pads meet it, along the closing direction.
    const double half = grasp.predicted().opening() > 0 ? grasp.predicted().opening() / 2
                                                        : grasp.pregrasp_opening() / 2;
    for (const double side : {-half, half}) {
      add_sphere(entity, X_WG * Vector3d(0, side, 0), 0.008, color);
    }
  }
  add_metadata(entity, "object", std::to_string(plan.id()));
  add_metadata(entity, "rank", std::to_string(rank));
  add_metadata(entity, "score", grasp.score());
  add_metadata(entity, "quality", grasp.quality());
  if (const auto success = success_of(plan, rank)) {
    add_metadata(entity, "success probability", *success);
  }
  if (grasp.has_robustness()) add_metadata(entity, "robustness", grasp.robustness());
  if (grasp.pregrasp_opening() > 0) add_metadata(entity, "width", grasp.predicted().opening());
  add_metadata(entity, "force", grasp.grasp_force());
  add_metadata(entity, "generator", grasp.generator());
  add_metadata(entity, "preshape", grasp.preshape());
  if (!grasp.remark().empty()) add_metadata(entity, "remark", grasp.remark());
  return entity;
}

}  // namespace

std::string object_frame(std::uint32_t id) { return fmt::format("object/{}", id); }

::foxglove::SceneEntity object_entity(const msgs::ObjectModel& model) {
  auto entity = foxglove_entity(object_frame(model.id()), object_frame(model.id()),
                                model.header().stamp(), true);
  if (model.valid() && model.mesh().triangle_count() > 0) {
    ::foxglove::TriangleListPrimitive& mesh = *entity.add_triangles();
    mesh = foxglove_triangles(model.mesh());
    const std::string& origin = model.vertex_origin();
    const bool known = origin.size() == static_cast<std::size_t>(mesh.points_size());
    for (int i = 0; i < mesh.points_size(); ++i) {
      *mesh.add_colors() =
          origin_color(known ? origin[static_cast<std::size_t>(i)] : char(msgs::SURFACE_ASSUMED));
    }
  }
  add_metadata(entity, "object", std::to_string(model.id()));
  add_metadata(entity, "confidence", model.confidence());
  add_metadata(entity, "volume", model.volume());
  add_metadata(entity, "guessed_area", model.guessed_area());
  add_metadata(entity, "method", model.method());
  add_metadata(entity, "watertight", std::string(model.watertight() ? "true" : "false"));
  if (!model.problem().empty()) add_metadata(entity, "problem", model.problem());
  if (!model.substitute().empty()) add_metadata(entity, "substitute", model.substitute());
  if (model.has_known()) add_metadata(entity, "known", model.known().name());
  return entity;
}

::foxglove::PointCloud objects_cloud(const msgs::ObjectHypotheses& objects) {
  using Field = ::foxglove::PackedElementField;
  ::foxglove::PointCloud cloud;
  *cloud.mutable_timestamp() = foxglove_time(objects.header().stamp());
  cloud.set_frame_id(kWorldFrame);
  *cloud.mutable_pose() = foxglove_pose(geometry::RigidTransform::Identity());
  cloud.set_point_stride(kPointStride);
  add_field(cloud, "x", 0, Field::FLOAT32);
  add_field(cloud, "y", 4, Field::FLOAT32);
  add_field(cloud, "z", 8, Field::FLOAT32);
  add_field(cloud, "red", 12, Field::UINT8);
  add_field(cloud, "green", 13, Field::UINT8);
  add_field(cloud, "blue", 14, Field::UINT8);
  add_field(cloud, "alpha", 15, Field::UINT8);
  add_field(cloud, "object", 16, Field::UINT16);
  for (const msgs::ObjectHypothesis& object : objects.objects()) {
    append_points(object, *cloud.mutable_data());
  }
  return cloud;
}

::foxglove::SceneUpdate table_update(const msgs::ObjectHypotheses& objects) {
  ::foxglove::SceneUpdate update;
  if (!objects.has_table()) return update;
  const geometry::Plane table = from_message(objects.table());
  constexpr double kSide = 1.0, kThickness = 0.005;  // m
  Vector3d center = Vector3d::Zero();
  double count = 0;
  for (const msgs::ObjectHypothesis& object : objects.objects()) {
    const msgs::PointCloud& cloud = object.cloud();
    if (cloud.stride() < 12 || cloud.data().size() < cloud.stride()) continue;
    float xyz[3];
    std::memcpy(xyz, cloud.data().data(), sizeof xyz);
    if (!std::isfinite(xyz[0] + xyz[1] + xyz[2])) continue;
    center += Vector3d(xyz[0], xyz[1], xyz[2]);
    ++count;
  }
  if (count > 0) center /= count;
  center -= (table.normal.dot(center) - table.offset) * table.normal;
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), table.normal).toRotationMatrix();
  X.translation() = center - kThickness / 2 * table.normal;
  auto& entity = *update.add_entities();
  entity = foxglove_entity("table", kWorldFrame, objects.header().stamp(), false);
  ::foxglove::CubePrimitive& cube = *entity.add_cubes();
  *cube.mutable_pose() = foxglove_pose(X);
  *cube.mutable_size() = foxglove_vector({kSide, kSide, kThickness});
  *cube.mutable_color() = foxglove_color(0.55, 0.50, 0.45, 0.6);
  return update;
}

::foxglove::SceneUpdate truth_update(const msgs::GroundTruth& truth) {
  ::foxglove::SceneUpdate update;
  for (const msgs::GroundTruth::Body& body : truth.bodies()) {
    const geometry::RigidTransform X_WB = from_message(body.x_wb());
    auto& entity = *update.add_entities();
    entity = foxglove_entity("truth/" + body.name(), kWorldFrame, truth.header().stamp(), false);
    add_text(entity, X_WB.translation(), body.name());
    add_metadata(entity, "mass", body.mass());
    add_metadata(entity, "height", body.height());
  }
  return update;
}

::foxglove::SceneUpdate grasps_update(const msgs::GraspPlan& plan, int most, int before) {
  ::foxglove::SceneUpdate update;
  const std::int64_t stamp = plan.header().stamp();
  const int count = std::min(most, plan.grasps_size());
  for (int rank = count; rank < before; ++rank) {
    add_deletion(update, grasp_id(plan.id(), rank), stamp);
  }
  if (count > 0) add_deletion(update, no_grasp_id(plan.id()), stamp);
  const double best = count > 0 ? plan.grasps(0).score() : 0;
  const double worst = count > 0 ? plan.grasps(count - 1).score() : 0;
  for (int rank = 0; rank < count; ++rank) {
    const double share = best > worst ? (plan.grasps(rank).score() - worst) / (best - worst) : 1.0;
    *update.add_entities() = grasp_entity(plan, rank, std::clamp(share, 0.0, 1.0));
  }
  if (count > 0) return update;
  auto& entity = *update.add_entities();
  entity = foxglove_entity(no_grasp_id(plan.id()), object_frame(plan.id()), stamp, true);
  if (plan.has_centroid()) {
    add_text(entity, from_message(plan.centroid()) + Vector3d(0, 0, 0.1), plan.problem());
  }
  add_metadata(entity, "object", std::to_string(plan.id()));
  add_metadata(entity, "problem", plan.problem());
  add_metadata(entity, "ledger", ledger_text(plan));
  return update;
}

}  // namespace prehend::convert
