// Grasps that the planner makes, tried as DexGraspBench tries them: how many hold, and how fast
// they are made.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/grasp/dexgrasp_report.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/robot/robot_files.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/text/command_line.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

struct DexOptions {
  eval::CaseRunOptions runs{.out = "out/dexgrasp"};
  fs::path json, meshes;
  std::vector<std::string> groups{"household"}, only;
  std::vector<std::string> hands{"pg70", "sdh2", "bh8"};
  fs::path robots = "config/robots";
  eval::DexChoice choice;
  bool quick = false, list = false, rank_by_shape = false;
};

struct NamedCase {
  std::string name;
  const eval::DexHand* hand;
  const eval::DataSet* object;
  eval::DexTest test;
};

std::vector<eval::DataSet> objects_of(const DexOptions& options) {
  std::vector<eval::DataSet> objects = eval::data_sets_to_evaluate(options.meshes, options.groups);
  std::vector<std::string> names;
  for (const eval::DataSet& one : objects) names.push_back(one.name);
  eval::check_only(options.only, names, "object");
  if (!options.only.empty()) {
    std::erase_if(objects, [&](const eval::DataSet& one) {
      return std::find(options.only.begin(), options.only.end(), one.name) == options.only.end();
    });
  } else if (options.quick) {  // every third
    std::vector<eval::DataSet> some;
    for (std::size_t i = 0; i < objects.size(); i += 3) some.push_back(objects[i]);
    objects = std::move(some);
  }
  return objects;
}

std::vector<NamedCase> cases_of(const std::deque<eval::DexHand>& hands,
                                const std::vector<eval::DataSet>& objects) {
  std::vector<NamedCase> cases;
  for (const eval::DexHand& hand : hands) {
    for (const eval::DataSet& object : objects) {
      for (const eval::DexTest test : {eval::DexTest::kForceClosure, eval::DexTest::kTabletop}) {
        cases.push_back({fmt::format("{}_{}_{}_{:08x}_{}", hand.model.name, object.group,
                                     object.name, object.content, to_string(test)),
                         &hand, &object, test});
      }
    }
  }
  return cases;
}

// What the cases' results depend on besides their names.
std::string setting_of(const DexOptions& options) {
  const eval::DexChoice& choice = options.choice;
  return fmt::format(
      "engine {} {} seed {} grasps {} threads {} friction {} stiffness {} safety {} equal {} "
      "robust {} generators {} samples {}",
      choice.protocol.engine, choice.protocol.solver, choice.seed, choice.grasps, choice.threads,
      choice.protocol.friction, choice.protocol.stiffness, choice.protocol.safety,
      choice.protocol.equal_efforts, choice.robust, fmt::join(choice.generators, ","),
      choice.samples);
}

// Refused before anything is planned.
void check_engine(const eval::DexProtocol& protocol) {
  const auto engine = simulation::engines::EngineRegistry().create(protocol.engine);
  const std::vector<std::string> solvers = engine->solvers();
  if (protocol.solver.empty() ||
      std::find(solvers.begin(), solvers.end(), protocol.solver) != solvers.end()) {
    return;
  }
  throw geometry::InputError(
      fmt::format("The engine {} has no solver '{}'", protocol.engine, protocol.solver),
      fmt::format("Give one of {}", fmt::join(solvers, ", ")));
}

int run(DexOptions options) {
  check_engine(options.choice.protocol);
  const grasp::GeneratorRegistry known;
  for (const std::string& name : options.choice.generators) known.create(name);
  std::deque<eval::DexHand> hands;
  for (const std::string& name : options.hands) {
    hands.emplace_back(robot::read_hand_model(robot::hand_file(options.robots, name)),
                       options.choice.protocol.friction);
  }
  options.choice.robust = !options.rank_by_shape;
  const std::vector<eval::DataSet> objects = objects_of(options);
  const std::vector<NamedCase> cases = cases_of(hands, objects);
  std::vector<std::string> names;
  for (const NamedCase& one : cases) names.push_back(one.name);
  if (options.list) {
    for (const std::string& name : names) std::printf("%s\n", name.c_str());
    return EXIT_SUCCESS;
  }
  options.runs.setting = setting_of(options);
  const auto results =
      eval::found_results(eval::run_cases(options.runs, names, eval::read_dex_case, [&](int i) {
        const NamedCase& one = cases[static_cast<std::size_t>(i)];
        return eval::run_dex_case(*one.hand, *one.object, one.test, options.choice);
      }));
  std::printf("%s", eval::dex_text(results).c_str());
  if (!options.json.empty()) eval::write_text(options.json, eval::dex_json(results));
  eval::write_dex_report(options.runs.out, results);
  std::printf("%s\n", (options.runs.out / "index.html").c_str());
  return results.size() == cases.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

void add_dex_options(CLI::App& app, DexOptions& options) {
  app.add_option("--out", options.runs.out, "folder of the page, tables and single results")
      ->capture_default_str();
  app.add_option("--json", options.json, "file for the totals");
  app.add_option("--hand", options.hands, "one or more: what is in --robots, or a file")
      ->capture_default_str();
  app.add_option("--robots", options.robots, "folder of the hands' files")
      ->check(CLI::ExistingDirectory)
      ->capture_default_str();
  app.add_option("--groups", options.groups, "of objects, as eval_grasp has them")
      ->check(CLI::IsMember(eval::known_groups()))
      ->capture_default_str();
  app.add_option("--meshes", options.meshes,
                 "grasp the OBJ, PLY and STL meshes (closed, metres, z up) of this folder instead")
      ->check(CLI::ExistingDirectory)
      ->excludes("--groups");
  app.add_option("--only", options.only, "names of the objects; default: all");
  app.add_option("--engine", options.choice.protocol.engine,
                 "physics; it must do meshes and joints that follow others")
      ->capture_default_str();
  app.add_option("--solver", options.choice.protocol.solver, "of the engine; empty: its first")
      ->capture_default_str();
  app.add_option("--grasps", options.choice.grasps,
                 "tried of each plan, the best ones; 0: measures planning alone")
      ->check(text::in_range(0, 10000))
      ->capture_default_str();
  app.add_option("--friction", options.choice.protocol.friction, "of all there is")
      ->check(text::in_range(0.001, 10.0))
      ->capture_default_str();
  app.add_option("--stiffness", options.choice.protocol.stiffness,
                 "of the fingers' position loops [N m/rad]")
      ->check(text::in_range(0.1, 100.0))
      ->capture_default_str();
  app.add_option("--safety", options.choice.protocol.safety,
                 "of the fingers' forces that squeeze over those that just bear the pull")
      ->check(text::in_range(0.1, 100.0))
      ->capture_default_str();
  app.add_flag(
      "--equal-efforts", options.choice.protocol.equal_efforts,
      "fingers squeeze with the plan's share of what each motor can, not with forces that cancel "
      "each other");
  app.add_flag("--rank-by-shape", options.rank_by_shape,
               "ranks grasps without the planner's trials of each in disturbed poses");
  CLI::Option* generators =
      app.add_option("--generators", options.choice.generators,
                     "of candidates, as prehend plan has them; default: the hand's own")
          ->delimiter(',');
  app.add_option("--samples", options.choice.samples,
                 "of the surface: antipodal points, medial balls, rays of each box side")
      ->check(text::in_range(1, 100000))
      ->needs(generators);
  app.add_option("--seed", options.choice.seed, "of candidates and of disturbed poses")
      ->capture_default_str();
  app.add_option("--threads", options.choice.threads, "of planning, in each process")
      ->check(text::in_range(1, 256))
      ->capture_default_str();
  app.add_flag("--quick", options.quick, "every third object");
  app.add_flag("--list", options.list, "print the names of the cases and do nothing");
  eval::add_run_options(app, options.runs);
}

}  // namespace

int main(int argc, char** argv) {
  DexOptions options;
  CLI::App app(
      "Plans grasps of known bodies with hands alone and tries them as DexGraspBench does: the "
      "body "
      "weighs 100 g, friction is 0.6; the hand's root stands, the fingers close and squeeze; then "
      "the body is pulled with 1 N along each axis (force_closure), or lifted by 10 cm (tabletop). "
      "It holds when the body moves by less than 5 cm and turns by less than 15 degrees. Measures "
      "how fast grasps are made, too: valid by the planner, and distinct by 5 mm, 10 degrees and "
      "0.1 rad of the joints. A run that was interrupted goes on where it was; the same choice "
      "gives the same figures, but for the seconds.");
  add_dex_options(app, options);
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}
