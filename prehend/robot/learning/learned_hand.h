#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/learning/postures.h"

namespace prehend::robot::learning {

/// What a planner must know of a hand, found from a robot's file.
struct LearnedHand {
  HandModel hand;  // as read_hand_model() would have it, of the files below
  Anatomy anatomy;
  std::vector<Opposition> oppositions;
  std::vector<FoundPreshape> preshapes;
  std::vector<Said> said;    // what was found and assumed, and how sure that is
  formats::LossReport loss;  // of the robot's file
};

struct LearnChoices {
  std::string palm;  // a link; empty: it is found
  double friction = 0.6;
  double least_sure = 0.25;  // of an opposition to have preshapes of
  /// Told what is done, for people who wait.
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

/// Writes a text at once or not at all. @throws geometry::InputError for a folder that cannot be
/// written.
void write_text(const std::filesystem::path& file, const std::string& text);

/// Learns a hand from a robot's file of any format, and writes NAME.yaml (`out`), NAME.urdf beside
/// it and NAME_meshes where meshes have to be converted. Files that are there are written anew. The
/// YAML says of each choice how sure it is; a person may correct it.
/// @throws geometry::InputError naming the file and what it lacks: hand_part(), find_anatomy(), or
/// no two fingers whose pads meet.
LearnedHand learn_hand(const std::filesystem::path& file, const std::filesystem::path& out,
                       const LearnChoices& choices = {});

}  // namespace prehend::robot::learning
