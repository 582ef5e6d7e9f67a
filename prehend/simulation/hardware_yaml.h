#pragma once

#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "prehend/simulation/scene.h"

/// Sections of scene files (config/scenes) and gripper files (config/robots). What a scene says
/// goes before what its gripper's file says. Keys are the fields of the structs named here; all
/// throw geometry::InputError "file:line: ..." for unknown keys and wrong types.
namespace prehend::simulation {

/// `drive:` of a gripper file: SpindleDriveModel's motor, gear, thread, static friction, winding
/// and servo. Speed, acceleration, currents, jaw_mass, force_per_current and friction_force stand
/// in the file itself.
void read_drive(const YAML::Node& node, const std::filesystem::path& file, Scene& scene);

/// `tactile:` of either file (of a robot's pads, too): `realistic: true` begins from
/// TactileSensorOptions::realistic(), and pads whose law has neither creep nor hysteresis get
/// FoamMemory::realistic(); then threshold, gain_spread, pad_gain_spread, spread, low_pass_time,
/// latency, offset, drift, ageing, load_cycles, noise, dead, dead_rows, dead_columns (lists), seed,
/// period. `calibration`: files of robot::PadCalibration, one for all pads or a list with one for
/// each, beside this file; with it go neither gain_spread, pad_gain_spread, offset nor noise.
/// `sensor: NAME` takes a plug-in's (sensors/README.md) in place of foam, whose keys but seed and
/// period do not apply then; `parameters` are that one's.
void read_tactile(const YAML::Node& node, const std::filesystem::path& file, Scene& scene);

/// `wrench:` of either file: WrenchSensorOptions, with bias_force and bias_torque; without the
/// section the wrist shows forces as they are.
void read_wrench(const YAML::Node& node, const std::filesystem::path& file, Scene& scene);

/// `physics:` of a scene file: integration (first_order, second_order), step [s] (instead of the
/// scene's), velocity_tolerance, most_iterations, pads (texels, rigid), law (over the gripper
/// file's pad.law), rules (ModelRules).
void read_physics(const YAML::Node& node, const std::filesystem::path& file, bool has_step,
                  Scene& scene);

}  // namespace prehend::simulation
