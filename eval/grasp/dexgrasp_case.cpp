#include "eval/grasp/dexgrasp_case.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <yaml-cpp/yaml.h>
#include <Eigen/Geometry>

#include "eval/grasp/trial_setup.h"
#include "eval/processor_time.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/planner.h"
#include "prehend/surface/convex_pieces.h"

namespace prehend::eval {
namespace {

constexpr double kFarBelow = -10;  // m, of the table where there is none
constexpr int kAllGrasps = 10000;  // the most that a plan may list

struct DexFigure {
  const char* name;
  double DexOutcome::*value;
};
constexpr DexFigure kDexFigures[] = {{"shift", &DexOutcome::shift},
                                     {"turn", &DexOutcome::turn},
                                     {"start_depth", &DexOutcome::start_depth},
                                     {"depth", &DexOutcome::depth},
                                     {"self_depth", &DexOutcome::self_depth}};
struct DexCount {
  const char* name;
  int DexCase::*value;
};
constexpr DexCount kDexCounts[] = {{"candidates", &DexCase::candidates},
                                   {"valid", &DexCase::valid},
                                   {"distinct", &DexCase::distinct},
                                   {"listed", &DexCase::listed}};

// As exact as they can be made: what the planner's own pieces fill of a dent, as beside the seam of
// a carton, is a slope that a grasp slides off.
std::vector<geometry::TriangleMesh> pieces_to_touch(const geometry::TriangleMesh& mesh_W) {
  surface::ConvexPiecesOptions options;
  options.concavity = 0.001;
  options.max_voxels = 128;
  options.max_pieces = 256;
  return surface::convex_pieces(mesh_W, options).pieces;
}

bool are_alike(const robot::HandModel& hand, const grasp::Grasp& a, const grasp::Grasp& b,
               const DexDistance& distance) {
  if ((a.X_WH.translation() - b.X_WH.translation()).norm() >= distance.shift) return false;
  const Eigen::Matrix3d turn = a.X_WH.linear().transpose() * b.X_WH.linear();
  if (Eigen::AngleAxisd(turn).angle() >= distance.turn) return false;
  for (int i = 0; i < hand.size(); ++i) {
    const auto joint = static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(i)]);
    const bool slides = hand.model.joints[joint].kind == robot::Joint::Kind::kPrismatic;
    const double most = slides ? distance.slide : distance.joint;
    if (std::abs(a.closed[i] - b.closed[i]) >= most) return false;
  }
  return true;
}

// The benchmark says what the object weighs.
grasp::PlannerOptions dex_options(const DexHand& hand, const DexChoice& choice, double volume) {
  grasp::PlannerOptions options = grasp::default_options(hand.model);
  options.threads = choice.threads;
  options.candidates.seed = options.uncertainty.seed = choice.seed;
  options.density = choice.protocol.mass / volume;
  options.pads.friction = choice.protocol.friction;
  if (!choice.robust) options.uncertainty.samples = 0;
  if (!choice.generators.empty()) {
    options.generators = choice.generators;
    options.further_generators.clear();
  }
  if (choice.samples > 0) options.candidates.samples = choice.samples;
  return options;
}

geometry::Plane table_of(DexTest test) {
  geometry::Plane table;
  table.normal = Eigen::Vector3d::UnitZ();
  table.offset = test == DexTest::kTabletop ? 0 : kFarBelow;
  return table;
}

// All grasps there are; disturbed trials are of those that are listed, not of making them.
void measure_planning(const DexHand& hand, const surface::ObjectModel& object,
                      const geometry::Plane& table, grasp::PlannerOptions options,
                      DexCase* result) {
  options.largest_count = kAllGrasps;
  options.uncertainty.samples = 0;
  const auto begin = std::chrono::steady_clock::now();
  const double processor_begin = processor_time();
  const grasp::GraspPlan plan = plan_grasps(object, table, {}, hand.to_close, {}, options);
  result->processor_seconds = processor_time() - processor_begin;
  result->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result->candidates = plan.candidates;
  result->valid = static_cast<int>(plan.grasps.size());
  result->distinct = distinct_grasps(hand.model, plan.grasps);
  result->problem = plan.problem;
}

void put_dex_text(YAML::Emitter& out, const char* key, const std::string& text) {
  out << YAML::Key << key << YAML::Value << YAML::DoubleQuoted << text;
}

}  // namespace

int distinct_grasps(const robot::HandModel& hand, const std::vector<grasp::Grasp>& grasps,
                    const DexDistance& distance) {
  std::vector<const grasp::Grasp*> counted;
  for (const grasp::Grasp& one : grasps) {
    const bool known = std::any_of(counted.begin(), counted.end(), [&](const auto* other) {
      return are_alike(hand, one, *other, distance);
    });
    if (!known) counted.push_back(&one);
  }
  return static_cast<int>(counted.size());
}

DexCase run_dex_case(const DexHand& hand, const DataSet& object, DexTest test,
                     const DexChoice& choice) {
  DexCase result;
  result.hand = hand.model.name;
  result.group = object.group;
  result.object = object.name;
  result.test = test;
  const geometry::TriangleMesh& mesh_W = *object.mesh_B;
  const Belief belief = belief_of(mesh_W, {});
  const DexObject body(mesh_W, pieces_to_touch(mesh_W), choice.protocol);
  const grasp::PlannerOptions options =
      dex_options(hand, choice, geometry::mass_properties(mesh_W).volume);
  const geometry::Plane table = table_of(test);
  measure_planning(hand, belief.object, table, options, &result);
  if (choice.grasps == 0) return result;
  const grasp::GraspPlan plan = plan_grasps(belief.object, table, {}, hand.to_close, {}, options);
  result.listed = static_cast<int>(plan.grasps.size());
  const auto tried = std::min(plan.grasps.size(), static_cast<std::size_t>(choice.grasps));
  for (std::size_t i = 0; i < tried; ++i) {
    result.tried.push_back(run_dex_trial(hand, body, plan.grasps[i], test, choice.protocol));
  }
  return result;
}

std::string to_text(const DexCase& result) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  out << YAML::BeginMap;
  put_dex_text(out, "hand", result.hand);
  put_dex_text(out, "group", result.group);
  put_dex_text(out, "object", result.object);
  put_dex_text(out, "test", to_string(result.test));
  put_dex_text(out, "problem", result.problem);
  for (const DexCount& count : kDexCounts) {
    out << YAML::Key << count.name << YAML::Value << result.*count.value;
  }
  out << YAML::Key << "seconds" << YAML::Value << result.seconds;
  out << YAML::Key << "processor_seconds" << YAML::Value << result.processor_seconds;
  out << YAML::Key << "tried" << YAML::Value << YAML::BeginSeq;
  for (const DexOutcome& one : result.tried) {
    out << YAML::BeginMap << YAML::Key << "held" << YAML::Value << one.held;
    put_dex_text(out, "lost", one.lost);
    for (const DexFigure& figure : kDexFigures) {
      out << YAML::Key << figure.name << YAML::Value << one.*figure.value;
    }
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  return out.c_str();
}

DexCase read_dex_case(const std::string& text) {
  try {
    const YAML::Node node = YAML::Load(text);
    DexCase result;
    result.hand = node["hand"].as<std::string>();
    result.group = node["group"].as<std::string>();
    result.object = node["object"].as<std::string>();
    const bool floats = node["test"].as<std::string>() == to_string(DexTest::kForceClosure);
    result.test = floats ? DexTest::kForceClosure : DexTest::kTabletop;
    result.problem = node["problem"].as<std::string>();
    for (const DexCount& count : kDexCounts) result.*count.value = node[count.name].as<int>();
    result.seconds = node["seconds"].as<double>();
    result.processor_seconds = node["processor_seconds"].as<double>();
    for (const YAML::Node& one : node["tried"]) {
      DexOutcome& outcome = result.tried.emplace_back();
      outcome.held = one["held"].as<bool>();
      outcome.lost = one["lost"].as<std::string>();
      for (const DexFigure& figure : kDexFigures) {
        outcome.*figure.value = one[figure.name].as<double>();
      }
    }
    return result;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result of a grasp: ") + error.what(),
                               "Run the case again");
  }
}

}  // namespace prehend::eval
