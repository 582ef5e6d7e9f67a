#include "prehend/robot/learning/hand_file.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "prehend/robot/learning/at.h"

namespace prehend::robot::learning {
namespace {

/// A name as YAML takes it, also within [ ] and { }.
std::string quoted(const std::string& name) {
  const bool is_plain =
      !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == '/';
      });
  constexpr const char* kWords[] = {"y", "n", "yes", "no", "true", "false", "on", "off", "null"};
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (is_plain && std::none_of(std::begin(kWords), std::end(kWords),
                               [&](const char* word) { return lower == word; })) {
    return name;
  }
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

std::string number(double value) {
  const std::string text = fmt::format("{:.5f}", value);
  const std::size_t last = text.find_last_not_of('0');
  const std::string trimmed = text.substr(0, text[last] == '.' ? last : last + 1);
  return trimmed == "-0" ? "0" : trimmed;
}

}  // namespace

std::string pose_text(const geometry::RigidTransform& X) {
  const Eigen::Matrix3d R = X.linear();
  // Roll, pitch and yaw about fixed axes, as URDF's.
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  double roll = std::atan2(R(2, 1), R(2, 2)), yaw = std::atan2(R(1, 0), R(0, 0));
  if (std::hypot(R(0, 0), R(1, 0)) < 1e-9) {
    roll = 0;
    yaw = std::atan2(-R(0, 1), R(1, 1));
  }
  const Eigen::Vector3d p = X.translation();
  return fmt::format("{{xyz: [{}, {}, {}], rpy: [{:.9f}, {:.9f}, {:.9f}]}}", number(p.x()),
                     number(p.y()), number(p.z()), roll, pitch, yaw);
}

std::string hand_yaml(const LearnedHand& learned, const std::string& urdf,
                      const std::string& source) {
  const HandModel& hand = learned.hand;
  std::string text = fmt::format(
      "# Learned from {} by `prehend hand learn`, from kinematics and shapes alone; correct what "
      "is\n"
      "# wrong. Keys: prehend/robot/hand_model.h. Positions in rad, lengths in m, in the frames "
      "of\n"
      "# the URDF. How sure each is, in [0, 1]:\n",
      source);
  for (const Said& said : learned.said) {
    std::string what = said.what;
    std::replace(what.begin(), what.end(), '\n', ' ');
    text += fmt::format("#   {:.2f}  {}: {}\n", said.sure, said.about, what);
  }
  text += fmt::format("name: {}\nurdf: {}\npalm: {}\nactuated: [", quoted(hand.name), quoted(urdf),
                      quoted(hand.model.links[at(hand.palm)].name));
  const auto names = hand.actuated_names();
  for (std::size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : ", ") + quoted(names[i]);
  text += "]\nfingers:      # links from the palm to the tip\n";
  for (const Finger& finger : hand.fingers) {
    text += "  " + quoted(finger.name) + ": [";
    for (std::size_t i = 0; i < finger.links.size(); ++i) {
      text += (i == 0 ? "" : ", ") + quoted(hand.model.links[at(finger.links[i])].name);
    }
    text += "]\n";
  }
  text += fmt::format("friction: {}   # assumed\n", number(hand.friction));
  text +=
      "# Frame G of the tool in the palm's: z the approach direction, y the closing direction.\n"
      "preshapes:\n";
  for (const FoundPreshape& found : learned.preshapes) {
    const Preshape& preshape = found.preshape;
    text += fmt::format("  # Opens by {:.0f} mm. How sure: {:.2f}\n  {}:\n    open: {{",
                        1000 * found.opening, found.sure, preshape.name);
    bool is_first = true;
    for (int i = 0; i < hand.size(); ++i) {
      const std::string value = number(preshape.open[i]);
      text += (is_first ? "" : ", ") + quoted(names[at(i)]) + ": " + value;
      is_first = false;
    }
    text += "}\n    closing:\n";
    for (int i = 0; i < hand.size(); ++i) {
      const Preshape::Closing& closing = preshape.closing[at(i)];
      if (closing.rate == 0) continue;
      text += "      " + quoted(names[at(i)]) + ": ";
      text += closing.with < 0 ? number(closing.rate)
                               : fmt::format("{{rate: {}, with: {}}}", number(closing.rate),
                                             quoted(names[at(closing.with)]));
      text += "\n";
    }
    text += "    tool: " + pose_text(preshape.X_PG) + "\n";
  }
  return text;
}

}  // namespace prehend::robot::learning
