#pragma once

#include <string>
#include <vector>

#include "prehend/control/jog_session.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::tools {

/// What the screen of `prehend jog` shows.
struct PanelState {
  std::string title;  // the robot, and who said so
  const control::JogSession* session = nullptr;
  std::vector<double> position, velocity;  // of the session's rows, rad or m; NaN: not told
  geometry::RigidTransform X_BG = geometry::RigidTransform::Identity();
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  bool knows_pose = false;
  std::string alarm;                  // why nothing may move; empty: it may
  std::string felt;                   // by the hand's pads
  std::vector<std::string> messages;  // oldest first
};

/// How a line stands out; text alone says the same, for terminals without colours.
enum class PanelLook { kPlain, kTitle, kChosen, kNear, kAlarm };

struct PanelLine {
  std::string text;  // at most `width` bytes, printable ASCII
  PanelLook look = PanelLook::kPlain;
};

/// The least terminal, in characters.
inline constexpr int kPanelWidth = 80, kPanelHeight = 20;

/// `height` lines. Where not all joints fit, those round the chosen one. A terminal that is too
/// small gets one line that says so.
std::vector<PanelLine> panel_lines(const PanelState& state, int width, int height);

}  // namespace prehend::tools
