#include "msgs/convert/objects.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

void write_mask(const geometry::MaskImage& mask, msgs::ObjectHypothesis& message) {
  int u0 = mask.width, v0 = mask.height, u1 = -1, v1 = -1;
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (mask.at(u, v) == 0) continue;
      u0 = std::min(u0, u);
      u1 = std::max(u1, u);
      v0 = std::min(v0, v);
      v1 = v;
    }
  }
  if (u1 < 0) return;
  const int width = u1 - u0 + 1, height = v1 - v0 + 1;
  message.set_mask_x(static_cast<std::uint32_t>(u0));
  message.set_mask_y(static_cast<std::uint32_t>(v0));
  message.set_mask_width(static_cast<std::uint32_t>(width));
  message.set_mask_height(static_cast<std::uint32_t>(height));
  std::string& bytes = *message.mutable_mask();
  bytes.resize(static_cast<std::size_t>(width) * height);
  for (int v = 0; v < height; ++v) {
    std::memcpy(&bytes[static_cast<std::size_t>(v) * width], &mask.at(u0, v0 + v), width);
  }
}

geometry::MaskImage read_mask(const msgs::ObjectHypothesis& message, int width, int height) {
  const std::uint64_t w = message.mask_width(), h = message.mask_height();
  if (message.mask_x() + w > static_cast<std::uint64_t>(width) ||
      message.mask_y() + h > static_cast<std::uint64_t>(height) || message.mask().size() != w * h) {
    throw InputError("An object's mask does not fit into its camera's image", kSenderMend);
  }
  geometry::MaskImage mask(width, height, 0);
  for (std::uint64_t v = 0; v < h; ++v) {
    if (w == 0) break;
    std::memcpy(
        &mask.at(static_cast<int>(message.mask_x()), static_cast<int>(message.mask_y() + v)),
        message.mask().data() + v * w, w);
  }
  return mask;
}

msgs::SymmetryPlane plane_message(const shape::SymmetryHypothesis& plane) {
  msgs::SymmetryPlane message;
  *message.mutable_point() = to_message(plane.point_W);
  *message.mutable_normal() = to_message(plane.normal_W);
  message.set_vote(plane.vote);
  message.set_outside(plane.outside);
  message.set_in_front(plane.in_front);
  message.set_coincident(plane.coincident);
  message.set_contradicted(plane.contradicted);
  message.set_unseen(plane.unseen);
  return message;
}

shape::SymmetryHypothesis read_plane(const msgs::SymmetryPlane& message) {
  return {from_message(message.point()),
          from_message(message.normal()),
          message.vote(),
          message.outside(),
          message.in_front(),
          message.coincident(),
          message.contradicted(),
          message.unseen()};
}

msgs::CompletionEvidence evidence_message(const shape::Evidence& evidence) {
  msgs::CompletionEvidence message;
  message.set_contradiction(evidence.contradiction);
  message.set_contradicted(evidence.contradicted);
  message.set_support(evidence.support);
  message.set_coincident(evidence.coincident);
  message.set_unseen(evidence.unseen);
  message.set_margin(evidence.margin);
  message.set_concavity(evidence.concavity);
  message.set_open_top(evidence.open_top);
  message.set_cut_by_image(evidence.cut_by_image);
  message.set_open_vessel(evidence.open_vessel());
  message.set_occluded(evidence.occluded);
  message.set_on_another(evidence.on_another);
  message.set_disagreement(evidence.disagreement);
  message.set_guessed_depth(evidence.guessed_depth);
  message.set_may_be_several(evidence.may_be_several);
  return message;
}

shape::Evidence read_evidence(const msgs::CompletionEvidence& message,
                              shape::CompletionMethod method) {
  return {method,
          message.contradiction(),
          message.contradicted(),
          message.support(),
          message.coincident(),
          message.unseen(),
          message.margin(),
          message.concavity(),
          message.open_top(),
          message.cut_by_image(),
          message.occluded(),
          message.on_another(),
          message.disagreement(),
          message.guessed_depth(),
          message.may_be_several()};
}

/// Numbers in 0..1 as bytes.
std::string pack_shares(const std::vector<float>& shares) {
  std::string bytes;
  bytes.reserve(shares.size());
  for (const float share : shares) {
    bytes.push_back(static_cast<char>(std::lround(255 * std::clamp(share, 0.f, 1.f))));
  }
  return bytes;
}

float unpack_share(char byte) {
  return static_cast<float>(static_cast<std::uint8_t>(byte) / 255.0);
}

shape::CompletionMethod method_named(const std::string& name) {
  using shape::CompletionMethod;
  for (const auto method :
       {CompletionMethod::kMirror, CompletionMethod::kRotation, CompletionMethod::kExtrusion,
        CompletionMethod::kConvexHull, CompletionMethod::kRefusedMirror}) {
    if (name == shape::name(method)) return method;
  }
  throw InputError("A completed shape made by the unknown method '" + name + "'", kSenderMend);
}

/// Support and confidence of the points, and the means over regions.
void read_points(const msgs::CompletedShape& message, shape::CompletedShape& shape) {
  const std::size_t count = shape.cloud_W.size();
  if (message.support().size() != count || message.point_confidence().size() != count) {
    throw InputError("A completed shape whose points and their supports differ in number",
                     kSenderMend);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const char support = message.support()[i];
    if (support < 0 || support > static_cast<char>(shape::PointSupport::kUnseen)) {
      throw InputError("A completed shape with a point of unknown support", kSenderMend);
    }
    shape.support.push_back(static_cast<shape::PointSupport>(support));
    shape.point_confidence.push_back(unpack_share(message.point_confidence()[i]));
  }
  shape::set_region_confidence(shape);
}

/// What senders that say nothing of single points leave open: predicted ones count as unseen, and
/// nothing is sure.
void assume_points(shape::CompletedShape& shape) {
  for (const shape::PointOrigin origin : shape.origin) {
    shape.support.push_back(origin == shape::PointOrigin::kSeen ? shape::PointSupport::kSeen
                                                                : shape::PointSupport::kUnseen);
  }
  shape.point_confidence.assign(shape.origin.size(), 0.f);
}

/// What the vertices rest on; nothing when the sender said nothing.
void read_vertices(const msgs::ObjectModel& message, surface::ObjectModel& model) {
  const std::size_t count = model.mesh_W.vertices.size();
  if (message.vertex_origin().empty() && message.vertex_confidence().empty()) return;
  if (message.vertex_origin().size() != count || message.vertex_confidence().size() != count) {
    throw InputError("An object model whose vertices and their origins differ in number",
                     kSenderMend);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const char origin = message.vertex_origin()[i];
    if (origin < 0 || origin > static_cast<char>(surface::SurfaceOrigin::kTouched)) {
      throw InputError("An object model with a vertex of unknown origin", kSenderMend);
    }
    model.vertex_origin.push_back(static_cast<surface::SurfaceOrigin>(origin));
    model.vertex_confidence.push_back(unpack_share(message.vertex_confidence()[i]));
  }
}

shape::SeenSpace read_seen_space(const msgs::CompletedShape& message) {
  const geometry::PinholeCamera camera = from_message(message.seen_camera()).left;
  const auto X_WC = camera_pose(message.seen_camera());
  if (!X_WC) throw InputError("A completed shape whose camera has no pose", kSenderMend);
  return {camera, *X_WC, unpack_depth(message.seen_depth(), camera.width, camera.height)};
}

}  // namespace

msgs::ObjectHypotheses to_message(const perception::SegmentedScene& scene) {
  msgs::ObjectHypotheses message;
  *message.mutable_camera() = to_message(geometry::StereoCamera{scene.camera, 0}, scene.X_WC);
  *message.mutable_table() = to_message(scene.table_W);
  for (const auto& object : scene.objects) {
    msgs::ObjectHypothesis& out = *message.add_objects();
    out.set_id(static_cast<std::uint32_t>(object.id));
    *out.mutable_cloud() = to_message(object.cloud_W);
    write_mask(object.mask, out);
    out.set_touches_image_border(object.touches_image_border);
    out.set_occluded_share(object.occluded_share);
    out.set_may_be_several(object.may_be_several);
    if (object.support_W) *out.mutable_support() = to_message(*object.support_W);
  }
  for (const std::string& dropped : scene.dropped) message.add_notes("not an object: " + dropped);
  message.set_depth(pack_depth(scene.depth));
  return message;
}

perception::SegmentedScene from_message(const msgs::ObjectHypotheses& message) {
  perception::SegmentedScene scene;
  scene.camera = from_message(message.camera()).left;
  const auto X_WC = camera_pose(message.camera());
  if (!X_WC) throw InputError("Object hypotheses without the camera's pose", kSenderMend);
  scene.X_WC = *X_WC;
  scene.depth = unpack_depth(message.depth(), scene.camera.width, scene.camera.height);
  scene.table_W = from_message(message.table());
  for (const auto& object : message.objects()) {
    scene.objects.push_back({static_cast<int>(object.id()),
                             from_message(object.cloud()),
                             read_mask(object, scene.camera.width, scene.camera.height),
                             object.touches_image_border(),
                             object.occluded_share(),
                             object.may_be_several(),
                             object.has_support()
                                 ? std::optional<geometry::Plane>(from_message(object.support()))
                                 : std::nullopt,
                             {}});
  }
  return scene;
}

msgs::CompletedShape to_message(const shape::CompletedShape& shape) {
  msgs::CompletedShape message;
  message.set_completed(true);
  *message.mutable_cloud() = to_message(shape.cloud_W);
  std::string& origin = *message.mutable_origin();
  origin.reserve(shape.origin.size());
  for (const auto o : shape.origin) origin.push_back(static_cast<char>(o));
  *message.mutable_symmetry_point() = to_message(shape.symmetry.point_W);
  *message.mutable_symmetry_normal() = to_message(shape.symmetry.normal_W);
  message.set_vote(shape.symmetry.vote);
  if (shape.second_symmetry) {
    *message.mutable_second_symmetry_point() = to_message(shape.second_symmetry->point_W);
    *message.mutable_second_symmetry_normal() = to_message(shape.second_symmetry->normal_W);
  }
  *message.mutable_viewpoint() = to_message(shape.viewpoint_W);
  *message.mutable_mirrored_viewpoint() = to_message(shape.mirrored_viewpoint_W);
  message.set_hypotheses_tried(static_cast<std::uint32_t>(shape.hypotheses.size()));
  message.set_method(shape::name(shape.method));
  message.set_refused(shape.refused);
  message.set_confidence(shape.confidence);
  *message.mutable_evidence() = evidence_message(shape.evidence);
  for (const auto& plane : shape.planes) *message.add_planes() = plane_message(plane);
  for (const auto support : shape.support) {
    message.mutable_support()->push_back(static_cast<char>(support));
  }
  message.set_point_confidence(pack_shares(shape.point_confidence));
  for (const auto& other : shape.alternatives) *message.add_alternatives() = to_message(other);
  for (const auto& other : shape.other_methods) *message.add_other_methods() = to_message(other);
  const shape::SeenSpace& space = shape.seen_space;
  if (!space.empty_until.empty()) {
    *message.mutable_seen_camera() =
        to_message(geometry::StereoCamera{space.camera, 0}, space.X_WC);
    message.set_seen_depth(pack_depth(space.empty_until));
  }
  for (const auto& bound_W : shape.bounds_W) *message.add_bounds() = to_message(bound_W);
  return message;
}

shape::CompletedShape from_message(const msgs::CompletedShape& message) {
  shape::CompletedShape shape;
  shape.cloud_W = from_message(message.cloud());
  if (message.origin().size() != shape.cloud_W.size()) {
    throw InputError("A completed shape whose points and origins differ in number", kSenderMend);
  }
  shape.origin.reserve(message.origin().size());
  for (const char o : message.origin()) {
    if (o < 0 || o > static_cast<char>(shape::PointOrigin::kMirroredBoth)) {
      throw InputError("A completed shape with a point of unknown origin", kSenderMend);
    }
    shape.origin.push_back(static_cast<shape::PointOrigin>(o));
  }
  shape.symmetry = {from_message(message.symmetry_point()), from_message(message.symmetry_normal()),
                    message.vote()};
  if (message.has_second_symmetry_point() && message.has_second_symmetry_normal()) {
    shape.second_symmetry =
        shape::SymmetryHypothesis{from_message(message.second_symmetry_point()),
                                  from_message(message.second_symmetry_normal())};
  }
  for (const auto& plane : message.planes()) shape.planes.push_back(read_plane(plane));
  // Absent in a shape that is not completed.
  if (!message.method().empty()) shape.method = method_named(message.method());
  if (message.has_evidence()) shape.evidence = read_evidence(message.evidence(), shape.method);
  shape.refused = message.refused();
  shape.confidence = message.confidence();
  if (message.support().empty()) {
    assume_points(shape);
  } else {
    read_points(message, shape);
  }
  shape.viewpoint_W = from_message(message.viewpoint());
  shape.mirrored_viewpoint_W = from_message(message.mirrored_viewpoint());
  const auto read_other = [](const msgs::CompletedShape& other) {
    if (other.alternatives_size() + other.other_methods_size() > 0) {
      throw InputError("An alternative shape that has alternatives itself", kSenderMend);
    }
    return from_message(other);
  };
  for (const auto& other : message.alternatives()) shape.alternatives.push_back(read_other(other));
  for (const auto& other : message.other_methods()) {
    shape.other_methods.push_back(read_other(other));
  }
  if (message.has_seen_camera()) shape.seen_space = read_seen_space(message);
  for (const auto& bound : message.bounds()) shape.bounds_W.push_back(from_message(bound));
  return shape;
}

msgs::ObjectModel to_message(const surface::ObjectModel& model) {
  msgs::ObjectModel message;
  message.set_valid(true);
  *message.mutable_mesh() = to_message(model.mesh_W);
  message.set_watertight(model.defects.watertight());
  message.set_mesh_defects(model.defects.to_string());
  for (const auto& piece : model.convex_pieces_W) *message.add_convex_pieces() = to_message(piece);
  message.set_volume(model.mass_properties.volume);
  *message.mutable_centroid() = to_message(model.mass_properties.center_of_mass);
  const Eigen::Matrix3d& inertia = model.mass_properties.unit_density_inertia;
  for (const double value :
       {inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2)}) {
    message.add_unit_density_inertia(value);
  }
  message.set_seen_deviation(model.seen_deviation);
  for (const auto origin : model.vertex_origin) {
    message.mutable_vertex_origin()->push_back(static_cast<char>(origin));
  }
  message.set_vertex_confidence(pack_shares(model.vertex_confidence));
  message.set_guessed_area(model.guessed_area);
  message.set_substitute(model.substitute);
  for (const auto& mesh_W : model.alternatives_W) *message.add_alternatives() = to_message(mesh_W);
  for (const double weight : model.shape_weights) message.add_shape_weight(weight);
  return message;
}

surface::ObjectModel from_message(const msgs::ObjectModel& message) {
  surface::ObjectModel model;
  model.mesh_W = from_message(message.mesh());
  model.defects = geometry::find_defects(model.mesh_W);
  for (const auto& piece : message.convex_pieces()) {
    model.convex_pieces_W.push_back(from_message(piece));
  }
  if (message.unit_density_inertia_size() != 6) {
    throw InputError("An object model whose inertia does not have six values", kSenderMend);
  }
  model.mass_properties.volume = message.volume();
  model.mass_properties.center_of_mass = from_message(message.centroid());
  const auto value = [&message](int i) { return message.unit_density_inertia(i); };
  model.mass_properties.unit_density_inertia << value(0), value(3), value(4),  //
      value(3), value(1), value(5),                                            //
      value(4), value(5), value(2);
  model.seen_deviation = message.seen_deviation();
  read_vertices(message, model);
  model.guessed_area = message.guessed_area();
  for (const auto& mesh : message.alternatives()) {
    model.alternatives_W.push_back(from_message(mesh));
  }
  model.shape_weights.assign(message.shape_weight().begin(), message.shape_weight().end());
  return model;
}

}  // namespace prehend::convert
