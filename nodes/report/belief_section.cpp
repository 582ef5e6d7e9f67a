#include "nodes/report/belief_section.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "nodes/report/drawn_model.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/report/pictures.h"

namespace prehend::nodes {
namespace {

constexpr geometry::Rgb kContactColor{200, 30, 60};
constexpr double kMarkShare = 0.02;  // of the object's diagonal: a contact's side

std::vector<report::ColoredMesh> marks_of(const msgs::Belief& belief, double diagonal) {
  std::vector<report::ColoredMesh> marks;
  const double side = kMarkShare * diagonal;
  for (const msgs::TouchContact& contact : belief.contacts()) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.translation() = convert::from_message(contact.p());
    marks.push_back(
        {geometry::transformed(geometry::make_box({side, side, side}), X), kContactColor});
  }
  return marks;
}

std::string what_was_made(const msgs::Belief& belief) {
  const geometry::RigidTransform X = convert::from_message(belief.x_moved());
  return fmt::format(
      "{} contacts and {} look(s) before. It had moved by {:.1f} mm and {:.0f} degrees since. Its "
      "surface is {:.1f} mm other than predicted on average.",
      belief.contacts_size(), belief.looks(), 1e3 * X.translation().norm(),
      std::abs(Eigen::AngleAxisd(X.linear()).angle()) * 180 / std::numbers::pi,
      1e3 * belief.change());
}

std::string interval_text(const msgs::Interval& interval, const char* unit) {
  if (!interval.has_high()) return fmt::format("at least {:.2g}{}", interval.low(), unit);
  if (!interval.has_low()) return fmt::format("at most {:.2g}{}", interval.high(), unit);
  return fmt::format("{:.2g} to {:.2g}{}", interval.low(), interval.high(), unit);
}

std::string what_it_weighs(const msgs::Belief& belief) {
  std::string text;
  if (belief.has_mass()) {
    text += fmt::format(" By how it was held it weighs {}.", interval_text(belief.mass(), " kg"));
  }
  if (belief.has_friction()) {
    text += fmt::format(" By how it held and slipped its friction on the pads is {}.",
                        interval_text(belief.friction(), ""));
  }
  if (!belief.load_problem().empty()) text += " Of its load, " + belief.load_problem() + ".";
  return text;
}

Eigen::AlignedBox3d box_of(const surface::ObjectModel& before, const surface::ObjectModel& after) {
  Eigen::AlignedBox3d box = geometry::bounds(before.mesh_W);
  box.extend(geometry::bounds(after.mesh_W));
  return box;
}

double diagonal_of(const surface::ObjectModel& before, const surface::ObjectModel& after) {
  return box_of(before, after).diagonal().norm();
}

/// Two models of an object side by side, from before and from behind.
void add_both(report::Page& page, const surface::ObjectModel& before,
              const surface::ObjectModel& after, const std::vector<report::ColoredMesh>& marks,
              const std::vector<std::string>& captions) {
  std::vector<geometry::ColorImage> pictures;
  for (const auto& X_WC : two_views(box_of(before, after), 0.6)) {
    for (const surface::ObjectModel* model : {&before, &after}) {
      std::vector<report::ColoredMesh> drawn = by_origin(*model);
      drawn.insert(drawn.end(), marks.begin(), marks.end());
      pictures.push_back(report::draw_meshes(drawn, object_camera(), X_WC));
    }
  }
  page.add_pictures(pictures, captions);
}

void add_pictures(report::Page& page, const Collected& collected, const msgs::Belief& belief) {
  const std::pair key{belief.header().stamp(), belief.id()};
  const auto predicted = collected.predicted.find(key), believed = collected.believed.find(key);
  if (predicted == collected.predicted.end() || believed == collected.believed.end()) {
    page.add_paragraph("Its meshes did not come.");
    return;
  }
  const auto before = convert::from_message(predicted->second);
  const auto after = convert::from_message(believed->second);
  add_both(page, before, after, marks_of(belief, diagonal_of(before, after)),
           {"As it was predicted; red: where it was touched",
            "As it is believed; green rests on what was felt", "As it was predicted, from behind",
            "As it is believed, from behind"});
}

}  // namespace

void add_beliefs(report::Page& page, const Collected& collected) {
  int look = 0;
  for (const msgs::Belief& belief : collected.beliefs) {
    const std::string object = fmt::format("{}. Object {}: ", ++look, belief.id());
    if (!belief.problem().empty()) {
      page.add_paragraph(object + belief.problem() + ". It is believed as it is predicted.");
      continue;
    }
    page.add_paragraph(object + what_was_made(belief) + what_it_weighs(belief));
    add_pictures(page, collected, belief);
    std::vector<std::vector<std::string>> rows;
    for (const msgs::BelievedShape& shape : belief.shapes()) {
      rows.push_back({shape.name(), fmt::format("{:.0f} %", 100 * shape.weight_before()),
                      fmt::format("{:.0f} %", 100 * shape.weight()),
                      fmt::format("{:.1f}", shape.misfit())});
    }
    page.add_table({"shape", "weight by this look alone", "with all evidence",
                    "misfit (1: as far off as expected)"},
                   rows);
  }
}

void add_held(report::Page& page, const Collected& collected) {
  std::vector<std::vector<std::string>> rows;
  for (const msgs::ObjectModel& look : collected.held) {
    rows.push_back({std::to_string(rows.size() + 1), std::to_string(look.id()),
                    fmt::format("{:.0f} %", 100 * look.guessed_area()),
                    fmt::format("{:.0f} cm³", 1e6 * look.volume())});
  }
  page.add_paragraph(
      "The arm turned what it held before the camera. Each look was laid onto those before it; "
      "what "
      "they saw is the object's surface, and nothing is left where they looked through.");
  page.add_table({"look", "object", "of its surface still guessed", "volume"}, rows);
  const msgs::ObjectModel& last = collected.held.back();
  const auto known = collected.predicted.find({last.header().stamp(), last.id()});
  if (known == collected.predicted.end()) {
    page.add_paragraph("Its predicted mesh did not come.");
    return;
  }
  add_both(page, convert::from_message(known->second), convert::from_message(last), {},
           {"As it was predicted from one look", "After the last look in the hand",
            "As it was predicted, from behind", "After the last look in the hand, from behind"});
}

}  // namespace prehend::nodes
