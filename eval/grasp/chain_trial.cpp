#include "eval/grasp/chain_trial.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "eval/case_runner.h"
#include "eval/grasp/seen_object.h"
#include "eval/household_objects.h"
#include "eval/processor_time.h"
#include "eval/resting_pose.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/plan_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

using fidelity::Setting;
using fidelity::Stage;
using Knobs = std::vector<std::pair<std::string, std::string>>;

Setting of_knobs(Knobs knobs) {
  Setting setting;
  setting.knobs = std::move(knobs);
  return setting;
}

std::vector<Setting> segmentation_settings() {
  const auto segmentation = [](const char* points, const char* clustering, const char* table_leaf) {
    return of_knobs({{"points", points}, {"clustering", clustering}, {"table_leaf", table_leaf}});
  };
  return {segmentation("40000", "organized", "0.016"), segmentation("200000", "organized", "0.016"),
          segmentation("all", "euclidean", "0.008")};
}

std::vector<Setting> seeing_settings() {
  const auto seeing = [](const char* binning, const char* stereo, const char* clustering,
                         const char* table_leaf) {
    return of_knobs({{"binning", binning},
                     {"stereo", stereo},
                     {"search", "narrow"},
                     {"clustering", clustering},
                     {"table_leaf", table_leaf}});
  };
  return {seeing("4", "semi_global", "organized", "0.016"),
          seeing("2", "block_matching", "organized", "0.016"),
          seeing("2", "semi_global", "organized", "0.016"),
          seeing("1", "semi_global", "euclidean", "0.008")};
}

std::vector<Setting> shape_settings() {
  const auto shape = [](const char* thinning, const char* orientations, const char* shifts,
                        const char* refine, const char* spacing, const char* resolution,
                        const char* pieces, const char* alternatives) {
    return of_knobs({{"thinning", thinning},
                     {"orientations", orientations},
                     {"shifts", shifts},
                     {"refine", refine},
                     {"spacing", spacing},
                     {"surface", "fast"},
                     {"resolution", resolution},
                     {"pieces", pieces},
                     {"alternatives", alternatives}});
  };
  return {shape("0.1", "15", "11", "no", "0.006", "32", "0.01", "0"),
          shape("0.04", "31", "21", "yes", "0.006", "32", "0.008", "0"),
          shape("0.02", "61", "41", "yes", "0.005", "48", "0.006", "0"),
          shape("0.02", "61", "41", "yes", "0.004", "64", "0.004", "0"),
          shape("0.02", "61", "41", "yes", "0", "64", "0.004", "2")};
}

// A parallel gripper has many candidates that cost little each, a hand few that are closed; what
// its pads will feel is a simulation of its own. A short plan of few candidates comes first.
std::vector<Setting> plan_settings(const robot::HandModel& hand) {
  struct Plan {
    const char *rolls, *standoffs, *offsets, *samples, *motions;
    const char* step = nullptr;  // of a hand
    const char *count = nullptr, *first_share = nullptr, *further = nullptr;
  };
  const std::vector<Plan> of_jaws{{"6", "3", "1", "4", "1", nullptr, "8", "16"},
                                  {"8", "4", "1", "4", "1", nullptr, "8", "16"},
                                  {"6", "3", "1", "0", "1"},
                                  {"12", "4", "1", "4", "1"},
                                  {"12", "6", "3", "4", "3"},
                                  {"12", "6", "3", "16", "3"}};
  const std::vector<Plan> of_fingers{{"3", "2", "1", "4", "1", "none", "8", "16", "none"},
                                     {"4", "2", "1", "4", "1", "none", "16", "8", "none"},
                                     {"4", "2", "1", "4", "1", "none"},
                                     {"4", "2", "1", "4", "1", "0.01"},
                                     {"6", "3", "1", "16", "3", "0.004"}};
  std::vector<Setting> settings;
  for (const Plan& plan : hand.gripper ? of_jaws : of_fingers) {
    Setting setting = of_knobs({{"plan.generators", "circles"},
                                {"plan.rolls", plan.rolls},
                                {"plan.standoffs", plan.standoffs},
                                {"plan.offsets", plan.offsets},
                                {"plan.samples", plan.samples},
                                {"motion.grasps", plan.motions}});
    for (const auto& [knob, value] :
         {std::pair("plan.count", plan.count), std::pair("plan.first_share", plan.first_share),
          std::pair("plan.further", plan.further), std::pair("simulation.step", plan.step)}) {
      if (value != nullptr) setting.knobs.emplace_back(knob, value);
    }
    settings.push_back(std::move(setting));
  }
  return settings;
}

// What a stage gives, and its processor time: the smaller of two runs, as nodes that go on have
// their memory and what they make once.
template <class Result>
struct Timed {
  std::optional<Result> result;  // none: it failed
  double seconds = std::numeric_limits<double>::infinity();
};

template <class Result>
Timed<Result> timed(const std::function<Result()>& stage) {
  Timed<Result> timed;
  for (int run = 0; run < 2; ++run) {
    const double start = processor_time();
    try {
      timed.result = stage();
    } catch (const geometry::InputError&) {
      // That chain does not lift it. Anything else is a bug, and ends the case in words.
    }
    timed.seconds = std::min(timed.seconds, processor_time() - start);
  }
  return timed;
}

ChainTrial planned_and_lifted(const PlatformUnderTest& platform, const Belief& belief,
                              const TrueObject& truth, const Setting& chain) {
  PlannerSetting planner;
  fidelity::Front chains;
  chains.subject = "chain";
  planner.change = change_by(chains, chain);
  ChainTrial trial;
  try {
    const GraspTrial tried =
        platform.grasp(belief, truth, planner,
                       [](const geometry::RigidTransform&, const belief::Attempt&) -> Belief {
                         throw geometry::InputError("The first attempt alone counts", "");
                       });
    trial.seconds[2] = tried.plan_seconds;
    trial.planned = tried.attempts > 0;
    trial.lifted = tried.lifted_at_first();
  } catch (const geometry::InputError&) {
    // Not lifted.
  }
  return trial;
}

}  // namespace

std::array<std::size_t, 3> ChainGrid::levels(std::size_t chain) const {
  return {chain / (shape.size() * plan.size()), chain / plan.size() % shape.size(),
          chain % plan.size()};
}

Setting ChainGrid::setting(std::size_t chain) const {
  const auto [s, h, p] = levels(chain);
  Setting whole;
  for (const auto& [stage, own] :
       {std::pair(fidelity::first_stage(input), &seeing[s]), std::pair(Stage::kShape, &shape[h]),
        std::pair(Stage::kPlan, &plan[p])}) {
    for (const auto& [knob, value] : own->knobs) {
      // Those of planning have the names of their stages already.
      whole.knobs.emplace_back(
          stage == Stage::kPlan ? knob : fmt::format("{}.{}", fidelity::to_string(stage), knob),
          value);
    }
  }
  return whole;
}

ChainGrid chain_grid(fidelity::ChainInput input, const robot::HandModel& hand, bool quick) {
  ChainGrid grid{
      input, input == fidelity::ChainInput::kImages ? seeing_settings() : segmentation_settings(),
      shape_settings(), plan_settings(hand)};
  if (!quick) return grid;
  for (std::vector<Setting>* stage : {&grid.seeing, &grid.shape}) {
    *stage = {stage->front(), stage->back()};
  }
  return grid;
}

std::vector<ChainTrial> run_chains(const Case& one, const PlatformUnderTest& platform,
                                   const ChainGrid& grid) {
  const geometry::TriangleMesh& mesh_B = *one.data_set->mesh_B;
  const double mass = household_mass(geometry::mass_properties(mesh_B).volume);
  const geometry::RigidTransform X_WB = resting_pose(mesh_B, one.X_WB(), mass, {});
  const TrueObject truth{geometry::transformed(mesh_B, X_WB), mass, {}};
  RenderedScene rendered = scene_of(one);
  rendered.bodies.front().X_WB = X_WB;
  simulation::RenderOptions render;
  render.threads = 1;
  const auto images = simulation::render_stereo(rendered.scene, rendered.bodies, 0, render);

  std::optional<geometry::PointCloud> cloud_C;
  if (grid.input == fidelity::ChainInput::kCloud) cloud_C = seen_cloud(rendered, images);
  std::vector<ChainTrial> trials;
  for (const Setting& seeing : grid.seeing) {
    fidelity::SeeingOptions see;
    if (cloud_C) {
      fidelity::apply_segmentation_setting(seeing, &see);
    } else {
      fidelity::apply_seeing_setting(seeing, &see);
    }
    const auto seen = timed<SeenObject>([&] {
      return cloud_C ? see_object(rendered, images, *cloud_C, see)
                     : see_object(rendered, images, see);
    });
    for (const Setting& shape : grid.shape) {
      Timed<Belief> belief;
      ChainTrial shared;
      if (seen.result) {
        belief = timed<Belief>([&] {
          return believed_object(one, *seen.result, PlannedOn::kPredicted,
                                 fidelity::shape_options(shape));
        });
      }
      shared.seconds = {seen.seconds, belief.seconds, 0};
      if (belief.result) {
        shared.mesh_error =
            measured(geometry::transformed(belief.result->object.mesh_W, X_WB.inverse()), mesh_B,
                     one.seed)
                .mean;
      }
      for (std::size_t plan = 0; plan < grid.plan.size(); ++plan) {
        const Setting chain = grid.setting(trials.size());
        ChainTrial& trial = trials.emplace_back();
        if (belief.result) trial = planned_and_lifted(platform, *belief.result, truth, chain);
        trial.seconds[0] = shared.seconds[0];
        trial.seconds[1] = shared.seconds[1];
        trial.mesh_error = shared.mesh_error;
      }
    }
  }
  return trials;
}

std::string to_text(const std::vector<ChainTrial>& trials) {
  YAML::Emitter out;
  out.SetDoublePrecision(9);
  out << YAML::BeginSeq;
  for (const ChainTrial& trial : trials) {
    out << YAML::Flow << YAML::BeginMap << YAML::Key << "seconds" << YAML::Value << YAML::Flow
        << YAML::BeginSeq;
    for (const double seconds : trial.seconds) out << seconds;
    out << YAML::EndSeq << YAML::Key << "mesh_error" << YAML::Value << trial.mesh_error << YAML::Key
        << "planned" << YAML::Value << trial.planned << YAML::Key << "lifted" << YAML::Value
        << trial.lifted << YAML::EndMap;
  }
  out << YAML::EndSeq;
  return out.c_str();
}

std::vector<ChainTrial> read_chain_trials(const std::string& text) {
  try {
    std::vector<ChainTrial> trials;
    for (const YAML::Node& node : YAML::Load(text)) {
      ChainTrial& trial = trials.emplace_back();
      for (std::size_t i = 0; i < trial.seconds.size(); ++i) {
        trial.seconds[i] = node["seconds"][i].as<double>();
      }
      trial.mesh_error = node["mesh_error"].as<double>();
      trial.planned = node["planned"].as<bool>();
      trial.lifted = node["lifted"].as<bool>();
    }
    return trials;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result: ") + error.what(),
                               "Run the case again");
  }
}

}  // namespace prehend::eval
