#include "tools/calibrate/choices.h"
#include "prehend/text/command_line.h"

namespace prehend::tools {
namespace {

void add_board(CLI::App& command, CalibrateChoices& choices) {
  command
      .add_option("--board", choices.board,
                  "YAML file of the board: kind, columns, rows, square, marker, gap, dictionary")
      ->required();
}

void add_results(CLI::App& command, CalibrateChoices& choices, const char* out) {
  command.add_option("-o,--out", choices.out, out);
  command.add_option("--report", choices.report,
                     "The page of residuals, HTML; without it beside the result");
}

void add_mount(CLI::App& command, CalibrateChoices& choices) {
  command
      .add_option(
          "--mount", choices.mount,
          "Where the camera is: hand (the board stands) or world (the flange has the board)")
      ->check(CLI::IsMember({"hand", "world"}))
      ->capture_default_str();
}

void add_camera_file(CLI::App& command, CalibrateChoices& choices) {
  command.add_option("--camera", choices.camera, "The camera's calibration (camera_info YAML)")
      ->required();
}

void add_lens(CLI::App& command, CalibrateChoices& choices) {
  command
      .add_option("--coefficients", choices.coefficients,
                  "Of the lens: 5 (plumb_bob) or 8 (rational_polynomial)")
      ->check(CLI::IsMember({5, 8}))
      ->capture_default_str();
  command.add_option("--views", choices.views, "Views that are wanted")
      ->check(text::in_range(4, 1000))
      ->capture_default_str();
}

void add_noises(CLI::App& command, CalibrateChoices& choices) {
  command.add_option("--pixel-noise", choices.pixel_noise, "Of a corner [pixels]")
      ->check(text::in_range(1e-3, 100.0))
      ->capture_default_str();
  command
      .add_option("--position-noise", choices.position_noise,
                  "Of the arm about what it says, each axis [m]")
      ->check(text::in_range(1e-7, 0.1))
      ->capture_default_str();
  command.add_option("--rotation-noise", choices.rotation_noise, "The same [rad]")
      ->check(text::in_range(1e-7, 0.2))
      ->capture_default_str();
}

// Of who lets the arm go from pose to pose.
void add_arm_to_poses(CLI::App& command, CalibrateChoices& choices) {
  command.add_option("--platform", choices.platform, "The arm (config/robots/...yaml)")->required();
  add_board(command, choices);
  add_mount(command, choices);
  command
      .add_option("--camera-pose", choices.camera_pose,
                  "About where the camera's optical frame is, on the flange or in the arm's base: "
                  "x,y,z,roll,pitch,yaw [m, rad]")
      ->required()
      ->expected(6)
      ->delimiter(',');
  command
      .add_option("--board-pose", choices.board_pose,
                  "About where the board is, in the arm's base or on the flange: its upper left "
                  "corner, x along the columns, y along the rows, z away from who looks at it")
      ->required()
      ->expected(6)
      ->delimiter(',');
  command
      .add_option("--table", choices.obstacles,
                  "Height over the arm's base [m] of a level table that the arm must not touch")
      ->expected(1);
  command
      .add_option("--camera-radius", choices.camera_radius,
                  "Of a ball round the optical centre that holds the camera [m]; 0: no camera")
      ->check(text::in_range(0.0, 1.0))
      ->capture_default_str();
  command
      .add_option("--clearance", choices.clearance,
                  "Kept from table, board and camera [m]: more than the two poses are off")
      ->check(text::in_range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--poses", choices.poses, "How many")
      ->check(text::in_range(5, 200))
      ->capture_default_str();
  command.add_flag("--offsets", choices.offsets, "For finding the joints' zero offsets as well");
  command.add_option("--seed", choices.seed, "Of the candidates")->capture_default_str();
}

}  // namespace

void add_calibrate_camera_options(CLI::App& command, CalibrateChoices& choices) {
  command.add_option("images", choices.inputs, "Images, or folders of them")->required();
  add_board(command, choices);
  command.add_option("--name", choices.name, "The camera's name in the file")
      ->capture_default_str();
  add_lens(command, choices);
  add_results(command, choices, "Write the calibration to this camera_info YAML file");
}

void add_calibrate_stereo_options(CLI::App& command, CalibrateChoices& choices) {
  command.add_option("--left", choices.left, "Images of the left camera, or their folder")
      ->required()
      ->allow_extra_args(false);
  command
      .add_option("--right", choices.right, "Of the right one: as many, in the same order of names")
      ->required()
      ->allow_extra_args(false);
  add_board(command, choices);
  add_lens(command, choices);
  add_results(command, choices, "Write left.yaml and right.yaml to this folder");
}

void add_calibrate_hand_eye_options(CLI::App& command, CalibrateChoices& choices) {
  command
      .add_option(
          "poses", choices.inputs,
          "CSV: image, then x, y, z [m], qw, qx, qy, qz of the flange in the arm's base, or "
          "with --platform a column for each joint of the arm [rad or m]")
      ->required();
  add_board(command, choices);
  add_camera_file(command, choices);
  add_mount(command, choices);
  command.add_option("--platform", choices.platform,
                     "The arm (config/robots/...yaml), where the poses are of joints");
  command.add_flag("--offsets", choices.offsets, "Find the joints' zero offsets as well");
  add_noises(command, choices);
  add_results(command, choices, "Write the poses of camera and board to this YAML file");
}

void add_calibrate_poses_options(CLI::App& command, CalibrateChoices& choices) {
  add_arm_to_poses(command, choices);
  add_camera_file(command, choices);
  command.add_option("--ways", choices.ways,
                     "Write the free way to each pose, waypoint by waypoint, to this CSV file");
  command.add_option("-o,--out", choices.out, "Write the poses to this CSV file");
}

void add_calibrate_collect_options(CLI::App& command, CalibrateChoices& choices) {
  add_arm_to_poses(command, choices);
  add_noises(command, choices);
  command.add_option("--speed", choices.speed, "Share of the joints' greatest speeds")
      ->check(text::in_range(0.01, 1.0))
      ->capture_default_str();
  command
      .add_option("--patience", choices.patience, "With topics and actions that do not come [s]")
      ->check(text::in_range(0.1, 600.0))
      ->capture_default_str();
  command.add_option("--registry", choices.registry, "Endpoint of the registry");
  command
      .add_option("-o,--out", choices.out,
                  "Write images, poses.csv, camera.yaml, hand_eye.yaml and hand_eye.html to this "
                  "folder, which must be empty or new")
      ->required();
}

void add_calibrate_table_options(CLI::App& command, CalibrateChoices& choices) {
  command
      .add_option("views", choices.inputs,
                  "A cloud in the camera's optical frame (PCD, PLY); or CSV: cloud, then x, y, z "
                  "[m], qw, qx, qy, qz of the camera")
      ->required();
  add_results(command, choices, "Write plane and corners to this YAML file");
}

void add_calibrate_wrench_options(CLI::App& command, CalibrateChoices& choices) {
  command
      .add_option(
          "poses", choices.inputs,
          "CSV: fx, fy, fz [N], tx, ty, tz [N m] on the sensor, qw, qx, qy, qz of the sensor "
          "in a frame whose z is up; the arm at rest")
      ->required();
  add_results(command, choices, "Write bias, mass and centre to this YAML file");
}

void add_calibrate_board_options(CLI::App& command, CalibrateChoices& choices) {
  command.add_option("board", choices.board, "YAML file of the board")->required();
  command.add_option("--pixels", choices.pixels, "Of a square's or tag's side")
      ->check(text::in_range(16, 2000))
      ->capture_default_str();
  command.add_option("-o,--out", choices.out, "The image to write")->required();
}

const std::vector<CalibrateCommand>& calibrate_commands() {
  static const std::vector<CalibrateCommand> kCommands{
      {"camera", "A camera's pinhole and lens from images of a board",
       "Example:\n  prehend calibrate camera images/ --board board.yaml -o camera.yaml --report "
       "camera.html",
       add_calibrate_camera_options},
      {"stereo", "Two cameras and their relative pose from pairs of images of a board",
       "Example:\n  prehend calibrate stereo --left left/ --right right/ --board board.yaml -o "
       "calibration",
       add_calibrate_stereo_options},
      {"hand-eye", "Where a camera is on the arm's flange or in its base's frame",
       "Example:\n  prehend calibrate hand-eye poses.csv --board board.yaml --camera camera.yaml "
       "--mount hand -o hand_eye.yaml",
       add_calibrate_hand_eye_options},
      {"poses",
       "Poses for `calibrate hand-eye` that tell most, free of collisions, with the ways to them",
       "Example:\n  prehend calibrate poses --platform config/robots/kr5_sdh.yaml --board "
       "board.yaml --camera camera.yaml --mount hand --camera-pose=0.09,0.03,0.04,0,0,0 "
       "--board-pose=0.6,0.15,0,3.1416,0,-1.5708 --table=-0.02 -o poses.csv",
       add_calibrate_poses_options},
      {"collect",
       "Drive the arm through the poses that tell most, record what the camera sees there, and "
       "find "
       "where the camera is",
       "The arm moves: /arm/follow, /joint_states, /camera/info and /camera/stereo of a running "
       "graph. "
       "Ctrl-C stops it.\nExample:\n  prehend calibrate collect --platform "
       "config/robots/kr5_sdh.yaml --board board.yaml --mount hand "
       "--camera-pose=0.09,0.03,0.04,0,0,0 --board-pose=0.6,0.15,0,3.1416,0,-1.5708 --table=-0.02 "
       "-o calibration",
       add_calibrate_collect_options},
      {"table", "Plane and edges of the work area from clouds",
       "Example:\n  prehend calibrate table scene.pcd -o table.yaml", add_calibrate_table_options},
      {"wrench", "A force-torque sensor's bias, the tool's mass and its centre from poses at rest",
       "Example:\n  prehend calibrate wrench wrenches.csv -o tool.yaml",
       add_calibrate_wrench_options},
      {"board", "Draw a board, to print it",
       "Example:\n  prehend calibrate board board.yaml -o board.png", add_calibrate_board_options}};
  return kCommands;
}

}  // namespace prehend::tools
