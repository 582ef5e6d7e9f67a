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
#include "msgs/convert/outcomes.h"
#include "nodes/report/belief_section.h"
#include "nodes/report/charts_section.h"
#include "nodes/report/fidelity_section.h"
#include "nodes/report/film_section.h"
#include "nodes/report/made_by.h"
#include "nodes/report/object_section.h"
#include "nodes/report/surprise_section.h"
#include "nodes/report/task_section.h"
#include "nodes/report/touch_section.h"
#include "nodes/report/truth_section.h"
#include "prehend/control/surprise.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/binning.h"
#include "prehend/report/pictures.h"

namespace prehend::nodes {
namespace {

using geometry::ColorImage;
using report::Page;
using Row = std::vector<std::string>;

std::string seconds_text(double seconds) { return fmt::format("{:.3f}", seconds); }

std::string join(const std::vector<std::string>& parts, const std::string& separator) {
  std::string out;
  for (const auto& part : parts) out += (out.empty() ? "" : separator) + part;
  return out;
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
      // What was segmented may be of fewer pixels than what was seen.
      const int binning = seen.width / std::max(scene.camera.width, 1);
      if (binning > 1) seen = perception::binned(seen, binning);
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

Row surprise_row(const msgs::Surprise& surprise) {
  const control::SurpriseKind kind = convert::from_message(surprise.kind());
  std::string unit = control::unit_of(kind);
  const double factor = unit == "m" ? 1e3 : unit == "m^2" ? 1e6 : 1;
  if (factor > 1) unit = "m" + unit;
  const auto value = [&](double x) { return fmt::format("{:.1f} {}", x * factor, unit); };
  return {control::to_string(kind),
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
      const grasp::PlanAnswer answer = convert::answer_of(plan->second);
      parts.push_back(answer.outcome == grasp::PlanOutcome::kGraspable
                          ? fmt::format("{} of {} grasps kept", plan->second.grasps_size(),
                                        plan->second.candidates())
                          : grasp::in_words(answer));
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
                  const DrawnRobot& robot, const robot::Platform& platform,
                  const std::vector<Process>& processes) {
  Page page(title);
  if (verdict.kind == Verdict::Kind::kNotGraspable) {
    page.add_answer("Not graspable: " + verdict.text);
  } else {
    page.add_verdict(verdict.text, verdict.kind == Verdict::Kind::kSuccess);
  }
  section(page, "Summary", [&] { page.add_table({"what", "result"}, summarize(collected)); });
  if (collected.result && collected.result->attempts() > 0) {
    section(page, "In three dimensions", [&] { add_film(page, collected, platform); });
  }
  add_fidelity(page, collected);
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
  if (!collected.percept_surprises.empty()) {
    section(page, "How surprising it was", [&] { add_surprises(page, collected); });
  }
  if (!collected.beliefs.empty()) {
    section(page, "What touch changed", [&] { add_beliefs(page, collected); });
  }
  if (!collected.held.empty()) {
    section(page, "What was seen in the hand", [&] { add_held(page, collected); });
  }
  if (collected.true_shapes.shapes_size() > 0 && !collected.on_prediction) {
    section(page, "Predicted beside what is true", [&] { add_truth(page, collected); });
  }
  section(page, "Over time", [&] { add_charts(page, collected); });
  add_tables(page, collected, processes);
  section(page, "Made by", [&] { page.add_table({"what", "value"}, made_by()); });
  return page;
}

}  // namespace prehend::nodes
