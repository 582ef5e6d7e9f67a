#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend calibrate` and of the program that it becomes.
struct CalibrateChoices {
  std::vector<std::string> inputs;  // images, clouds, a CSV file
  std::vector<std::string> left, right;
  std::string board, camera, out, report, name = "camera", platform, ways, mount = "hand";
  std::vector<double> camera_pose, board_pose;  // x, y, z [m], roll, pitch, yaw [rad]
  std::vector<double> obstacles;                // of the table: a height [m]
  int coefficients = 5, views = 20, poses = 15, pixels = 100, seed = 1;
  double pixel_noise = 0.1, position_noise = 1e-4, rotation_noise = 2e-4;
  double camera_radius = 0.06, clearance = 0.03;  // m
  double speed = 0.2;                             // share of the joints' greatest
  double patience = 10;                           // s
  std::string registry;
  bool offsets = false;
};

/// Each adds a command's options.
void add_calibrate_camera_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_stereo_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_hand_eye_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_poses_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_collect_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_table_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_wrench_options(CLI::App& command, CalibrateChoices& choices);
void add_calibrate_board_options(CLI::App& command, CalibrateChoices& choices);

/// A command with what it says of itself.
struct CalibrateCommand {
  const char* name;
  const char* about;
  const char* footer;
  void (*add_options)(CLI::App&, CalibrateChoices&);
};
const std::vector<CalibrateCommand>& calibrate_commands();

}  // namespace prehend::tools
