#include "prehend/robot/formats/robot_format.h"

#include <algorithm>
#include <cmath>

#include <tinyxml2.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/file_text.h"
#include "prehend/robot/formats/format_makers.h"
#include "prehend/robot/formats/tracked_xml.h"
#include "prehend/text/nearest_match.h"

namespace prehend::robot::formats {
namespace {

using geometry::InputError;

std::vector<std::string> names_of(bool written) {
  std::vector<std::string> names;
  for (const auto& format : robot_formats()) {
    if (!written || format->can_write()) names.push_back(format->name());
  }
  return names;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

/// Numbers of a file may be finite, as 1e308 is, and what is made of them not.
void refuse_what_is_beyond_measure(const RobotDescription& robot, const std::string& file) {
  const auto fail = [&](const std::string& what, const std::string& mend) {
    throw InputError(file + ": " + what, mend);
  };
  // So far below all numbers' end that what is made of them is finite, too; not of nan.
  constexpr double kMost = 1e100;
  const auto is_sound = [](const auto& numbers) { return numbers.cwiseAbs().maxCoeff() < kMost; };
  const char* const kMend = "Mend its numbers: lengths are in metres";
  for (const LinkDescription& link : robot.links) {
    bool is_fine = !link.inertial ||
                   (is_sound(link.inertial->X_LI.matrix()) && is_sound(link.inertial->inertia) &&
                    std::abs(link.inertial->mass) < kMost);
    for (const auto* shapes : {&link.visuals, &link.collisions}) {
      for (const Shape& shape : *shapes) {
        is_fine = is_fine && is_sound(shape.X_LS.matrix()) && is_sound(shape.size) &&
                  is_sound(shape.scale) && std::abs(shape.radius) < kMost &&
                  std::abs(shape.length) < kMost;
      }
    }
    if (!is_fine)
      fail("link '" + link.name + "' has a mass, place or size beyond all measure", kMend);
  }
  using Kind = JointDescription::Kind;
  for (const JointDescription& joint : robot.joints) {
    const bool moves = joint.kind == Kind::kRevolute || joint.kind == Kind::kPrismatic;
    if (!is_sound(joint.X_PJ.matrix()) || !is_sound(joint.X_JC.matrix())) {
      fail("joint '" + joint.name + "' has a place beyond all measure", kMend);
    }
    if (moves && !(std::abs(joint.axis_J.norm() - 1) < 1e-3)) {
      fail("joint '" + joint.name + "' has an axis that is no direction", "Give one of length 1");
    }
  }
}

}  // namespace

std::string RobotFormat::write(const RobotDescription&, LossReport&) const {
  throw InputError("Files of " + name() + " are read, not written",
                   "Write one of " + joined(names_of(true)));
}

const std::vector<std::unique_ptr<RobotFormat>>& robot_formats() {
  static const auto kAll = [] {
    std::vector<std::unique_ptr<RobotFormat>> all;
    all.push_back(collada_format());
    all.push_back(graspit_format());
    all.push_back(json_format());
    if (auto mjcf = mjcf_format()) all.push_back(std::move(mjcf));
    all.push_back(openrave_format());
    all.push_back(sdf_format());
    all.push_back(simox_format());
    all.push_back(urdf_format());
    all.push_back(collada_archive_format());
    return all;
  }();
  return kAll;
}

const RobotFormat& format_named(const std::string& name) {
  for (const auto& format : robot_formats()) {
    if (format->name() == name) return *format;
  }
  throw InputError(
      "There is no format '" + name + "'" + text::nearest_match_hint(name, names_of(false)),
      "Give one of " + joined(names_of(false)));
}

const RobotFormat& format_of(const std::filesystem::path& file) {
  const std::string head = head_of_file(file);
  for (const auto& format : robot_formats()) {
    if (format->recognises_text(head)) return *format;
  }
  LossReport unused;
  TrackedXml document = TrackedXml::read(file, unused);
  const XmlElement root = document.root();
  for (const auto& format : robot_formats()) {
    if (format->recognises(root)) return *format;
  }
  throw InputError(file.string() + " begins with <" + root.name() + ">: no robot of a known format",
                   "It reads " + joined(names_of(false)));
}

const RobotFormat& format_for(const std::filesystem::path& file) {
  for (const auto& format : robot_formats()) {
    if (format->can_write() && file.extension() == format->ending()) return *format;
  }
  throw InputError("'" + file.string() + "' ends like no format that is written",
                   "Give it an ending, or name its format: " + joined(names_of(true)));
}

void move_meshes(RobotDescription& robot, const std::filesystem::path& from,
                 const std::filesystem::path& to) {
  std::error_code error;
  if (std::filesystem::equivalent(from, to, error)) return;
  for (LinkDescription& link : robot.links) {
    for (auto* shapes : {&link.visuals, &link.collisions}) {
      for (Shape& shape : *shapes) {
        if (shape.kind != Shape::Kind::kMesh || shape.surface ||
            shape.mesh.find("://") != std::string::npos) {
          continue;
        }
        const std::filesystem::path file = from / shape.mesh;
        if (std::filesystem::is_regular_file(file, error)) {
          shape.mesh = std::filesystem::relative(file, to, error).generic_string();
        }
      }
    }
  }
}

RobotDescription read_robot(const std::filesystem::path& file, LossReport& loss) {
  RobotDescription robot = format_of(file).read(file, loss);
  refuse_what_is_beyond_measure(robot, file.string());
  return robot;
}

}  // namespace prehend::robot::formats
