#include "eval/case_choice.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "prehend/geometry/errors.h"
#include "prehend/text/command_line.h"
#include "prehend/text/nearest_match.h"

namespace prehend::eval {
namespace {

constexpr int kOrientations = 8;
constexpr int kQuickOrientations = 2;

void check_once(const std::string& option, std::vector<std::uint64_t> seeds) {
  std::sort(seeds.begin(), seeds.end());
  if (std::adjacent_find(seeds.begin(), seeds.end()) == seeds.end()) return;
  throw geometry::InputError(option + " gives a seed twice", "Give every seed once");
}

/// Those of `only`; all when it is empty.
std::vector<DataSet> named(std::vector<DataSet> sets, const std::vector<std::string>& only) {
  if (only.empty()) return sets;
  std::vector<std::string> names;
  for (const DataSet& set : sets) names.push_back(set.name);
  check_only(only, names, "data set");
  std::erase_if(sets, [&only](const DataSet& set) {
    return std::find(only.begin(), only.end(), set.name) == only.end();
  });
  return sets;
}

}  // namespace

void check_only(const std::vector<std::string>& only, const std::vector<std::string>& names,
                const std::string& what) {
  for (const std::string& name : only) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    throw geometry::InputError("No " + what + " has the name '" + name + "' that --only gives",
                               text::nearest_match_mend(name, names));
  }
}

void check_platforms(std::vector<std::string> platforms) {
  std::sort(platforms.begin(), platforms.end());
  const auto twice = std::adjacent_find(platforms.begin(), platforms.end());
  if (twice == platforms.end()) return;
  throw geometry::InputError("--platform names '" + *twice + "' twice", "Name every one once");
}

CaseChoice default_choice(const std::filesystem::path& out) {
  CaseChoice choice;
  choice.runs.out = out;
  choice.runs.processes = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return choice;
}

void add_case_options(CLI::App& app, CaseChoice& choice, bool views) {
  app.add_option("--out", choice.runs.out, "folder of the page, tables, figures and single results")
      ->capture_default_str();
  app.add_option("--json", choice.json, "file for the goals and totals");
  app.add_option(
         "--groups", choice.groups,
         "of bodies: household; scanned (with PREHEND_SHARED_DATA); hard: vessels, stacks, hidden, "
         "cut, tiny and dark things; held: the same in other shapes, for closing tables only; "
         "varied: scenes drawn at random, see --drawn; "
         "default: household and scanned")
      ->check(CLI::IsMember(known_groups()));
  app.add_option("--drawn", choice.drawn,
                 "seeds from which the scenes of the group varied are drawn, 18 each; default: 1");
  app.add_option(
         "--meshes", choice.meshes,
         "evaluate the OBJ, PLY and STL meshes (closed, metres, z up) of this folder instead")
      ->excludes("--groups");
  app.add_option("--only", choice.only, "names of the data sets to evaluate; default: all");
  if (views) app.add_flag("--quick", choice.quick, "two orientations instead of eight");
  app.add_flag("--list", choice.list, "print the names of the chosen cases and evaluate nothing");
  app.add_option("--seed", choice.seeds,
                 "of texture, noise and sampling; each case is there with each seed")
      ->capture_default_str();
  add_run_options(app, choice.runs);
}

std::vector<DataSet> chosen_data_sets(const CaseChoice& choice) {
  if (choice.drawn.empty()) {
    return named(data_sets_to_evaluate(choice.meshes, choice.groups), choice.only);
  }
  const std::vector<std::string>& groups = choice.groups;
  if (std::find(groups.begin(), groups.end(), "varied") == groups.end()) {
    throw geometry::InputError("--drawn gives seeds of scenes that are not evaluated",
                               "Give --groups varied, too");
  }
  check_once("--drawn", choice.drawn);
  return named(data_sets_to_evaluate(choice.meshes, groups, choice.drawn), choice.only);
}

const std::vector<std::uint64_t>& chosen_seeds(const CaseChoice& choice) {
  check_once("--seed", choice.seeds);
  return choice.seeds;
}

std::vector<Case> chosen_cases(const std::vector<DataSet>& sets, const CaseChoice& choice) {
  return of_each_seed(choice, [&](std::uint64_t seed) {
    return make_cases(sets, choice.quick ? kQuickOrientations : kOrientations, seed);
  });
}

int list_cases(const std::vector<Case>& cases) {
  for (const Case& one : cases) std::printf("%s\n", one.name().c_str());
  return EXIT_SUCCESS;
}

int parse_and_run(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
  if (const auto code = text::parse_command_line(app, argc, argv)) return *code;
  try {
    return work();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}

}  // namespace prehend::eval
