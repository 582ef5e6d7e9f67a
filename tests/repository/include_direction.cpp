#include "tests/repository/include_direction.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <regex>
#include <sstream>
#include <string_view>

namespace prehend::testing {
namespace {

// From the ground up: a folder of the library includes only those before it.
constexpr std::array<std::string_view, 17> kFloors{
    "text",     "geometry", "contact",     "perception", "shape",      "surface",
    "robot",    "touch",    "grasp",       "motion",     "simulation", "fidelity",
    "planning", "belief",   "calibration", "control",    "report"};

// What knows of processes, and what of the library each may include.
struct Hall {
  std::string_view folder;
  std::vector<std::string_view> library;
  bool messages;
};
const std::vector<Hall> kHalls{{"graph", {"text"}, true},
                               {"launch", {"text", "graph"}, true},
                               {"recording", {"text"}, false},
                               {"sweep", {"text"}, false},
                               {"viewing", {"text"}, false}};

struct Place {
  std::string top, folder;  // e.g. prehend, geometry
};

Place place_of(const std::filesystem::path& path) {
  Place place;
  auto part = path.begin();
  if (part != path.end()) place.top = *part++;
  if (part != path.end() && std::next(part) != path.end()) place.folder = *part;
  return place;
}

int floor_of(std::string_view folder) {
  const auto found = std::find(kFloors.begin(), kFloors.end(), folder);
  return found == kFloors.end() ? -1 : static_cast<int>(found - kFloors.begin());
}

const Hall* hall_of(std::string_view folder) {
  const auto found = std::find_if(kHalls.begin(), kHalls.end(),
                                  [&](const Hall& hall) { return hall.folder == folder; });
  return found == kHalls.end() ? nullptr : &*found;
}

// Why `from` must not include `to`; "" when it may.
std::string objection(const Place& from, const Place& to) {
  static const std::vector<std::string> kOurs{"msgs",  "prehend", "nodes", "drivers",
                                              "tools", "eval",    "tests", "bench"};
  if (!std::count(kOurs.begin(), kOurs.end(), to.top)) return "";  // a library
  if (to.top == "tests" || to.top == "bench") {
    return from.top == to.top || from.top == "tests" || from.top == "bench"
               ? ""
               : "which only tests and benchmarks use";
  }
  if (from.top == "nodes" && to.top == "nodes" && from.folder != to.folder) {
    // What several nodes share is a library without a node in it.
    static const std::vector<std::string> kShared{"segmentation_parameters",
                                                  "stage_fidelity",
                                                  "touch_fidelity",
                                                  "gripper_source",
                                                  "hand_pads",
                                                  "task_source",
                                                  "platform_source",
                                                  "motion_goal",
                                                  "arm_action",
                                                  "held_picture",
                                                  "emergency_stop_listener",
                                                  "report"};
    return std::count(kShared.begin(), kShared.end(), to.folder) ? ""
                                                                 : "but nodes never include others";
  }
  if (from.top == "msgs") {
    const bool converts =
        from.folder == "convert" || from.folder == "views" || from.folder == "ros";
    const bool may = converts && to.top == "prehend" && floor_of(to.folder) >= 0;
    // Messages of ROS are known by what reads their recordings.
    const bool reads = from.folder == "ros" && to.top == "prehend" && to.folder == "recording";
    return to.top == "msgs" || may || reads
               ? ""
               : "but messages depend on nothing, msgs/convert, msgs/ros and msgs/views on "
                 "algorithms alone, msgs/ros on recording, too";
  }
  if (from.top != "prehend") return "";
  if (to.top != "prehend" && to.top != "msgs") return "but the library stands below that";
  if (from.folder == to.folder && to.top == "prehend") return "";
  if (const Hall* hall = hall_of(from.folder)) {
    if (to.top == "msgs") return hall->messages ? "" : "but it knows no messages";
    return std::count(hall->library.begin(), hall->library.end(), to.folder)
               ? ""
               : "but it knows nothing of robotics";
  }
  if (to.top == "msgs") return "but algorithms know nothing of messages";
  if (hall_of(to.folder)) return "but algorithms know nothing of processes";
  const int here = floor_of(from.folder), there = floor_of(to.folder);
  if (here < 0) return "but " + from.folder + " has no floor yet: give it one in kFloors here";
  if (there < 0) return "but " + to.folder + " has no floor yet: give it one in kFloors here";
  return there < here ? "" : "but that is a floor above";
}

}  // namespace

std::vector<std::string> wrong_includes(const std::filesystem::path& file,
                                        const std::string& text) {
  static const std::regex kInclude(R"re(^\s*#\s*include\s*"([^"]+)")re");
  const Place from = place_of(file);
  std::vector<std::string> wrong;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch match;
    if (!std::regex_search(line, match, kInclude)) continue;
    const std::string included = match[1];
    const std::string why = objection(from, place_of(included));
    if (why.empty()) continue;
    wrong.push_back(file.generic_string() + ":" + std::to_string(number) + ": includes " +
                    included + ", " + why);
  }
  return wrong;
}

}  // namespace prehend::testing
