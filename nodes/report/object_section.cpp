#include "nodes/report/object_section.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/convert/outcomes.h"
#include "nodes/report/drawn_model.h"
#include "nodes/report/verdict.h"
#include "prehend/report/pictures.h"
#include "prehend/report/rejections.h"
#include "prehend/surface/size_on_table.h"

namespace prehend::nodes {
namespace {

using geometry::ColorImage;
using geometry::Rgb;
using report::Page;

constexpr Rgb kOthersColor{225, 222, 215};

std::vector<report::Rejected> rejections_of(const msgs::GraspPlan& plan) {
  std::vector<report::Rejected> rejections;
  for (const auto& one : plan.rejections()) {
    rejections.push_back(
        {one.reason(), one.generator(), static_cast<int>(one.count()), one.nearest_miss()});
  }
  return rejections;
}

Eigen::AlignedBox3d bounds_of(const std::vector<report::ColoredMesh>& meshes) {
  Eigen::AlignedBox3d box;
  for (const auto& mesh : meshes) box.extend(geometry::bounds(mesh.mesh_W));
  return box;
}

double azimuth_of(const Eigen::Vector3d& direction) {
  return std::atan2(direction.y(), direction.x());
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
    text += fmt::format(" Knobs chosen from the measured front: {} (there {}).",
                        message.fidelity().knobs(), message.fidelity().measured());
  }
  if (message.evidence().open_vessel())
    text += " It is an open vessel: its walls are seen from one side each.";
  if (message.touches_image_border()) text += " The image's border or max_height cuts it.";
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
  const auto camera = object_camera();
  const auto views = two_views(box, azimuth_of(shape.viewpoint_W - box.center()));
  page.add_pictures({report::draw_cloud(shape.cloud_W, colors, camera, views[0]),
                     report::draw_cloud(shape.cloud_W, colors, camera, views[1])},
                    {"Completed cloud from the camera's side (blue seen, orange predicted)",
                     "The same from behind"});
  if (message.completed()) page.add_paragraph(completion_text(message));
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
  const auto camera = object_camera();
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
  const auto camera = object_camera();
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

void add_choices(Page& page, const msgs::GraspPlan& plan) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& choice : plan.choices()) {
    rows.push_back({fmt::format("{:.0f}", choice.worth()), fmt::format("{:.2f}", choice.success()),
                    choice.text()});
  }
  if (!rows.empty()) page.add_table({"worth [s]", "lifted", "what may be done with it"}, rows);
}

void add_remedies(Page& page, const msgs::GraspPlan& plan) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& remedy : plan.remedies()) {
    rows.push_back({remedy.text(), std::to_string(remedy.grasps())});
  }
  for (const std::string& one : plan.remedies_in_vain()) rows.push_back({"with " + one, "0"});
  if (plan.remedies_incomplete()) rows.push_back({"more was not tried in time", "-"});
  if (!rows.empty()) page.add_table({"what would help", "grasps then"}, rows);
}

}  // namespace

void section(report::Page& page, const std::string& heading, const std::function<void()>& write) {
  page.add_heading(heading);
  try {
    write();
  } catch (const std::exception& error) {
    page.add_paragraph(std::string("This part could not be drawn: ") + error.what());
  }
}

std::string size_text(const surface::ObjectModel& model, const msgs::ObjectModel& message) {
  if (model.mesh_W.vertices.empty()) return "no size";
  const auto table_W = convert::from_message(message.table());
  return message.has_known() ? surface::size_text(surface::size_on_table(model.mesh_W, table_W))
                             : surface::size_text(surface::predicted_size(model, table_W));
}

void add_object(report::Page& page, const Collected& collected, const msgs::CompletedShape& shape,
                const DrawnRobot& robot, const std::string& heading) {
  section(page, heading, [&] {
    add_shape(page, shape);
    if (const auto model = collected.models.find(shape.id()); model != collected.models.end()) {
      add_model(page, collected, model->second, robot);
    }
    const auto plan = collected.plans.find(shape.id());
    if (plan == collected.plans.end()) return;
    const grasp::PlanAnswer answer = convert::answer_of(plan->second);
    if (answer.outcome == grasp::PlanOutcome::kUngraspable) {
      page.add_answer("Not graspable: " + answer.problem);
    } else if (answer.outcome == grasp::PlanOutcome::kFailed) {
      page.add_verdict(answer.problem, false);
    }
    page.add_paragraph(fmt::format("{} of {} grasp candidates kept.", plan->second.grasps_size(),
                                   plan->second.candidates()));
    report::add_rejections(page, rejections_of(plan->second),
                           static_cast<int>(plan->second.candidates()), "candidates");
    add_choices(page, plan->second);
    add_remedies(page, plan->second);
  });
}

}  // namespace prehend::nodes
