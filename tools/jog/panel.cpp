#include "tools/jog/panel.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

namespace prehend::tools {
namespace {

using control::JogRow;
using control::JogSession;
using Kind = JogSession::Kind;

constexpr double kDegrees = 180 / M_PI;
constexpr double kNear = 0.03;   // of a joint's range: nearer to a limit is marked
constexpr int kBar = 17;         // characters
constexpr int kOtherLines = 11;  // beside joints: title, mode, 2 of the tool, 4 of messages, keys
const char* const kAxes[] = {"x", "y", "z", "roll", "pitch", "yaw"};
const char* const kKeys[] = {
    "Up Down choose | hold + - (Right Left): move | m joints, base, tool | , . speed",
    "o open, c close the hand | SPACE or any other key: stop | q stop and quit",
    "! or ESC: EMERGENCY STOP"};

// What a terminal takes, no longer than `width`.
std::string fitted(const std::string& text, int width) {
  std::string line = text.substr(0, static_cast<std::size_t>(std::max(0, width)));
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
  }
  return line;
}

// Over as many lines as it takes, all but the first indented.
void add_wrapped(const std::string& message, PanelLook look, int width,
                 std::vector<PanelLine>* lines) {
  const auto room = static_cast<std::size_t>(width);
  lines->push_back({message.substr(0, room), look});
  for (std::size_t at = room; at < message.size(); at += room - 2) {
    lines->push_back({"  " + message.substr(at, room - 2), look});
  }
}

// Without arm_ or hand_, which are said by the column before.
std::string short_name(const JogRow& row) {
  for (const char* prefix : {"arm_", "hand_"}) {
    if (row.name.rfind(prefix, 0) == 0) return row.name.substr(std::string(prefix).size());
  }
  return row.name;
}

double shown(const JogRow& row, double value) { return value * (row.is_revolute ? kDegrees : 1e3); }

std::string limit_text(const JogRow& row, double limit) {
  return std::isfinite(limit) ? fmt::format("{:.1f}", shown(row, limit)) : "none";
}

std::string bar(const JogRow& row, double position) {
  std::string text(kBar, '-');
  text.front() = '[';
  text.back() = ']';
  const double range = row.upper - row.lower;
  if (!std::isfinite(position) || !(range > 0) || !std::isfinite(range)) return text;
  const double share = std::clamp((position - row.lower) / range, 0.0, 1.0);
  text[static_cast<std::size_t>(1 + std::lround(share * (kBar - 3)))] = '#';
  return text;
}

PanelLine joint_line(const JogRow& row, double position, double velocity, bool chosen) {
  const char* unit = row.is_revolute ? "deg" : "mm ";
  const bool told = std::isfinite(position);
  const double range = row.upper - row.lower;
  const bool near = told && std::isfinite(range) &&
                    std::min(position - row.lower, row.upper - position) < kNear * range;
  const auto number = [&](double value) {
    // No minus before what is shown as nothing.
    const double in_units = std::abs(shown(row, value)) < 0.005 ? 0 : shown(row, value);
    return told ? fmt::format("{:9.2f}", in_units) : std::string("        ?");
  };
  PanelLine line;
  line.text = fmt::format("{}{}{} {:<17.17}{} {} {:>7} {} {:<7}{} /s", chosen ? '>' : ' ',
                          row.is_hand ? 'h' : 'a', near ? '!' : ' ', short_name(row),
                          number(position), unit, limit_text(row, row.lower), bar(row, position),
                          limit_text(row, row.upper), number(velocity).substr(1));
  line.look = near ? PanelLook::kNear : chosen ? PanelLook::kChosen : PanelLook::kPlain;
  return line;
}

// Without a minus before what is shown as nothing.
double plain(double value) { return std::abs(value) < 0.05 ? 0 : value; }

std::string pose_text(const char* frame, const geometry::RigidTransform& X) {
  // Fixed axes: roll about x, pitch about y, yaw about z.
  const Eigen::Matrix3d& R = X.linear();
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const double roll = std::atan2(R(2, 1), R(2, 2)), yaw = std::atan2(R(1, 0), R(0, 0));
  return fmt::format(
      "tool in {:<5} x {:7.1f} y {:7.1f} z {:7.1f} mm  rpy {:6.1f} {:6.1f} {:6.1f} deg", frame,
      plain(1e3 * X.translation().x()), plain(1e3 * X.translation().y()),
      plain(1e3 * X.translation().z()), plain(roll * kDegrees), plain(pitch * kDegrees),
      plain(yaw * kDegrees));
}

std::string mode_text(const JogSession& session) {
  if (session.mode() == Kind::kJoint) {
    return "JOINT " + short_name(session.rows()[static_cast<std::size_t>(session.row())]);
  }
  std::string text =
      session.mode() == Kind::kBase ? "CARTESIAN in the base:" : "CARTESIAN in the tool:";
  for (int i = 0; i < 6; ++i) {
    text += i == session.axis() ? fmt::format(" [{}]", kAxes[i]) : fmt::format(" {}", kAxes[i]);
  }
  return text;
}

}  // namespace

std::vector<PanelLine> panel_lines(const PanelState& state, int width, int height) {
  const JogSession& session = *state.session;
  std::vector<PanelLine> lines;
  if (width < kPanelWidth || height < kPanelHeight) {
    return {{fitted(fmt::format("{} x {} characters; {} x {} are needed. q quits", width, height,
                                kPanelWidth, kPanelHeight),
                    width),
             PanelLook::kAlarm}};
  }
  lines.push_back(
      {fmt::format("prehend jog  {}   speed {:.0f} %", state.title, 100 * session.speed()),
       PanelLook::kTitle});
  lines.push_back(
      {mode_text(session) + (session.is_moving() ? "   MOVES" : ""), PanelLook::kTitle});
  const int count = static_cast<int>(session.rows().size());
  const int room = std::max(1, height - kOtherLines);
  const int first = count <= room ? 0 : std::clamp(session.row() - room / 2, 0, count - room);
  for (int i = first; i < std::min(count, first + room); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double nothing = std::nan("");
    lines.push_back(joint_line(session.rows()[k],
                               k < state.position.size() ? state.position[k] : nothing,
                               k < state.velocity.size() ? state.velocity[k] : nothing,
                               session.mode() == Kind::kJoint && i == session.row()));
  }
  if (state.knows_pose) {
    lines.push_back({pose_text("base", state.X_BG)});
    lines.push_back({pose_text("world", state.X_WB * state.X_BG)});
  } else {
    lines.push_back({"tool: not known, as nobody tells where the joints are"});
    lines.push_back({""});
  }
  // Above the newest messages what is in the way now.
  const auto left =
      static_cast<std::size_t>(std::max(0, height - static_cast<int>(lines.size()) - 3));
  std::vector<PanelLine> said, messages;
  if (!state.alarm.empty()) {
    add_wrapped("NOTHING MOVES: " + state.alarm, PanelLook::kAlarm, width, &said);
  } else if (!session.words().empty()) {
    add_wrapped(session.words(), PanelLook::kNear, width, &said);
  }
  if (!state.felt.empty()) add_wrapped(state.felt, PanelLook::kPlain, width, &said);
  for (const std::string& message : state.messages) {
    add_wrapped(message, PanelLook::kPlain, width, &messages);
  }
  const std::size_t room_left = left - std::min(left, said.size());
  const std::size_t skipped = messages.size() - std::min(messages.size(), room_left);
  said.insert(said.end(), messages.begin() + static_cast<std::ptrdiff_t>(skipped), messages.end());
  said.resize(left);
  lines.insert(lines.end(), said.begin(), said.end());
  for (const char* keys : kKeys) lines.push_back({keys, PanelLook::kTitle});
  for (PanelLine& line : lines) line.text = fitted(line.text, width);
  return lines;
}

}  // namespace prehend::tools
