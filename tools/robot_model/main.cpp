// Robots' files of many formats: what `prehend model` starts.

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/robot_format.h"
#include "prehend/robot/formats/shape_mesh.h"
#include "prehend/robot/formats/srdf.h"
#include "tools/robot_model/choices.h"

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

int convert(const ModelChoices& choices) {
  LossReport loss;
  const RobotFormat& format =
      choices.format.empty() ? format_for(choices.second) : format_named(choices.format);
  RobotDescription robot = read_robot(choices.first, loss);
  const fs::path from = fs::absolute(choices.first).parent_path(),
                 to = fs::absolute(choices.second).parent_path();
  const auto meshes = take_out_meshes(robot, from, fs::path(choices.second).stem().string(), loss,
                                      format.taken_meshes());
  move_meshes(robot, from, to);
  const std::string srdf = srdf_of(format, robot, loss);
  const std::string text = format.write(robot, loss);
  fmt::print("{}", shown(loss.text(), true));
  if (choices.strict && !loss.lossless()) {
    fmt::print(stderr,
               "model convert: something is lost, and --strict refuses that: {} is not "
               "written\n",
               choices.second);
    return 3;
  }
  write_meshes(meshes, to);
  write_file(choices.second, text);
  write_beside(choices.second, srdf);
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
    RobotDescription moved = robot;
    const fs::path from = fs::absolute(choices.first).parent_path(),
                   to = fs::absolute(choices.mended).parent_path();
    LossReport written;
    write_meshes(take_out_meshes(moved, from, fs::path(choices.mended).stem().string(), written,
                                 format.taken_meshes()),
                 to);
    move_meshes(moved, from, to);
    const std::string srdf = srdf_of(format, moved, written);
    write_file(choices.mended, format.write(moved, written));
    write_beside(choices.mended, srdf);
    fmt::print("{}", shown(written.text(), true));
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
    if (choices.command == "diff") return diff(choices);
    return list_formats();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "model {}: {}\n", choices.command, shown(error.what()));
    return 1;
  }
}
