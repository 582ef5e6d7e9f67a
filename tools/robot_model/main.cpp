// Robots' files of many formats: what `prehend model` starts.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/collision_shapes.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/robot_format.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/srdf.h"
#include "tools/robot_model/choices.h"
#include "tools/robot_model/model_page.h"

namespace {

namespace fs = std::filesystem;
using namespace prehend::robot::formats;
using prehend::tools::ModelChoices;

/// Without signs that a terminal obeys, which names in a file may have; lines stay.
std::string shown(std::string text, bool has_lines = false) {
  for (char& c : text) {
    const auto sign = static_cast<unsigned char>(c);
    const bool is_control = sign < 0x20 || sign == 0x7f;
    if (is_control && !(has_lines && c == '\n')) c = '?';
  }
  return text;
}

void write_file(const fs::path& file, const std::string& text) {
  const fs::path partial = file.string() + ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + partial.string());
  fs::rename(partial, file);
}

/// The SRDF that goes beside a URDF, whose description it is taken out of; empty: there is none.
std::string srdf_of(const RobotFormat& format, RobotDescription& robot, LossReport& loss) {
  if (format.name() != "urdf" || !needs_srdf(robot)) return {};
  std::string text = write_srdf(robot, loss);
  take_out_srdf(robot);
  return text;
}

void write_beside(const fs::path& file, const std::string& srdf) {
  if (srdf.empty()) return;
  write_file(srdf_beside(file), srdf);
  fmt::print("{}: what the URDF cannot say\n", srdf_beside(file).string());
}

/// A robot as it will be written: its text, and the files beside it.
struct Written {
  std::string text, srdf;
  std::vector<MeshFile> meshes;

  void to(const fs::path& file) const {
    write_meshes(meshes, fs::absolute(file).parent_path());
    write_file(file, text);
    write_beside(file, srdf);
  }
};

/// @param from the file it was read from, after which its meshes are named
Written written(RobotDescription robot, const RobotFormat& format, const fs::path& from,
                const fs::path& to, LossReport& loss) {
  const fs::path here = fs::absolute(from).parent_path();
  Written files;
  files.meshes = take_out_meshes(robot, here, to.stem().string(), loss, format.taken_meshes());
  move_meshes(robot, here, fs::absolute(to).parent_path());
  files.srdf = srdf_of(format, robot, loss);
  files.text = format.write(robot, loss);
  return files;
}

int convert(const ModelChoices& choices) {
  LossReport loss;
  const RobotFormat& format =
      choices.format.empty() ? format_for(choices.second) : format_named(choices.format);
  const RobotDescription robot = read_robot(choices.first, loss);
  const Written files = written(robot, format, choices.first, choices.second, loss);
  fmt::print("{}", shown(loss.text(), true));
  if (choices.strict && !loss.lossless()) {
    fmt::print(stderr,
               "model convert: something is lost, and --strict refuses that: {} is not "
               "written\n",
               choices.second);
    return 3;
  }
  files.to(choices.second);
  return 0;
}

LinkDescription& link_of(RobotDescription& robot, const std::string& name) {
  const auto link = std::ranges::find(robot.links, name, &LinkDescription::name);
  if (link != robot.links.end()) return *link;
  std::string names;
  for (const auto& one : robot.links) names += (names.empty() ? "" : ", ") + one.name;
  throw prehend::geometry::InputError("There is no link '" + name + "'", "Name one of: " + names);
}

int collision(const ModelChoices& choices) {
  constexpr double kConcavity = 0.004;  // m
  const auto kind = static_cast<CollisionKind>(
      std::ranges::find(collision_kinds(), choices.collision) - collision_kinds().begin());
  if (choices.concavity && kind != CollisionKind::kPieces) {
    throw prehend::geometry::InputError("--concavity is of pieces, not of a " + choices.collision,
                                        "Leave it out");
  }
  LossReport loss;
  const RobotFormat& format = format_for(choices.second);
  RobotDescription robot = read_robot(choices.first, loss);
  std::vector<LinkDescription*> links;
  for (const std::string& name : choices.links) links.push_back(&link_of(robot, name));
  for (LinkDescription& link : robot.links) {
    if (choices.links.empty() && !link.visuals.empty()) links.push_back(&link);
  }
  ShapeMeshes meshes(fs::absolute(choices.first).parent_path());
  for (LinkDescription* link : links) {
    CollisionShapes made =
        collision_shapes(*link, meshes, kind, choices.concavity.value_or(kConcavity));
    fmt::print("{}: {} {}\n", link->name, made.shapes.size(), choices.collision);
    for (const std::string& remark : made.remarks) fmt::print("{}: {}\n", link->name, remark);
    link->collisions = std::move(made.shapes);
  }
  const Written files = written(robot, format, choices.first, choices.second, loss);
  fmt::print("{}", loss.text());
  files.to(choices.second);
  return 0;
}

int check(const ModelChoices& choices) {
  LossReport loss;
  RobotDescription robot = read_robot(choices.first, loss);
  if (!choices.mended.empty()) {
    const RobotFormat& format = format_for(choices.mended);
    for (const std::string& words : mend_model(robot, fs::absolute(choices.first).parent_path())) {
      fmt::print("mended: {}\n", shown(words));
    }
    LossReport lost;
    written(robot, format, choices.first, choices.mended, lost).to(choices.mended);
    fmt::print("{}", shown(lost.text(), true));
  }
  const auto findings = check_model(robot, fs::absolute(choices.first).parent_path());
  int errors = 0;
  for (const ModelFinding& finding : findings) {
    const bool is_error = finding.level == ModelFinding::Level::kError;
    errors += is_error ? 1 : 0;
    fmt::print("{}: {}: {}.{}\n", is_error ? "error" : "warning", shown(finding.place),
               shown(finding.what), finding.mend.empty() ? "" : " " + shown(finding.mend) + ".");
  }
  double mass = 0;
  int moving = 0;
  for (const auto& link : robot.links) mass += link.inertial ? link.inertial->mass : 0;
  for (const auto& joint : robot.joints) {
    moving += joint.kind != JointDescription::Kind::kFixed && !joint.follows ? 1 : 0;
  }
  fmt::print(
      "{}: {} links, {} joints of which {} move by themselves, {:.4g} kg; {} errors, {} "
      "warnings\n",
      shown(robot.name), robot.links.size(), robot.joints.size(), moving, mass, errors,
      findings.size() - static_cast<std::size_t>(errors));
  return errors > 0 ? 3 : 0;
}

int show(const ModelChoices& choices) {
  LossReport loss;
  const RobotDescription robot = read_robot(choices.first, loss);
  const fs::path page = choices.page.empty()
                            ? fs::path(fs::path(choices.first).stem().string() + ".html")
                            : fs::path(choices.page);
  prehend::tools::model_page(robot, loss, fs::absolute(choices.first).parent_path()).write(page);
  fmt::print("{}: open it in a browser\n", page.string());
  return 0;
}

int diff(const ModelChoices& choices) {
  LossReport first_loss, second_loss;
  const RobotDescription first = read_robot(choices.first, first_loss);
  const RobotDescription second = read_robot(choices.second, second_loss);
  const ModelDifference found = difference(first, second, choices.samples);
  for (const std::string& one : found.only_first)
    fmt::print("only {}: {}\n", choices.first, shown(one));
  for (const std::string& one : found.only_second)
    fmt::print("only {}: {}\n", choices.second, shown(one));
  for (const std::string& one : found.others) fmt::print("{}\n", shown(one));
  fmt::print("at {} random positions links differ by at most {:.3g} m and {:.3g} rad{}\n",
             choices.samples, found.place, found.turn,
             found.where.empty() ? "" : " ('" + shown(found.where) + "')");
  constexpr double kSame = 1e-6;  // m, rad
  const bool is_same = found.only_first.empty() && found.only_second.empty() &&
                       found.others.empty() && found.place <= kSame && found.turn <= kSame;
  return is_same ? 0 : 3;
}

int list_formats() {
  for (const auto& format : robot_formats()) {
    fmt::print("{:8} {:10} {}\n", format->name(), format->can_write() ? "read, write" : "read",
               format->ending());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Robots' files of many formats", "robot_model");
  ModelChoices choices;
  prehend::tools::add_model_options(app, choices);
  try {
    app.parse(argc, argv);
    if (choices.command == "convert") return convert(choices);
    if (choices.command == "check") return check(choices);
    if (choices.command == "collision") return collision(choices);
    if (choices.command == "show") return show(choices);
    if (choices.command == "diff") return diff(choices);
    return list_formats();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "model {}: {}\n", choices.command, shown(error.what()));
    return 1;
  }
}
