#include "nodes/report/compose.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"
#include "msgs/convert/objects.h"
#include "nodes/report/charts_section.h"
#include "nodes/report/task_section.h"
#include "nodes/report/touch_section.h"
#include "prehend/geometry/errors.h"
#include "prehend/report/pictures.h"
#include "prehend/report/rejections.h"
#include "prehend/surface/size_on_table.h"

namespace prehend::nodes {
namespace {

using geometry::ColorImage;
using geometry::Rgb;
using report::Page;
using Row = std::vector<std::string>;

constexpr int kPictureWidth = 420;
constexpr int kPictureHeight = 360;
constexpr Rgb kSeenColor{40, 110, 190};
constexpr Rgb kMirroredColor{235, 130, 40};
constexpr Rgb kAssumedColor{170, 170, 175};
constexpr Rgb kObjectColor{215, 190, 150};
constexpr Rgb kOthersColor{225, 222, 215};

// Runs one part of the page; what cannot be drawn is said instead.
void section(Page& page, const std::string& heading, const std::function<void()>& write) {
  page.add_heading(heading);
  try {
    write();
  } catch (const std::exception& error) {
    page.add_paragraph(std::string("This part could not be drawn: ") + error.what());
  }
}

std::string seconds_text(double seconds) { return fmt::format("{:.3f}", seconds); }

std::string join(const std::vector<std::string>& parts, const std::string& separator) {
  std::string out;
  for (const auto& part : parts) out += (out.empty() ? "" : separator) + part;
  return out;
}

std::vector<report::Rejected> rejections_of(const msgs::GraspPlan& plan) {
  std::vector<report::Rejected> rejections;
  for (const auto& one : plan.rejections()) {
    rejections.push_back(
        {one.reason(), one.generator(), static_cast<int>(one.count()), one.nearest_miss()});
  }
  return rejections;
}

// The object of the cycle, or else the first.
std::uint32_t shown_object(const Collected& collected) {
  if (collected.result && collected.shapes.count(collected.result->object_id()) != 0) {
    return collected.result->object_id();
  }
  return collected.shapes.empty() ? 0 : collected.shapes.begin()->first;
}

// What cameras saw in colour.
std::vector<ColorImage> seen_colors(const Collected& collected) {
  if (collected.stereo) return {convert::from_message(*collected.stereo).left};
  std::vector<ColorImage> images;
  for (const auto& message : collected.clouds) {
    geometry::PointCloud cloud = convert::from_message(message);
    if (!cloud.organized() || cloud.colors.empty()) continue;
    ColorImage& image = images.emplace_back();
    image.width = cloud.width;
    image.height = cloud.height;
    image.data = std::move(cloud.colors);
  }
  return images;
}

void add_view(Page& page, const Collected& collected) {
  std::vector<ColorImage> pictures = seen_colors(collected);
  std::vector<std::string> captions(
      pictures.size(), collected.stereo ? "Left image" : "Colours of the recorded cloud");
  // Of several views nobody says which one the masks are of.
  ColorImage seen = pictures.size() == 1 ? pictures.front() : ColorImage();
  if (!collected.objects) {
    page.add_paragraph("No object hypotheses came.");
  } else {
    if (!collected.objects->problem().empty()) {
      page.add_verdict(collected.objects->problem(), false);
    }
    for (const auto& note : collected.objects->notes())
      page.add_paragraph("Assumed: " + note + ".");
    if (collected.objects->has_camera() && collected.objects->camera().width() > 0) {
      const auto scene = convert::from_message(*collected.objects);
      if (!scene.depth.empty()) {
        // Inverse depth is disparity up to the constant fx * baseline.
        geometry::Image<float> inverse = scene.depth;
        for (float& z : inverse.data) z = 1 / z;
        pictures.push_back(report::color_values(inverse));
        captions.push_back(std::string(collected.stereo ? "Disparity" : "Depth") +
                           " (red near, blue far, black unknown)");
      }
      if (seen.empty()) seen = ColorImage(scene.camera.width, scene.camera.height, {230, 230, 230});
      if (seen.width == scene.camera.width && seen.height == scene.camera.height) {
        std::vector<geometry::MaskImage> masks;
        for (const auto& object : scene.objects) masks.push_back(object.mask);
        pictures.push_back(report::overlay_masks(seen, masks));
        captions.push_back(fmt::format("Segmentation: {} object(s)", masks.size()));
      }
    }
  }
  page.add_pictures(pictures, captions);
}

Eigen::AlignedBox3d bounds_of(const std::vector<report::ColoredMesh>& meshes) {
  Eigen::AlignedBox3d box;
  for (const auto& mesh : meshes) box.extend(geometry::bounds(mesh.mesh_W));
  return box;
}

// Two cameras that show all of `box` from the given azimuth and from the opposite side.
std::vector<geometry::RigidTransform> two_views(const Eigen::AlignedBox3d& box, double azimuth) {
  const double radius = std::max(box.diagonal().norm() / 2, 0.01);
  return {report::orbit(box.center(), radius, azimuth, 0.5),
          report::orbit(box.center(), radius, azimuth + 2.4, 0.35)};
}

double azimuth_of(const Eigen::Vector3d& direction) {
  return std::atan2(direction.y(), direction.x());
}

// Length, width and height over the table, and how far they can be relied on where they were
// predicted; a known object has those of its mesh.
std::string size_text(const surface::ObjectModel& model, const msgs::ObjectModel& message) {
  if (model.mesh_W.vertices.empty()) return "no size";
  const auto table_W = convert::from_message(message.table());
  return message.has_known() ? surface::size_text(surface::size_on_table(model.mesh_W, table_W))
                             : surface::size_text(surface::predicted_size(model, table_W));
}

std::string completion_text(const msgs::CompletedShape& message) {
  std::string text = fmt::format("Completed by {}, {:.0f} % sure to be within 5 mm.",
                                 message.method(), 100 * message.confidence());
  if (!message.refused().empty()) text += " Refused: " + message.refused() + ".";
  text += fmt::format(
      " Visibility vote {:.4g}, best of {} symmetry planes: {:.0f} % of the points "
      "contradict the view, {:.0f} % coincide with what was seen.",
      message.vote(), message.hypotheses_tried(), 100 * message.evidence().contradicted(),
      100 * message.evidence().coincident());
  if (message.has_fidelity()) {
    text +=
        fmt::format(" Knobs chosen from the measured front: {} ({:.0f} ms and {:.2f} mm there).",
                    message.fidelity().knobs(), 1e3 * message.fidelity().seconds(),
                    1e3 * message.fidelity().error());
  }
  if (message.evidence().open_vessel())
    text += " It is an open vessel: its walls are seen from one side each.";
  if (message.touches_image_border()) text += " The image's border cuts it.";
  if (message.occluded_share() > 0) {
    text += fmt::format(" Other objects hide it along {:.0f} % of its outline.",
                        100 * message.occluded_share());
  }
  return text;
}

void add_shape(Page& page, const msgs::CompletedShape& message) {
  if (!message.completed()) page.add_verdict("Not completed: " + message.problem(), false);
  if (message.cloud().count() == 0) return;
  const auto shape = convert::from_message(message);
  std::vector<Rgb> colors;
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    colors.push_back(shape.origin[i] == shape::PointOrigin::kSeen ? kSeenColor : kMirroredColor);
    box.extend(shape.cloud_W.points[i].cast<double>());
  }
  const auto camera = report::picture_camera(kPictureWidth, kPictureHeight);
  const auto views = two_views(box, azimuth_of(shape.viewpoint_W - box.center()));
  page.add_pictures({report::draw_cloud(shape.cloud_W, colors, camera, views[0]),
                     report::draw_cloud(shape.cloud_W, colors, camera, views[1])},
                    {"Completed cloud from the camera's side (blue seen, orange predicted)",
                     "The same from behind"});
  if (message.completed()) page.add_paragraph(completion_text(message));
}

// The mesh in the colours of what its parts rest on; in one colour when the sender did not say.
std::vector<report::ColoredMesh> by_origin(const surface::ObjectModel& model) {
  if (model.vertex_origin.empty()) return {{model.mesh_W, kObjectColor}};
  std::vector<report::ColoredMesh> parts;
  for (const Rgb& color : {kSeenColor, kMirroredColor, kAssumedColor}) {
    parts.push_back({{model.mesh_W.vertices, {}}, color});
  }
  for (const Eigen::Vector3i& t : model.mesh_W.triangles) {
    auto least = surface::SurfaceOrigin::kSeen;
    for (const int i : t) least = std::max(least, model.vertex_origin[static_cast<std::size_t>(i)]);
    parts[static_cast<std::size_t>(least)].mesh_W.triangles.push_back(t);
  }
  return parts;
}

// The grasp of an object that was executed last, else the best one: the hand at it, and the arm.
void add_grasp(Page& page, const Collected& collected, std::uint32_t id,
               const geometry::TriangleMesh& mesh_W, const DrawnRobot& robot) {
  const auto plan = collected.plans.find(id);
  if (plan == collected.plans.end() || plan->second.grasps().empty()) return;
  int index = 0;
  if (collected.result && collected.result->object_id() == id) {
    index = std::min<int>(static_cast<int>(collected.result->grasp_index()),
                          plan->second.grasps_size() - 1);
  }
  const auto& grasp = plan->second.grasps(index);
  const auto camera = report::picture_camera(kPictureWidth, kPictureHeight);
  const double azimuth =
      azimuth_of(convert::from_message(grasp.x_wg()).linear().col(0)) + 0.5;  // rad
  std::vector<report::ColoredMesh> scene = robot.hand_at(grasp);
  scene.push_back({mesh_W, kObjectColor});
  const auto views = two_views(bounds_of(scene), azimuth);
  std::vector<ColorImage> pictures{report::draw_meshes(scene, camera, views[0]),
                                   report::draw_meshes(scene, camera, views[1])};
  std::vector<std::string> captions{
      fmt::format("Grasp {} of {}: {}, score {:.2f}, {}", index + 1, plan->second.grasps_size(),
                  robot.closing_text(grasp), grasp.score(), trust_text(grasp)),
      "The same from the other side"};
  const std::vector<report::ColoredMesh> arm = robot.arm_at(grasp);
  if (!arm.empty()) {
    scene.insert(scene.end(), arm.begin(), arm.end());
    for (const auto& [other, model] : collected.models) {
      if (other == id || !model.valid()) continue;
      scene.push_back({convert::from_message(model.mesh()), kOthersColor});
    }
    pictures.push_back(report::draw_meshes(scene, camera, two_views(bounds_of(scene), -1.1)[0]));
    captions.emplace_back("The arm at the grasp, among the other objects");
  }
  page.add_pictures(pictures, captions);
}

void add_model(Page& page, const Collected& collected, const msgs::ObjectModel& message,
               const DrawnRobot& robot) {
  if (!message.valid()) {
    page.add_verdict("No mesh: " + message.problem(), false);
    return;
  }
  const auto model = convert::from_message(message);
  const auto box = geometry::bounds(model.mesh_W);
  const auto camera = report::picture_camera(kPictureWidth, kPictureHeight);
  const auto views = two_views(box, 0.6);
  std::vector<report::ColoredMesh> pieces;
  for (std::size_t i = 0; i < model.convex_pieces_W.size(); ++i) {
    pieces.push_back({model.convex_pieces_W[i], report::category_color(static_cast<int>(i))});
  }
  const std::vector<report::ColoredMesh> parts = by_origin(model);
  page.add_pictures(
      {report::draw_meshes(parts, camera, views[0]), report::draw_meshes(parts, camera, views[1]),
       report::draw_meshes(pieces, camera, views[0])},
      {fmt::format("Mesh: {} triangles, {}; blue rests on seen points, orange on predicted ones, "
                   "grey on none; {:.0f} % of the area is guessed",
                   model.mesh_W.triangles.size(), message.mesh_defects(), 100 * model.guessed_area),
       "The same from behind", fmt::format("{} convex piece(s)", pieces.size())});
  page.add_paragraph("Length, width and height: " + size_text(model, message) + ".");

  add_grasp(page, collected, message.id(), model.mesh_W, robot);
}

void add_object(Page& page, const Collected& collected, const msgs::CompletedShape& shape,
                const DrawnRobot& robot, const std::string& heading) {
  section(page, heading, [&] {
    add_shape(page, shape);
    if (const auto model = collected.models.find(shape.id()); model != collected.models.end()) {
      add_model(page, collected, model->second, robot);
    }
    const auto plan = collected.plans.find(shape.id());
    if (plan == collected.plans.end()) return;
    if (const auto why = why_not_graspable(plan->second.problem())) {
      page.add_answer("Not graspable: " + *why);
    } else if (!plan->second.problem().empty()) {
      page.add_verdict(plan->second.problem(), false);
    }
    page.add_paragraph(fmt::format("{} of {} grasp candidates kept.", plan->second.grasps_size(),
                                   plan->second.candidates()));
    report::add_rejections(page, rejections_of(plan->second),
                           static_cast<int>(plan->second.candidates()), "candidates");
  });
}

Row surprise_row(const msgs::Surprise& surprise) {
  struct Unit {
    const char* name;
    double factor;
    const char* unit;
  };
  static const std::map<int, Unit> kUnits = {
      {msgs::Surprise::OPENING_AT_CONTACT, {"opening at contact", 1e3, "mm"}},
      {msgs::Surprise::CONTACT_AREA, {"contact area", 1e6, "mm^2"}},
      {msgs::Surprise::TACTILE_SUM, {"tactile sum", 1, "N"}},
      {msgs::Surprise::HELD_AFTER_LIFT, {"held after lift", 1, ""}},
      {msgs::Surprise::TOUCHED_TOO_EARLY, {"touched too early", 1, "N"}},
      {msgs::Surprise::FINGERS_TOUCH, {"fingers touch", 1, ""}},
      {msgs::Surprise::FINGERS_AT_CONTACT, {"fingers beyond contact", 1, "rad"}},
      {msgs::Surprise::LIFTED_WEIGHT, {"weight", 1, "N"}},
      {msgs::Surprise::HELD_WHILE_CARRIED, {"held while carried", 1, ""}},
      {msgs::Surprise::PLACED, {"placed", 1, ""}},
      {msgs::Surprise::MOTION, {"motion as planned", 1, ""}}};
  const auto it = kUnits.find(surprise.kind());
  const Unit unit = it == kUnits.end() ? Unit{"unknown", 1, ""} : it->second;
  const auto value = [&unit](double x) {
    return fmt::format("{:.1f} {}", x * unit.factor, unit.unit);
  };
  return {unit.name,
          value(surprise.predicted()),
          value(surprise.felt()),
          value(surprise.tolerance()),
          surprise.surprising() ? "surprise" : "as predicted",
          surprise.reaction()};
}

void add_tables(Page& page, const Collected& collected, const std::vector<Process>& processes) {
  section(page, "Predicted and felt", [&] {
    std::vector<Row> rows;
    for (const auto& surprise : collected.surprises) rows.push_back(surprise_row(surprise));
    if (rows.empty()) {
      page.add_paragraph("Nothing was compared: no grasp was executed.");
    } else {
      page.add_table({"what", "predicted", "felt", "tolerance", "", "reaction"}, rows);
    }
  });
  section(page, "Stage times", [&] {
    page.add_table({"stage", "seconds"}, stage_times(collected));
  });
  section(page, "Processes", [&] {
    std::vector<Row> rows;
    for (const auto& process : processes) {
      rows.push_back({process.node, fmt::format("{:.0f}", process.peak_memory / 1e6),
                      fmt::format("{:.2f}", process.cpu_time)});
    }
    if (rows.empty()) {
      page.add_paragraph("The registry did not answer.");
    } else {
      page.add_table({"node", "peak memory [MB]", "processor time [s]"}, rows);
    }
  });
  if (collected.log.empty()) return;
  section(page, "Warnings and errors", [&] {
    std::vector<Row> rows;
    for (const auto& line : collected.log) rows.push_back({line});
    page.add_table({"node and text"}, rows);
  });
}

std::string mesh_text(const msgs::ObjectModel& message) {
  std::string size;
  try {
    size = size_text(convert::from_message(message), message);
  } catch (const geometry::InputError& error) {
    size = error.what();  // the run is told in any case
  }
  return fmt::format("{}, mesh {}, {:.0f} cm^3, {:.1f} mm from seen points", size,
                     message.mesh_defects(), 1e6 * message.volume(),
                     1e3 * message.seen_deviation());
}

}  // namespace

std::vector<Row> summarize(const Collected& collected) {
  std::vector<Row> rows;
  if (collected.objects) {
    rows.push_back({"objects found", std::to_string(collected.objects->objects_size())});
  }
  for (const auto& [id, shape] : collected.shapes) {
    const std::string name = fmt::format("object {}", id);
    std::vector<std::string> parts;
    parts.push_back(shape.completed() ? fmt::format("{} points by {}, vote {:.3g}, {:.0f} % sure",
                                                    shape.cloud().count(), shape.method(),
                                                    shape.vote(), 100 * shape.confidence())
                                      : "not completed: " + shape.problem());
    if (const auto model = collected.models.find(id); model != collected.models.end()) {
      parts.push_back(model->second.valid() ? mesh_text(model->second)
                                            : "no mesh: " + model->second.problem());
    }
    if (const auto plan = collected.plans.find(id); plan != collected.plans.end()) {
      parts.push_back(plan->second.grasps().empty()
                          ? plan->second.problem()
                          : fmt::format("{} of {} grasps kept", plan->second.grasps_size(),
                                        plan->second.candidates()));
    }
    rows.push_back({name, join(parts, "; ")});
  }
  if (collected.result && collected.result->attempts() > 0) {
    rows.push_back(
        {"grasped",
         fmt::format("object {}, grasp {}, {} attempt(s){}", collected.result->object_id(),
                     collected.result->grasp_index() + 1, collected.result->attempts(),
                     collected.on_prediction ? ", executed on the predicted mesh" : "")});
    if (const auto* grasp = executed_grasp(collected)) {
      rows.push_back({"the grasp", trust_text(*grasp)});
    }
    const auto surprising = std::count_if(collected.surprises.begin(), collected.surprises.end(),
                                          [](const auto& s) { return s.surprising(); });
    rows.push_back(
        {"surprises", fmt::format("{} of {} comparisons", surprising, collected.surprises.size())});
  }
  return rows;
}

std::vector<Row> stage_times(const Collected& collected) {
  std::vector<Row> rows;
  const auto add = [&rows](const std::string& prefix, const auto& times) {
    for (const auto& time : times) {
      rows.push_back({prefix + time.stage(), seconds_text(time.seconds())});
    }
  };
  if (collected.objects) add("segmentation: ", collected.objects->times());
  for (const auto& [id, shape] : collected.shapes) {
    add(fmt::format("object {}: completion: ", id), shape.times());
  }
  for (const auto& [id, model] : collected.models) {
    add(fmt::format("object {}: meshing: ", id), model.times());
  }
  for (const auto& [id, plan] : collected.plans) {
    add(fmt::format("object {}: planning: ", id), plan.times());
  }
  if (collected.result) add("cycle (simulated time): ", collected.result->times());
  return rows;
}

Page compose_page(const std::string& title, const Collected& collected, const Verdict& verdict,
                  const DrawnRobot& robot, const std::vector<Process>& processes) {
  Page page(title);
  if (verdict.kind == Verdict::Kind::kNotGraspable) {
    page.add_answer("Not graspable: " + verdict.text);
  } else {
    page.add_verdict(verdict.text, verdict.kind == Verdict::Kind::kSuccess);
  }
  section(page, "Summary", [&] { page.add_table({"what", "result"}, summarize(collected)); });
  section(page, "What was seen", [&] { add_view(page, collected); });
  // The object of the cycle first.
  const std::uint32_t shown = shown_object(collected);
  if (const auto first = collected.shapes.find(shown); first != collected.shapes.end()) {
    add_object(page, collected, first->second, robot,
               fmt::format("Object {}, the one to grasp", shown));
  }
  for (const auto& [id, shape] : collected.shapes) {
    if (id != shown) add_object(page, collected, shape, robot, fmt::format("Object {}", id));
  }
  if (collected.task) {
    section(page, "What was done", [&] { add_task(page, *collected.task, collected.result); });
  }
  section(page, "What the pads felt", [&] { add_touch(page, collected); });
  section(page, "Over time", [&] { add_charts(page, collected); });
  add_tables(page, collected, processes);
  return page;
}

}  // namespace prehend::nodes
