#include "nodes/report/touch_section.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "nodes/report/verdict.h"
#include "prehend/report/pictures.h"

namespace prehend::nodes {
namespace {

struct Shown {
  const msgs::TactileFrame* frame = nullptr;
  std::string when;
};

// By pad, what was predicted first: of a hand's many pads those that felt something at all, or were
// to feel it.
std::map<std::string, std::vector<Shown>> shown_frames(const Collected& collected,
                                                       const msgs::PredictedPercepts& predicted) {
  std::map<std::string, std::vector<Shown>> shown;
  for (const auto& pad : predicted.pads()) {
    shown[pad.image().header().frame_id()] = {{&pad.image(), "predicted"}};
  }
  for (const auto& snapshot : collected.snapshots) {
    for (const auto& [name, frame] : snapshot.pads) {
      if (frame.sum() > 0) shown[name];
    }
  }
  for (const auto& snapshot : collected.snapshots) {
    for (const auto& [name, frame] : snapshot.pads) {
      const auto pad = shown.find(name);
      if (pad != shown.end())
        pad->second.push_back({&frame, "end of " + to_string(snapshot.phase)});
    }
  }
  return shown;
}

Eigen::Vector3d triple(const google::protobuf::RepeatedField<double>& values, int i) {
  return {values.Get(3 * i), values.Get(3 * i + 1), values.Get(3 * i + 2)};
}

// The cells as one sees them who looks at the pad along its mean normal, P's y up; none for
// a pad that is a flat grid, whose rows and columns show it, or whose cells are not known.
std::vector<report::DrawnCell> cells_of(const std::vector<double>& values,
                                        const msgs::PadCells& pad) {
  const int count = static_cast<int>(values.size());
  if (count == 0 || pad.area_size() != count || pad.position_size() != 3 * count ||
      pad.normal_size() != 3 * count) {
    return {};
  }
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double area = 0;
  for (int i = 0; i < count; ++i) {
    normal += pad.area(i) * triple(pad.normal(), i);
    area += pad.area(i);
  }
  constexpr double kFlat = 1 - 1e-9;
  if (pad.rows() > 1 && normal.norm() > kFlat * area && pad.area(0) > 0) return {};
  if (!(normal.norm() > 1e-6 * area)) normal = Eigen::Vector3d::UnitZ();  // closed all round
  normal.normalize();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY() - normal.y() * normal;
  if (up.norm() < 0.1) up = Eigen::Vector3d::UnitX() - normal.x() * normal;
  up.normalize();
  const Eigen::Vector3d right = up.cross(normal);
  std::vector<std::pair<double, report::DrawnCell>> cells;
  for (int i = 0; i < count; ++i) {
    if (!(pad.area(i) > 0)) continue;
    const Eigen::Vector3d p = triple(pad.position(), i);
    cells.push_back(
        {normal.dot(p),
         {{right.dot(p), up.dot(p)}, std::sqrt(pad.area(i)), values[static_cast<std::size_t>(i)]}});
  }
  std::stable_sort(cells.begin(), cells.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<report::DrawnCell> in_order;
  for (auto& [height, cell] : cells) in_order.push_back(cell);
  return in_order;
}

std::string place_text(const msgs::Vector3& p) {
  return fmt::format("{:.1f}, {:.1f} mm", 1e3 * p.x(), 1e3 * p.y());
}

std::string normal_text(const msgs::PadTouch::Normal& normal) {
  constexpr double kDegrees = 180 / M_PI;
  return fmt::format("{:.1f} degrees off (+-{:.1f})",
                     kDegrees * std::acos(std::clamp(normal.direction().z(), -1.0, 1.0)),
                     kDegrees * normal.deviation());
}

std::string slip_text(const msgs::PadTouch& touch) {
  if (touch.slip().basis() == msgs::PadTouch::Slip::NONE) return "?";
  return fmt::format("{} of {} texels", touch.slip().slipping(), touch.touched());
}

// What the frames of the pictures mean, where a node says it.
void add_meaning(report::Page& page, const Collected& collected,
                 const std::map<std::string, std::vector<Shown>>& shown) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, frames] : shown) {
    for (const auto& snapshot : collected.snapshots) {
      const auto found = snapshot.touch.find(name);
      if (found == snapshot.touch.end() || found->second.touched() == 0) continue;
      const msgs::PadTouch& touch = found->second;
      std::string unknown;
      for (const std::string& reason : touch.not_determined()) {
        unknown += (unknown.empty() ? "" : "; ") + reason;
      }
      rows.push_back(
          {in_words(name), "end of " + to_string(snapshot.phase),
           fmt::format("{:.1f} N", touch.force()), fmt::format("{:.0f} mm2", 1e6 * touch.area()),
           place_text(touch.center()), touch.has_normal() ? normal_text(touch.normal()) : "?",
           touch.has_curvature()
               ? fmt::format("{:.1f}, {:.1f} 1/m (+-{:.1f})", touch.curvature().largest(),
                             touch.curvature().smallest(), touch.curvature().deviation())
               : "?",
           touch.has_holding_torque() ? fmt::format("{:.0f} mN m", 1e3 * touch.holding_torque())
                                      : "?",
           slip_text(touch), unknown});
    }
  }
  if (rows.empty()) return;
  page.add_paragraph("What the pads' frames mean (/touch):");
  page.add_table({"pad", "when", "force", "area", "centre of pressure", "normal", "curvature",
                  "friction holds", "slips", "not determined"},
                 rows);
}

// How touch was predicted, where that was chosen.
void add_choice(report::Page& page, const msgs::GraspPlan& plan) {
  if (!plan.has_touch_fidelity()) return;
  const msgs::FidelityChoice& choice = plan.touch_fidelity();
  page.add_paragraph(fmt::format(
      "What they should feel was simulated as chosen from the measured front: {} (there {:.3g} ms "
      "of "
      "processor for a simulated second, images {:.2g} % of the largest sum off those of finer "
      "steps).",
      choice.knobs(), 1e3 * choice.seconds(), 100 * choice.error()));
}

}  // namespace

geometry::ColorImage draw_pad(const std::vector<double>& values, const std::string& pad, int rows,
                              int columns, const Collected& collected, double full) {
  if (const auto found = collected.cells.find(pad); found != collected.cells.end()) {
    const std::vector<report::DrawnCell> cells = cells_of(values, found->second);
    if (!cells.empty()) return report::draw_cells(cells, full);
  }
  return report::draw_tactile(values, rows, columns, full);
}

std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

void add_touch(report::Page& page, const Collected& collected) {
  const msgs::Grasp* grasp = executed_grasp(collected);
  const auto& predicted = grasp ? grasp->predicted() : msgs::PredictedPercepts::default_instance();
  if (!predicted.not_predicted().empty()) {
    page.add_paragraph("What the pads should feel was not predicted: " + predicted.not_predicted() +
                       ".");
  }
  if (grasp) add_choice(page, collected.plans.at(collected.result->object_id()));
  const auto shown = shown_frames(collected, predicted);
  double full = 0;  // counts
  for (const auto& [name, frames] : shown) {
    for (const Shown& one : frames) {
      for (const auto count : one.frame->intensity()) full = std::max<double>(full, count);
    }
  }
  std::vector<geometry::ColorImage> pictures;
  std::vector<std::string> captions;
  for (const auto& [name, frames] : shown) {
    for (const Shown& one : frames) {
      const msgs::TactileFrame& frame = *one.frame;
      pictures.push_back(draw_pad({frame.intensity().begin(), frame.intensity().end()}, name,
                                  static_cast<int>(frame.rows()), static_cast<int>(frame.columns()),
                                  collected, full));
      captions.push_back(
          fmt::format("{} pad, {}: {:.1f} N", in_words(name), one.when, frame.sum()));
    }
  }
  if (collected.snapshots.empty()) page.add_paragraph("Nothing was touched.");
  page.add_pictures(pictures, captions);
  add_meaning(page, collected, shown);
}

}  // namespace prehend::nodes
