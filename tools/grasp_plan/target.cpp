#include "tools/grasp_plan/target.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/grasp/closing/widest_opening.h"
#include "prehend/perception/recorded_cloud.h"
#include "prehend/planning/known_models.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "prehend/shape/body_evidence.h"
#include "prehend/shape/scene_completion.h"
#include "prehend/surface/model.h"
#include "prehend/surface/simplify.h"
#include "prehend/surface/size_on_table.h"

namespace prehend::tools {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr int kAlternatives = 2;  // by default

double since(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

// A PLY file can be either; its header says which.
bool is_mesh(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending != ".ply") return ending != ".pcd";
  std::ifstream stream(file, std::ios::binary);
  std::string line;
  for (int i = 0; i < 100 && std::getline(stream, line); ++i) {
    if (line.rfind("element face", 0) == 0) return line.find(" 0") == std::string::npos;
    if (line.rfind("end_header", 0) == 0) break;
  }
  return false;
}

constexpr std::size_t kMostTriangles = 100'000;  // more are worked on as half of that

// The mesh by --scale, else in metres, or in millimetres where metres would make it enormous.
geometry::TriangleMesh in_metres(const PlanChoices& choices, std::vector<std::string>& notes) {
  constexpr double kLargest = 3;    // m, of what is grasped
  constexpr double kLeastMm = 30;   // units, from which nothing but millimetres is plausible
  constexpr double kMostMm = 3000;  // units
  if (choices.scale) return geometry::read_mesh_file(choices.file, *choices.scale);
  geometry::TriangleMesh mesh = geometry::read_mesh_file(choices.file);
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  if (!(extent > kLargest)) return mesh;
  if (extent < kLeastMm || extent > kMostMm) {
    throw geometry::InputError(
        fmt::format("'{}' would be {:.3g} m large, so its unit is not the metre; it is {:.3g} m in "
                    "inches, {:.3g} m in centimetres, {:.3g} m in millimetres",
                    choices.file, extent, 0.0254 * extent, 0.01 * extent, 0.001 * extent),
        "Give --scale 0.0254, 0.01 or 0.001");
  }
  notes.push_back(
      fmt::format("the file's unit is taken for the millimetre: the mesh is {:.3g} m "
                  "large; --scale says otherwise",
                  1e-3 * extent));
  for (Eigen::Vector3d& p : mesh.vertices) p *= 1e-3;
  return mesh;
}

PlanTarget of_mesh(const PlanChoices& choices, Progress& progress) {
  PlanTarget target;
  auto start = steady_clock::now();
  progress.stage(fmt::format("reading '{}', {:.0f} MB", choices.file,
                             1e-6 * static_cast<double>(fs::file_size(choices.file))));
  geometry::TriangleMesh mesh = in_metres(choices, target.notes);
  grasp::PlacedObject known{"", fs::path(choices.file).stem().string(),
                            geometry::RigidTransform::Identity()};
  if (!choices.database.empty()) known.hash = grasp::content_hash(mesh);
  if (!choices.in_place) {
    const Eigen::AlignedBox3d box = geometry::bounds(mesh);
    known.X_WO.translation() =
        Eigen::Vector3d(-box.center().x(), -box.center().y(), -box.min().z());
    mesh = geometry::transformed(mesh, known.X_WO);
  }
  target.known = known;
  target.times.emplace_back("read", since(start));
  start = steady_clock::now();
  if (mesh.triangles.size() > kMostTriangles) {
    const std::string all = with_commas(mesh.triangles.size());
    progress.stage(
        fmt::format("reducing {} triangles to {}", all, with_commas(kMostTriangles / 2)));
    surface::SimplifiedMesh fewer = surface::simplified(mesh, kMostTriangles / 2);
    target.notes.push_back(
        fmt::format("of the mesh's {} triangles {} are worked on, off by at most {:.2g} mm at {} "
                    "points of either mesh",
                    all, with_commas(fewer.mesh.triangles.size()), 1e3 * fewer.error,
                    with_commas(surface::kErrorPoints)));
    mesh = std::move(fewer.mesh);
    target.times.emplace_back("fewer triangles", since(start));
    start = steady_clock::now();
  }
  progress.stage("cutting " + with_commas(mesh.triangles.size()) + " triangles into convex pieces");
  target.object = surface::model_of_mesh(std::move(mesh));
  if (!target.object.defects.watertight()) {
    target.notes.push_back("the mesh is not closed (" + target.object.defects.to_string() +
                           "): its convex hull gives weight and collisions");
  }
  target.times.emplace_back("convex pieces", since(start));
  return target;
}

// Whether the object is one of the folder's; says so either way.
bool take_known(const PlanChoices& choices, const perception::SegmentedScene& scene,
                const perception::ObjectHypothesis& seen, PlanTarget* target) {
  const planning::KnownModels models(choices.known);
  planning::KnownModels::Found found = models.recognise(scene, seen);
  const grasp::Recognition& best = found.best;
  if (!best.accepted) {
    target->notes.push_back(fmt::format("it is none of the {} known objects; the nearest is {}: {}",
                                        models.size(), best.name, best.reason));
    return false;
  }
  target->notes.push_back(
      fmt::format("it is the known object {}: {:.0f} % of the seen points are on its surface",
                  best.name, 100 * best.explained));
  target->known = {best.hash, best.name, best.X_WO};
  target->object = std::move(found.model_W);
  return true;
}

/// Of the hand that is planned for [m].
double widest_opening(const PlanChoices& choices) {
  const fs::path robots = fs::path(choices.config) / "robots";
  if (choices.platform.empty()) {
    return grasp::widest_opening(robot::read_hand_model(robot::hand_file(robots, choices.hand)));
  }
  return grasp::widest_opening(
      robot::read_platform(robot::platform_file(robots, choices.platform)).hand);
}

PlanTarget of_cloud(const PlanChoices& choices, Progress& progress) {
  PlanTarget target;
  auto start = steady_clock::now();
  progress.stage("segmenting '" + choices.file + "'");
  const auto recorded = perception::interpret_recorded_cloud(
      geometry::read_cloud_file(choices.file),
      perception::read_recorded_cloud_options(choices.scale.value_or(1), choices.viewpoint,
                                              choices.up, choices.table));
  target.notes = recorded.notes;
  fidelity::SeeingOptions seeing;
  perception::SegmentationOptions& segmentation = seeing.segmentation;
  if (!choices.split.empty()) {
    std::optional<double> opening;
    if (choices.split == "wide") opening = widest_opening(choices);
    perception::choose_splitting(choices.split, opening, &segmentation);
  }
  segmentation.body_evidence = shape::log_odds_of_one_body;
  fidelity::ShapeOptions shape_options;
  shape_options.completion.alternatives = choices.alternatives.value_or(kAlternatives);
  target.chain = chosen_chain(choices);
  if (target.chain) {
    const fidelity::Front& front = target.chain->front;
    const fidelity::Setting& setting = target.chain->setting;
    fidelity::apply_first_stage(front, setting, &seeing);
    shape_options = fidelity::shape_options(stage_setting(front, setting, fidelity::Stage::kShape));
    target.notes.push_back("chosen: " + to_string(setting) + " (" + measured_text(front, setting) +
                           ")");
  }
  const perception::SegmentedScene scene = perception::segment_recorded_cloud(
      thinned(recorded, seeing.points), segmentation, seeing.table);
  target.times.emplace_back("segmentation", since(start));
  for (const std::string& dropped : scene.dropped) {
    target.notes.push_back("not an object: " + dropped);
  }
  if (scene.objects.empty()) {
    throw geometry::InputError(fmt::format("'{}': {}", choices.file, why_no_objects(scene)),
                               "docs/recorded_data.md says what is looked for");
  }
  if (choices.object >= static_cast<int>(scene.objects.size())) {
    throw geometry::InputError(fmt::format("'{}' shows {} objects: there is no object {}",
                                           choices.file, scene.objects.size(), choices.object),
                               "Give --object one from 0");
  }
  target.table_W = scene.table_W;
  start = steady_clock::now();
  progress.stage(fmt::format("completing {} objects", scene.objects.size()));
  const auto shapes = shape::complete_scene(scene, shape_options.completion, {},
                                            static_cast<std::size_t>(choices.object));
  target.times.emplace_back("completion", since(start));
  for (int i = 0; i < static_cast<int>(scene.objects.size()); ++i) {
    const auto& seen = scene.objects[static_cast<std::size_t>(i)];
    const geometry::Plane& support = support_of(scene, seen);
    start = steady_clock::now();
    progress.stage(fmt::format("meshing object {} of {}", i, scene.objects.size()));
    try {
      if (i == choices.object && !choices.known.empty()) {
        const bool known = take_known(choices, scene, seen, &target);
        target.times.emplace_back("recognition", since(start));
        if (known) continue;
        start = steady_clock::now();
      }
      const shape::CompletedShape& shape = shapes[static_cast<std::size_t>(i)].get();
      if (i != choices.object) {
        target.neighbours_W.push_back(
            surface::make_object_model(shape, support, shape_options.model).convex_pieces_W);
        continue;
      }
      target.object = surface::make_object_model(shape, support, shape_options.model);
      if (seen.support_W) {
        target.notes.push_back(fmt::format("it stands on another object, {:.0f} mm over the table",
                                           1e3 * (support.offset - scene.table_W.offset)));
      }
      target.times.emplace_back("mesh and convex pieces", since(start));
      if (!target.object.substitute.empty()) target.notes.push_back(target.object.substitute);
      if (!target.object.alternatives_W.empty()) {
        target.notes.push_back(
            fmt::format("{} other shapes, by other planes of symmetry, are tried",
                        target.object.alternatives_W.size()));
      }
    } catch (const geometry::InputError& error) {
      if (i == choices.object) throw;
      target.notes.push_back(fmt::format("object {} is no obstacle: {}", i, error.what()));
    }
  }
  return target;
}

void refuse_what_does_not_apply(const PlanChoices& choices, bool is_mesh) {
  const auto refuse = [&](bool is_given, const std::string& option, const char* what) {
    if (!is_given) return;
    throw geometry::InputError(option + " is for " + what + ", and '" + choices.file + "' is none",
                               "Leave " + option + " away");
  };
  if (is_mesh) {
    refuse(!choices.viewpoint.empty(), "--viewpoint", "clouds");
    refuse(!choices.up.empty(), "--up", "clouds");
    refuse(!choices.table.empty(), "--table", "clouds");
    refuse(!choices.split.empty(), "--split", "clouds");
    refuse(choices.object != 0, "--object", "clouds");
    refuse(!choices.known.empty(), "--known", "clouds");
    refuse(choices.alternatives.has_value(), "--alternatives", "clouds");
    refuse(choices.tolerance > 0, "--tolerance", "clouds");
  } else {
    refuse(choices.in_place, "--in-place", "meshes");
  }
}

}  // namespace

PlanTarget read_target(const PlanChoices& choices, Progress& progress) {
  if (!fs::exists(choices.file)) {
    throw geometry::InputError("There is no file '" + choices.file + "'", "Name a mesh or cloud");
  }
  const bool mesh = is_mesh(choices.file);
  refuse_what_does_not_apply(choices, mesh);
  PlanTarget target = mesh ? of_mesh(choices, progress) : of_cloud(choices, progress);
  const surface::PredictedSize size = surface::predicted_size(target.object, target.table_W);
  target.notes.push_back(
      "length, width and height of the object: " +
      (size.deviation.isZero() ? surface::size_text(size.size) : surface::size_text(size)));
  return target;
}

}  // namespace prehend::tools
