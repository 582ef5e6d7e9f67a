#include "tools/robot_model/model_page.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "tools/robot_model/model_figure.h"
#include "tools/robot_model/model_words.h"

namespace prehend::tools {
namespace {

using namespace robot::formats;
using report::Page;
using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t kMostRows = 500;  // of a table

// What would be an empty table is no heading either.
void add(Page& page, const std::string& heading, const std::vector<std::string>& header,
         Rows rows) {
  if (rows.empty()) return;
  page.add_heading(heading);
  const std::size_t all = rows.size();
  if (all > kMostRows) rows.resize(kMostRows);
  page.add_table(header, rows);
  if (all > kMostRows) page.add_paragraph(fmt::format("and {} more", all - kMostRows));
}

void add_verdict(Page& page, const std::vector<ModelFinding>& findings) {
  const auto errors =
      std::ranges::count(findings, ModelFinding::Level::kError, &ModelFinding::level);
  const auto warnings = static_cast<std::ptrdiff_t>(findings.size()) - errors;
  const std::string words = fmt::format("{} errors, {} warnings", errors, warnings);
  if (errors == 0 && warnings > 0) return page.add_answer(words);
  page.add_verdict(words, errors == 0);
}

void add_figure(Page& page, const RobotDescription& robot, const std::filesystem::path& folder) {
  try {
    const ModelFigure drawn = model_figure(robot, folder);
    page.add_robot(
        drawn.figure,
        "Drag to turn, wheel or two fingers to come near; a click at a link tells of it. "
        "Boxes of inertia are as heavy and as inert as the links; red ones no body has. "
        "The grid's squares are 100 mm wide.");
    for (const std::string& remark : drawn.remarks) page.add_paragraph(remark + ".");
  } catch (const geometry::InputError& error) {
    page.add_answer(std::string("It is not drawn: ") + error.what());
  }
}

void add_findings(Page& page, const std::vector<ModelFinding>& findings) {
  Rows rows;
  for (const ModelFinding& finding : findings) {
    rows.push_back({finding.level == ModelFinding::Level::kError ? "error" : "warning",
                    finding.place, finding.what, finding.mend});
  }
  add(page, "What is wrong", {"", "where", "what", "mend"}, std::move(rows));
}

void add_joints(Page& page, const RobotDescription& robot) {
  Rows rows;
  for (const JointDescription& joint : robot.joints) {
    rows.push_back({joint.name, kind_word(joint.kind), joint.parent + " → " + joint.child,
                    limit_words(joint), speed_words(joint), effort_words(joint),
                    follows_words(joint), drag_words(joint)});
  }
  add(page, "Joints",
      {"joint", "kind", "links", "limits", "speed", "effort", "follows", "what holds it"},
      std::move(rows));
}

void add_links(Page& page, const RobotDescription& robot) {
  Rows rows;
  for (const LinkDescription& link : robot.links) {
    rows.push_back({link.name, inertial_words(link), std::to_string(link.visuals.size()),
                    std::to_string(link.collisions.size())});
  }
  add(page, "Links", {"link", "mass", "shapes seen", "touched"}, std::move(rows));
}

void add_devices(Page& page, const RobotDescription& robot) {
  Rows actuators, sensors, manipulators, postures, loops, pairs;
  for (const Actuator& one : robot.actuators) {
    actuators.push_back({one.name, one.joint, fmt::format("{:.4g}", one.gear), one.control,
                         one.effort ? fmt::format("{:.4g}", *one.effort) : ""});
  }
  add(page, "Actuators", {"actuator", "joint", "gear", "control", "effort at the joint [N m or N]"},
      std::move(actuators));
  for (const Sensor& one : robot.sensors) {
    const Eigen::Vector3d size = 1000 * one.size;
    sensors.push_back({one.name, one.kind, one.link,
                       size.isZero()
                           ? ""
                           : fmt::format("{:.1f} {:.1f} {:.1f} mm", size.x(), size.y(), size.z())});
  }
  add(page, "Sensors", {"sensor", "kind", "link", "size"}, std::move(sensors));
  for (const Manipulator& one : robot.manipulators) {
    std::string closing;
    for (const auto& [joint, direction] : one.closing) {
      closing += fmt::format("{}{} {:+g}", closing.empty() ? "" : ", ", joint, direction);
    }
    manipulators.push_back({one.name, one.base, one.tip, closing});
  }
  add(page, "Manipulators", {"manipulator", "base", "tip", "closing joints, and which way"},
      std::move(manipulators));
  for (const Posture& one : robot.postures) {
    std::string positions;
    for (const auto& [joint, position] : one.positions) {
      positions += fmt::format("{}{} {:.4g}", positions.empty() ? "" : ", ", joint, position);
    }
    postures.push_back({one.name, one.group, positions});
  }
  add(page, "Postures", {"posture", "group", "positions [rad or m]"}, std::move(postures));
  for (const Loop& one : robot.loops) {
    loops.push_back(
        {one.name, one.kind == Loop::Kind::kWeld ? "weld" : "point", one.first, one.second});
  }
  add(page, "Closed loops", {"loop", "kind", "link", "other link"}, std::move(loops));
  for (const auto& [first, second] : robot.disabled_collisions) pairs.push_back({first, second});
  add(page, "Links that may touch", {"link", "other link"}, std::move(pairs));
}

void add_losses(Page& page, const LossReport& loss) {
  Rows rows;
  for (const LossReport::Entry& entry : loss.entries()) {
    const bool is_dropped = entry.fate == LossReport::Entry::Fate::kDropped;
    rows.push_back({entry.place, is_dropped ? "dropped" : "approximated", entry.what, entry.why});
  }
  add(page, "What of the file is not in this", {"where", "", "what", "why, or how"},
      std::move(rows));
}

}  // namespace

Page model_page(const RobotDescription& robot, const LossReport& loss,
                const std::filesystem::path& folder) {
  Page page(robot.name.empty() ? "A robot without a name" : robot.name);
  const std::vector<ModelFinding> findings = check_model(robot, folder);
  add_verdict(page, findings);
  add_figure(page, robot, folder);
  add_findings(page, findings);
  add_joints(page, robot);
  add_links(page, robot);
  add_devices(page, robot);
  add_losses(page, loss);
  return page;
}

}  // namespace prehend::tools
