#include "prehend/robot/learning/learned_hand.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/formats/robot_format.h"
#include "prehend/robot/learning/at.h"
#include "prehend/robot/learning/hand_file.h"
#include "prehend/robot/learning/hand_part.h"

namespace prehend::robot::learning {
namespace {

namespace fs = std::filesystem;
using geometry::InputError;

/// Positions of five digits are within limits of fifteen.
void round_open(const HandModel& hand, Preshape& preshape) {
  for (int i = 0; i < hand.size(); ++i) {
    const Joint& joint = hand.model.joints[at(hand.actuated[at(i)])];
    const double rounded = std::round(preshape.open[i] * 1e5) / 1e5;
    preshape.open[i] = rounded < joint.lower   ? std::ceil(joint.lower * 1e5) / 1e5
                       : rounded > joint.upper ? std::floor(joint.upper * 1e5) / 1e5
                                               : rounded;
  }
}

void say_workspace(LearnedHand& learned) {
  double reach = 0;
  Eigen::AlignedBox3d box;
  const HandModel& hand = learned.hand;
  std::vector<geometry::RigidTransform> poses;
  constexpr int kSteps = 9;
  for (std::size_t f = 0; f < learned.anatomy.fingers.size(); ++f) {
    const auto& finger = learned.anatomy.fingers[f];
    reach = std::max(reach, finger.length);
    for (int step = 0; step <= kSteps; ++step) {
      Eigen::VectorXd motors(hand.size());
      for (int i = 0; i < hand.size(); ++i) {
        const Joint& joint = hand.model.joints[at(hand.actuated[at(i)])];
        motors[i] = joint.lower + static_cast<double>(step) / kSteps * (joint.upper - joint.lower);
      }
      box.extend(hand.X_HP.inverse() * placed_pads(hand, learned.anatomy, motors).p_H[f]);
    }
  }
  const Eigen::Vector3d low = 1000 * box.min(), high = 1000 * box.max();
  learned.said.push_back(
      {"workspace",
       fmt::format("the longest finger has {:.0f} mm; pads get from {:.0f}, {:.0f}, {:.0f} to "
                   "{:.0f}, {:.0f}, {:.0f} mm in the palm's frame",
                   1000 * reach, low.x(), low.y(), low.z(), high.x(), high.y(), high.z()),
       0.9});
}

void say_roles(LearnedHand& learned) {
  const auto names = learned.hand.actuated_names();
  for (const FoundFinger& finger : learned.anatomy.fingers) {
    std::string closing, turning;
    for (const int motor : finger.closing) {
      closing += (closing.empty() ? "" : ", ") + names[static_cast<std::size_t>(motor)];
    }
    for (const int motor : finger.turning) {
      turning += (turning.empty() ? "" : ", ") + names[static_cast<std::size_t>(motor)];
    }
    learned.said.push_back(
        {finger.name, "closed by " + closing + (turning.empty() ? "" : "; turned by " + turning),
         0.9});
  }
  for (const Opposition& one : learned.oppositions) {
    const auto list = [&](const std::vector<int>& fingers) {
      std::string text;
      for (const int finger : fingers) {
        text += (text.empty() ? "" : ", ") +
                learned.anatomy.fingers[static_cast<std::size_t>(finger)].name;
      }
      return text;
    };
    learned.said.push_back(
        {"opposition",
         fmt::format("{} against {}: {:.0f} mm beside each other, {:.0f} degrees off",
                     list(one.first), list(one.second), 1000 * one.beside, one.angle * 57.29578),
         one.sure()});
  }
}

}  // namespace

void write_text(const fs::path& file, const std::string& text) {
  const fs::path partial = file.string() + ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  std::error_code error;
  if (stream) fs::rename(partial, file, error);
  if (!stream || error) {
    throw InputError("'" + file.string() + "' cannot be written",
                     "Check that its folder is there and may be written to");
  }
}

LearnedHand learn_hand(const fs::path& file, const fs::path& out, const LearnChoices& choices) {
  LearnedHand learned;
  choices.progress("reads " + file.string());
  const formats::RobotDescription robot = formats::read_robot(file, learned.loss);
  const fs::path from = fs::absolute(file).parent_path(), to = fs::absolute(out).parent_path();
  formats::ShapeMeshes meshes(from);
  HandPart part = hand_part(robot, choices.palm, meshes);
  learned.said = std::move(part.said);

  choices.progress("writes the hand's URDF");
  const std::string stem = out.stem().string();
  std::error_code ignored;  // the file that cannot be written says it
  fs::create_directories(to, ignored);
  formats::RobotDescription written = part.robot;
  for (formats::LinkDescription& link : written.links) link.visuals.clear();
  formats::LossReport of_urdf;
  // All of them, so that the hand is found whole wherever it is put.
  const auto taken_out =
      formats::take_out_meshes(written, from, stem, of_urdf, formats::TakenMeshes::kAll);
  const std::string urdf = formats::format_named("urdf").write(written, of_urdf);
  formats::write_meshes(taken_out, to);
  const fs::path urdf_file = to / (stem + ".urdf");
  write_text(urdf_file, urdf);

  HandModel& hand = learned.hand;
  hand.name = stem;
  hand.friction = choices.friction;
  hand.model = read_urdf(urdf_file);
  for (const std::string& remark : hand.model.remarks)
    learned.said.push_back({"shapes", remark, 0.7});
  hand.palm = hand.model.link_index(part.palm);
  for (int link = hand.palm; const auto above = hand.model.joint_above(link);) {
    const Joint& joint = hand.model.joints[static_cast<std::size_t>(*above)];
    hand.X_HP = joint.pose_at(0) * hand.X_HP;
    link = joint.parent;
  }
  for (std::size_t j = 0; j < hand.model.joints.size(); ++j) {
    const Joint& joint = hand.model.joints[j];
    if (joint.kind != Joint::Kind::kFixed && !joint.mimic) {
      hand.actuated.push_back(static_cast<int>(j));
    }
  }
  choices.progress("finds fingers, what closes them, and their inner surfaces");
  learned.anatomy = find_anatomy(hand);
  for (const FoundFinger& finger : learned.anatomy.fingers) {
    hand.fingers.push_back({finger.name, finger.links});
  }
  learned.said.insert(learned.said.end(), learned.anatomy.said.begin(), learned.anatomy.said.end());
  choices.progress("finds what opposes what");
  learned.oppositions = find_oppositions(hand, learned.anatomy);
  constexpr double kFlat = 0.5;  // least sureness of pads that meet well
  if (learned.oppositions.empty() || learned.oppositions.front().sure() < kFlat) {
    Anatomy ahead = learned.anatomy;
    for (FoundFinger& finger : ahead.fingers) finger.presses_ahead = true;
    auto others = find_oppositions(hand, ahead);
    const bool better =
        !others.empty() &&
        (learned.oppositions.empty() || others.front().sure() > learned.oppositions.front().sure());
    if (better) {
      learned.anatomy = std::move(ahead);
      learned.oppositions = std::move(others);
      learned.said.push_back(
          {"pads", "do not lie flat against each other: fingers press with what is ahead", 0.6});
    }
  }
  if (learned.oppositions.empty()) {
    throw InputError("No two fingers of '" + file.string() +
                         "' meet pad against pad within 15 mm and 63 degrees",
                     "See its limits and axes (prehend model check), or name the palm (--palm)");
  }
  choices.progress("finds preshapes");
  learned.preshapes =
      find_preshapes(hand, learned.anatomy, learned.oppositions, choices.least_sure);
  if (learned.preshapes.empty()) {
    throw InputError("Fingers of '" + file.string() + "' that meet cannot open by 15 mm",
                     "See its limits (prehend model check)");
  }
  for (FoundPreshape& found : learned.preshapes) round_open(hand, found.preshape);
  say_roles(learned);
  say_workspace(learned);
  learned.said.push_back({"friction", "assumed", 0.3});
  write_text(out, hand_yaml(learned, urdf_file.filename().string(), file.filename().string()));
  hand = read_hand_model(out);  // what is written is what is used
  return learned;
}

}  // namespace prehend::robot::learning
