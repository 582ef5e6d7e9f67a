#include "eval/grasp/extreme_case.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "eval/case_runner.h"
#include "eval/grasp/seen_object.h"
#include "eval/household_objects.h"
#include "eval/processor_time.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/stereo.h"
#include "prehend/simulation/random_draw.h"

namespace prehend::eval {
namespace {

using geometry::InputError;
using geometry::RigidTransform;

constexpr double kDegree = std::numbers::pi / 180;

// The object by its name, of the size.
DataSet scaled_object(const ExtremeCase& extreme) {
  for (const EvaluationObject& object : household_objects()) {
    if (object.name != extreme.object) continue;
    geometry::TriangleMesh mesh = *object.mesh_B;
    const double scale = extreme.size / geometry::bounds(mesh).sizes().maxCoeff();
    for (Eigen::Vector3d& p : mesh.vertices) p *= scale;
    DataSet set{"extreme", object.name, nullptr, object.symmetric, {}};
    set.mesh_B = std::make_shared<const geometry::TriangleMesh>(std::move(mesh));
    set.viewing.distance = extreme.distance;
    set.viewing.elevation = extreme.elevation;
    return set;
  }
  throw InputError("There is no object '" + extreme.object + "'",
                   "Take one of household_objects(), as can or milk_carton");
}

// A picture of about so many pixels of the usual angle, of the object's middle.
RenderedScene scene_of_extreme(const Case& one, const ExtremeCase& extreme) {
  RenderedScene rendered = scene_of(one);
  geometry::PinholeCamera& camera = rendered.scene.camera.camera.left;
  const double wide = camera.width;
  camera.width = static_cast<int>(std::lround(std::sqrt(extreme.points * 4 / 3)));
  camera.height = static_cast<int>(std::lround(extreme.points / camera.width));
  camera.fx = camera.fy = camera.fx * camera.width / wide;
  camera.cx = (camera.width - 1) / 2.0;
  camera.cy = (camera.height - 1) / 2.0;
  simulation::CameraSetup& setup = rendered.scene.camera;
  const Eigen::Vector3d middle(0, 0, geometry::bounds(*one.data_set->mesh_B).center().z());
  setup.eye += middle - setup.target;
  setup.target = middle;
  return rendered;
}

double gaussian(simulation::RandomDraw& draw) {  // Box and Muller
  return std::sqrt(-2 * std::log(1 - draw.unit())) * std::cos(2 * std::numbers::pi * draw.unit());
}

void spoil(const ExtremeCase& extreme, geometry::DepthImage* depth) {
  simulation::RandomDraw draw(extreme.seed);
  for (float& z : depth->data) {
    if (draw.unit() < extreme.outliers) {
      z *= static_cast<float>(draw.between(0.5, 1.5));
    } else {
      z += static_cast<float>(extreme.noise * gaussian(draw));
    }
  }
}

struct Seen {
  SeenObject object;
  bool is_truth = true;  // it has the truth's pixels
};

Seen see_extreme(const RenderedScene& rendered, const RigidTransform& X_WC,
                 const ExtremeCase& extreme, double* seconds) {
  simulation::RenderOptions render;
  render.threads = 1;
  simulation::StereoImages images =
      simulation::render_stereo(rendered.scene, rendered.bodies, 0, render);
  spoil(extreme, &images.depth);
  const geometry::PinholeCamera& camera = rendered.scene.camera.camera.left;
  const double start = processor_time();
  Seen seen;
  try {
    seen.object.scene = perception::segment(
        perception::cloud_from_depth(images.depth, camera, images.left), camera, X_WC);
  } catch (const InputError&) {
    *seconds = processor_time() - start;
    throw;
  }
  *seconds = processor_time() - start;
  const perception::SegmentedScene& scene = seen.object.scene;
  if (scene.objects.empty()) throw InputError(perception::why_no_objects(scene), "Look again");
  const std::optional<std::size_t> object = object_of(scene, images.labels);
  seen.is_truth = object.has_value();
  seen.object.index = object.value_or(0);
  return seen;
}

double mesh_error(const geometry::TriangleMesh& mesh_W, const geometry::TriangleMesh& truth_W,
                  std::uint64_t seed) {
  const MethodResult distances = measured(mesh_W, truth_W, seed);
  return std::max(distances.mean, distances.back_mean);
}

// What the plan and the lift made of it, besides the mesh.
void grasp_extreme(const PlatformUnderTest& platform, const Belief& belief, const TrueObject& truth,
                   ExtremeResult* result) {
  try {
    PlannerSetting setting;
    setting.name = to_string(PlannedOn::kPredicted);
    const GraspTrial trial = platform.grasp(
        belief, truth, setting, [](const RigidTransform&, const belief::Attempt&) -> Belief {
          throw InputError("The first attempt alone counts", "");
        });
    result->planned = trial.attempts > 0;
    result->lifted = trial.lifted_at_first();
    result->stage = trial.stage;
    result->message = result->planned ? trial.outcome : trial.problem;
    if (result->lifted) result->stage = result->message = "";
  } catch (const InputError& error) {
    result->stage = "plan";
    result->message = error.what();
  }
}

// Says what is wrong with the mesh, in place of what came of the grasp.
void blame_mesh(double allowed, bool is_truth, ExtremeResult* result) {
  result->stage = is_truth ? "shape" : "view";
  result->message =
      fmt::format("{} is off by {:.1f} mm (right within {:.1f} mm), confidence {:.2f}",
                  is_truth ? "the mesh" : "what is no object was taken for it: its mesh",
                  1e3 * result->mesh_error, 1e3 * allowed, result->confidence);
}

// The peak of this process's memory counts from now on.
void forget_peak() { std::ofstream("/proc/self/clear_refs") << 5; }

double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kilobytes = 0;
    if (word == "VmHWM:" && status >> kilobytes) return 1024 * kilobytes;
  }
  return kUnknown;
}

}  // namespace

std::string ExtremeCase::name() const {
  return fmt::format("{}-{:g}m-{:g}points-{:g}m-{:g}m-{:g}-{:g}deg-{:g}deg-{:g}kg-{:g}-seed{}",
                     object, size, points, distance, noise, outliers, tilt, elevation, mass,
                     friction, seed);
}

const char* to_string(ExtremeOutcome outcome) {
  switch (outcome) {
    case ExtremeOutcome::kWorks:
      return "works";
    case ExtremeOutcome::kRefused:
      return "refused";
    case ExtremeOutcome::kSaid:
      return "said";
    case ExtremeOutcome::kSilent:
      return "silent";
  }
  return "unknown";
}

double right_within(double size) { return size < 0.05 ? size / 10 : std::max(0.005, size / 20); }

ExtremeOutcome outcome_of(const ExtremeResult& result, double size) {
  const bool is_wrong = result.mesh_error > right_within(size);
  if (is_wrong && result.confidence >= kConfident) return ExtremeOutcome::kSilent;
  if (!result.planned) return ExtremeOutcome::kRefused;
  if (result.stage == kSaidUntruly) return ExtremeOutcome::kSilent;
  return result.lifted && !is_wrong ? ExtremeOutcome::kWorks : ExtremeOutcome::kSaid;
}

ExtremeResult run_extreme_case(const ExtremeCase& extreme, const PlatformUnderTest& platform) {
  forget_peak();
  const DataSet set = scaled_object(extreme);
  const Case one{&set, static_cast<int>(20 + 37 * (extreme.seed - 1)) % 360, extreme.seed};
  const TrueObject truth{
      geometry::transformed(*set.mesh_B, one.X_WB()), extreme.mass, {}, extreme.friction};
  const RenderedScene rendered = scene_of_extreme(one, extreme);
  // From the table's frame, in which it is level, to that of the camera's pose, L.
  RigidTransform X_LW = RigidTransform::Identity();
  X_LW.linear() =
      Eigen::AngleAxisd(extreme.tilt * kDegree, Eigen::Vector3d(1, 1, 0).normalized()).matrix();

  ExtremeResult result;
  double start = processor_time();
  const auto finish = [&] {
    result.rest_seconds = processor_time() - start;
    result.memory = peak_memory();
    return result;
  };
  std::optional<Seen> seen;
  Belief belief;
  result.stage = "view";
  try {
    seen = see_extreme(rendered, X_LW * rendered.scene.camera.X_WC(), extreme, &result.see_seconds);
    start = processor_time();
    result.stage = "shape";
    belief = believed_object(one, seen->object, PlannedOn::kPredicted);
  } catch (const InputError& error) {
    if (!seen) start = processor_time();
    result.message = error.what();
    return finish();
  }
  belief.object = surface::moved(belief.object, X_LW.inverse());
  result.confidence = surface::mesh_confidence(belief.shape->confidence, belief.object.substitute);
  result.mesh_error = mesh_error(belief.object.mesh_W, truth.mesh_W, extreme.seed);
  grasp_extreme(platform, belief, truth, &result);
  result.outcome = outcome_of(result, extreme.size);
  const double allowed = right_within(extreme.size);
  if (result.mesh_error > allowed && result.outcome != ExtremeOutcome::kRefused) {
    blame_mesh(allowed, seen->is_truth, &result);
  }
  return finish();
}

std::string to_text(const ExtremeResult& result) {
  YAML::Emitter out;
  out.SetDoublePrecision(6);
  out << YAML::BeginMap;
  const auto put = [&out](const char* key, const auto& value) {
    out << YAML::Key << key << YAML::Value << value;
  };
  put("outcome", static_cast<int>(result.outcome));
  put("stage", result.stage);
  put("message", result.message);
  put("confidence", result.confidence);
  put("mesh_error", result.mesh_error);
  put("planned", result.planned);
  put("lifted", result.lifted);
  put("see_seconds", result.see_seconds);
  put("rest_seconds", result.rest_seconds);
  put("memory", result.memory);
  out << YAML::EndMap;
  return out.c_str();
}

ExtremeResult read_extreme_result(const std::string& text) {
  try {
    const YAML::Node node = YAML::Load(text);
    ExtremeResult result;
    result.outcome = static_cast<ExtremeOutcome>(std::clamp(node["outcome"].as<int>(), 0, 3));
    result.stage = node["stage"].as<std::string>();
    result.message = node["message"].as<std::string>();
    result.confidence = node["confidence"].as<double>();
    result.mesh_error = node["mesh_error"].as<double>();
    result.planned = node["planned"].as<bool>();
    result.lifted = node["lifted"].as<bool>();
    result.see_seconds = node["see_seconds"].as<double>();
    result.rest_seconds = node["rest_seconds"].as<double>();
    result.memory = node["memory"].as<double>();
    return result;
  } catch (const YAML::Exception& error) {
    throw InputError(std::string("The text is no result: ") + error.what(), "Run the case again");
  }
}

}  // namespace prehend::eval
