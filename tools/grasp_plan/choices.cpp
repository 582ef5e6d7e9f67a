#include "tools/grasp_plan/choices.h"

#include <filesystem>

#include "prehend/grasp/planner_options.h"
#include "prehend/planning/decision.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/command_line.h"
#include "prehend/text/tree_file.h"
#include "tools/grasp_plan/knob_options.h"
#include "tools/table.h"

namespace prehend::tools {

// Many projects have a folder config: one with robots is meant.
std::string own_config() {
  return std::filesystem::path(text::tree_file("config/robots")).parent_path().string();
}

void add_plan_options(CLI::App& command, PlanChoices& choices) {
  command
      .add_option(
          "file", choices.file,
          "mesh (.ply, .obj, .stl: planned on as it is) or cloud (.pcd, .ply: segmented and "
          "completed first)")
      ->required();
  command
      .add_option("--scale", choices.scale,
                  "metres per unit of the file; default: 1, for a mesh that would be "
                  "larger than 3 m 0.001")
      ->check(text::above_zero());
  command.add_option("--viewpoint", choices.viewpoint,
                     "of a cloud: pose of the sensor in the file's frame, \"x y z qw qx qy qz\"; "
                     "default: found out from the file");
  command.add_option("--up", choices.up,
                     "of a cloud: direction up in the file's frame, \"x y z\"; default: unknown");
  command.add_option(
      "--table", choices.table,
      "of a cloud: auto (default), find: there is one, none: the cloud is one object, "
      "\"a b c d\": the plane a x + b y + c z = d of the file's frame [m], normal "
      "towards the objects");
  command
      .add_option(
          "--split", choices.split,
          "of a cloud: what takes things apart that touch: none, tops (default): level "
          "tops at different heights; in organized clouds also touching: creases between "
          "colours, shapes: creases where two completed shapes explain more than one, wide: "
          "as shapes, of what is wider across the table than the hand opens")
      ->check(CLI::IsMember({"none", "tops", "touching", "shapes", "wide"}));
  command.add_flag("--in-place", choices.in_place,
                   "leave a mesh where its file has it, on the table z = 0; else it is put on the "
                   "table, at the origin");
  command.add_option("--object", choices.object, "object of a cloud, 0: the largest")
      ->check(text::above_zero(true))
      ->capture_default_str();
  command
      .add_option("--alternatives", choices.alternatives,
                  "shapes at most that the object of a cloud may have as well, by other planes of "
                  "symmetry: grasps are tried on them too; default: 2")
      ->check(text::above_zero(true));
  command
      .add_option(
          "--tolerance", choices.tolerance,
          "of a cloud: mean error of the mesh [m]; all stages as fast as that allows, by "
          "fidelity/chain_cloud.yaml in --config (chain_cloud_hand.yaml for other hands than "
          "the PG70, and all platforms but stage_pg70). --budget [s of processor] chooses for a "
          "cloud from it, too: what "
          "lifts most within that from the cloud to grasps")
      ->transform(text::in_metres())
      ->check(text::in_range(1e-6, 1.0));
  CLI::Option* hand =
      command
          .add_option("--hand", choices.hand,
                      "a hand alone, without an arm, of robots/ in --config or a file: " +
                          joined(robot::hand_names(choices.config + "/robots")))
          ->capture_default_str();
  CLI::Option* platform =
      command
          .add_option("--platform", choices.platform,
                      "an arm with a hand, of robots/ in --config or a file: grasps and the arm's "
                      "motion; " +
                          joined(robot::platform_names(choices.config + "/robots")))
          ->excludes(hand);
  command.add_option("--approach", choices.approach, "directions of approach: straight down, any")
      ->check(CLI::IsMember({"down", "any"}))
      ->capture_default_str();
  command
      .add_option(
          "--generators", choices.generators,
          "of candidates: circles, segments, boxes, antipodal, medial_axis, or plug-ins' in "
          "PREHEND_GENERATORS; default: the planner's")
      ->delimiter(',');
  command.add_option("--preshapes", choices.preshapes, "of a hand with fingers; default: all")
      ->delimiter(',');
  command.add_option("--move", choices.move, "with a platform: put it this far away, x,y,z [m]")
      ->delimiter(',')
      ->expected(3);
  command
      .add_option(
          "--path-planner", choices.path_planner,
          "finds the arm's free paths: rrt_connect (default), ompl_rrt_connect, ompl_bitrrt, "
          "ompl_kpiece, or a plug-in's in PREHEND_PLANNERS")
      ->needs(platform);
  command
      .add_option("--collision-checker", choices.collision_checker,
                  "what the arm must not touch is tested by: balls that hold its links (default), "
                  "the links' own shapes by fcl or bullet, or a plug-in in PREHEND_CHECKERS")
      ->needs(platform);
  command.add_option("--seed", choices.seed, "of all random choices")->capture_default_str();
  command.add_option("--rows", choices.rows, "grasps to list at most")
      ->check(text::above_zero())
      ->capture_default_str();
  command.add_option("--database", choices.database,
                     "file of grasps of known meshes: those of this mesh and hand are tried first, "
                     "and what is found is added (prehend grasps lists them)");
  command.add_option("--known", choices.known,
                     "folder of meshes: when the object of a cloud is one of them, its mesh is "
                     "planned on instead of a predicted one");
  command.add_option("--config", choices.config, "folder with robots/ and fidelity/")
      ->capture_default_str();
  command
      .add_option("--remedy-budget", choices.remedy_budget,
                  "where there is no grasp, or no motion: for finding out what would help, by "
                  "planning again with other openings, forces, masses, ... [s]; 0: it is not")
      ->transform(text::in_seconds())
      ->check(text::in_range(0.0, 3600.0))
      ->capture_default_str();
  command.add_option("--out", choices.out, "folder for a page with pictures");
  command.add_option(
      "--save", choices.save,
      "folder for the object's mesh (object.ply, .obj, .stl; metres, world frame) and "
      "what --json prints (plan.json)");
  command.add_flag("--json", choices.json, "print JSON for programs");
  const OfferKnobs of_grasps{command, &choices.grasp_knobs, "Grasps"};
  grasp::PlannerOptions grasps;
  grasp::PlannerOptions::knobs(grasps, of_grasps);
  grasp::PadOptions::knobs(
      grasps.pads, OfferKnobs{command, &choices.grasp_knobs, "Grasps of parallel grippers"});
  grasp::FingerOptions::knobs(
      grasps.fingers, OfferKnobs{command, &choices.grasp_knobs, "Grasps of hands with fingers"});
  planning::PlatformPickOptions arm;
  planning::PlatformPickOptions::knobs(
      arm, OfferKnobs{command, &choices.arm_knobs, "The arm's motion", "arm_"});
  planning::DecisionOptions decision;
  planning::DecisionOptions::knobs(
      decision, OfferKnobs{command, &choices.decision_knobs, "What acts are worth", "decide_"});
}

}  // namespace prehend::tools
