// A robot's file of one format, PREHEND_FUZZ_FORMAT: it is read, checked, and written in the
// others. An input is one file, or several: a line `<!--file NAME-->` begins another beside the
// first, of one of the names here, which the first, or itself, may name.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/model_check.h"
#include "prehend/robot/formats/robot_format.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/memory_file.h"

namespace {

using namespace prehend;
using namespace prehend::robot::formats;

constexpr std::array<const char*, 4> kBeside{"part.xml", "iv/part.xml", "part.obj", "part.stl"};

/// Writes an input's files. @returns the first
std::filesystem::path write_files(const fuzz::Folder& folder, std::string_view input) {
  constexpr std::string_view kMark = "<!--file ", kEnd = "-->\n";
  std::size_t next = input.find(kMark);
  const std::filesystem::path first = folder.write("robot.xml", input.substr(0, next));
  for (const char* name : kBeside) folder.remove(name);
  while (next != std::string_view::npos) {
    input.remove_prefix(next + kMark.size());
    next = input.find(kMark);
    const std::string_view part = input.substr(0, next);
    for (const std::string_view name : kBeside) {
      if (!part.starts_with(name) || !part.substr(name.size()).starts_with(kEnd)) continue;
      folder.write(std::string(name), part.substr(name.size() + kEnd.size()));
    }
  }
  return first;
}

/// What is written as prehend's own text has all that the robot has.
void check_own_text(const RobotDescription& robot, const std::string& text) {
  const fuzz::MemoryFile file({text.data(), text.size()});
  LossReport loss;
  const RobotDescription again = read_robot(file.path(), loss);
  FUZZ_CHECK(again.links.size() == robot.links.size());
  FUZZ_CHECK(again.joints.size() == robot.joints.size());
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    FUZZ_CHECK(again.links[i].name == robot.links[i].name);
    FUZZ_CHECK(again.links[i].visuals.size() == robot.links[i].visuals.size());
    FUZZ_CHECK(again.links[i].collisions.size() == robot.links[i].collisions.size());
  }
  FUZZ_CHECK(again.loops.size() == robot.loops.size());
  FUZZ_CHECK(again.actuators.size() == robot.actuators.size());
  FUZZ_CHECK(again.sensors.size() == robot.sensors.size());
  FUZZ_CHECK(again.manipulators.size() == robot.manipulators.size());
  FUZZ_CHECK(again.postures.size() == robot.postures.size());
  FUZZ_CHECK(again.disabled_collisions == robot.disabled_collisions);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const auto file = write_files(folder, {reinterpret_cast<const char*>(data), size});
  RobotDescription robot;
  try {
    if (format_of(file).name() != PREHEND_FUZZ_FORMAT) return 0;
    LossReport loss;
    robot = read_robot(file, loss);
  } catch (const geometry::InputError&) {
    return 0;
  }
  FUZZ_CHECK(!robot.links.empty());
  check_model(robot, "/nowhere");
  for (const auto& format : robot_formats()) {
    if (!format->can_write()) continue;
    std::string text;
    LossReport loss;
    try {
      text = format->write(robot, loss);
    } catch (const geometry::InputError&) {
      continue;
    }
    FUZZ_CHECK(!text.empty());
    // Names that are no UTF-8 are lost, and may be one then.
    if (format->name() == "json" && loss.lossless()) check_own_text(robot, text);
  }
  return 0;
}
