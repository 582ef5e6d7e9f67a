#include "prehend/simulation/clutter_scene.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/simulation/random_draw.h"
#include "prehend/simulation/stereo_renderer.h"
#include "prehend/simulation/surface_gap.h"

namespace prehend::simulation {
namespace {

using Eigen::Vector3d;
using geometry::InputError;
using geometry::TriangleMesh;
namespace fs = std::filesystem;

constexpr double kLargest = 1;        // m
constexpr double kSameVertex = 1e-6;  // of the longest side
constexpr double kTouching = 0.0015;  // m
constexpr double kFacesUp = 0.3;      // z of a unit normal
constexpr double kDegree = std::numbers::pi / 180;

bool is_mesh(const fs::path& file) {
  static const std::set<std::string> kEndings{".ply", ".obj", ".stl", ".off", ".dae"};
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return kEndings.count(ending) > 0;
}

// A name of any characters, for YAML; of several a list.
std::string quoted(const std::string& name) {
  std::ostringstream text;
  text << std::quoted(name);
  return text.str();
}
std::string quoted(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + quoted(name);
  return "[" + list + "]";
}

ClutterSolid read_solid(const fs::path& file, double scale) {
  TriangleMesh mesh = geometry::read_mesh_file(file, scale);
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  if (!(box.sizes().maxCoeff() <= kLargest)) {
    throw InputError(fmt::format("'{}' is {:.3g} m large", file.string(), box.sizes().maxCoeff()),
                     "Give --scale, the metres of a unit of the files (0.001: millimetres)");
  }
  const geometry::MeshDefects defects = geometry::find_defects(
      geometry::with_merged_vertices(mesh, kSameVertex * box.sizes().maxCoeff()));
  if (defects.boundary_edges > 0) {
    throw InputError("'" + file.string() + "' is not closed (" + defects.to_string() + ")",
                     "Close its holes: its mass is that of what it encloses");
  }
  const Vector3d foot(box.center().x(), box.center().y(), box.min().z());
  for (Vector3d& p : mesh.vertices) p -= foot;
  const double volume = geometry::mass_properties(mesh).volume;
  if (!(volume > 0)) {
    throw InputError("'" + file.string() + "' encloses no volume",
                     "Close the mesh and turn its triangles outward");
  }
  ClutterSolid solid;
  solid.name = file.stem().string();
  solid.mass = mass_of_volume(volume);
  solid.mesh_B = std::make_shared<const TriangleMesh>(std::move(mesh));
  return solid;
}

Texture draw_texture(RandomDraw& draw) {
  static constexpr Texture::Pattern kPatterns[] = {
      Texture::Pattern::kNoise, Texture::Pattern::kStripes, Texture::Pattern::kLabel};
  Texture texture;
  texture.pattern = kPatterns[draw.one_of(3)];
  for (int k = 0; k < 3; ++k) texture.color[k] = draw.between(0.15, 0.85);
  for (int k = 0; k < 3; ++k) texture.second_color[k] = draw.between(0.5, 0.95);
  texture.contrast = draw.between(0.25, 0.5);
  texture.seed = static_cast<std::uint32_t>(draw.one_of(1u << 30));
  return texture;
}

void vary_look(double varied, RandomDraw& draw, Scene& scene) {
  const auto about = [&](double half) { return varied * draw.between(-half, half); };
  const Vector3d view = scene.camera.eye - scene.camera.target;
  const double azimuth = std::atan2(view.y(), view.x()) + about(25 * kDegree);
  const double elevation = std::asin(view.z() / view.norm()) + about(12 * kDegree);
  const double distance = view.norm() * (1 + about(0.15));
  scene.camera.eye =
      scene.camera.target + distance * Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                std::cos(elevation) * std::sin(azimuth),
                                                std::sin(elevation));
  scene.camera.noise += varied * draw.between(-1, 3);
  const double turn = 2 * std::numbers::pi * draw.unit(), height = draw.between(0.5, 1.5);
  scene.light.direction = (1 - varied) * scene.light.direction +
                          varied * Vector3d(std::cos(turn), std::sin(turn), height);
  scene.light.ambient += about(0.2);
}

// Whether all of it is in both images, with a frame round it.
bool is_in_view(const TriangleMesh& mesh_B, const geometry::RigidTransform& X_WB,
                const CameraSetup& setup) {
  constexpr double kFrame = 0.02;  // of the image's sides
  const geometry::PinholeCamera& left = setup.camera.left;
  const geometry::RigidTransform X_CB = setup.X_WC().inverse() * X_WB;
  const double frame_u = kFrame * left.width, frame_v = kFrame * left.height;
  for (const Vector3d& p_B : mesh_B.vertices) {
    const Vector3d p = X_CB * p_B;
    if (!(p.z() > 0)) return false;
    const double u = left.cx + left.fx * p.x() / p.z(), v = left.cy + left.fy * p.y() / p.z();
    const double disparity = left.fx * setup.camera.baseline / p.z();
    if (u - disparity < frame_u || u > left.width - frame_u || v < frame_v ||
        v > left.height - frame_v) {
      return false;
    }
  }
  return true;
}

// As whoever sets up a camera does.
void step_back_until_all_is_seen(const std::vector<ClutterSolid>& solids,
                                 const std::vector<ClutterBody>& bodies, CameraSetup& setup) {
  constexpr double kStep = 1.03, kFarthest = 1.5;  // of the distance; beyond there is no telling
  const Vector3d view = setup.eye - setup.target;
  for (double scale = 1; scale < kFarthest; scale *= kStep) {
    setup.eye = setup.target + scale * view;
    const bool all = std::ranges::all_of(bodies, [&](const ClutterBody& body) {
      return is_in_view(*solids.at(body.solid).mesh_B, body.X_WB, setup);
    });
    if (all) return;
  }
}

// Pixels of the left image by body, counted in one of half its width and height.
std::vector<int> label_counts(Scene scene, const std::vector<VisibleBody>& bodies) {
  geometry::PinholeCamera& left = scene.camera.camera.left;
  left.width /= 2;
  left.height /= 2;
  for (double* of_pixels : {&left.fx, &left.fy}) *of_pixels /= 2;
  for (double* middle : {&left.cx, &left.cy}) *middle = (*middle - 0.5) / 2;
  RenderOptions options;
  options.shadows = false;  // labels have none
  std::vector<int> counts(bodies.size(), 0);
  for (const std::int16_t label : render_stereo(scene, bodies, 0, options).labels.data) {
    if (label >= 0) counts[static_cast<std::size_t>(label)] += 4;
  }
  return counts;
}

std::vector<std::string> names_of(const std::vector<std::size_t>& indices,
                                  const std::vector<ClutterBody>& bodies) {
  std::vector<std::string> names;
  for (const std::size_t i : indices) names.push_back(bodies[i].name);
  return names;
}

}  // namespace

double mass_of_volume(double volume) { return std::clamp(400 * volume, 0.03, 0.8); }

std::vector<ClutterSolid> read_clutter_solids(const fs::path& folder, double scale) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (is_mesh(entry.path())) files.push_back(entry.path());
  }
  if (error) {
    throw InputError("'" + folder.string() + "' is no folder: " + error.message(),
                     "Name a folder of meshes");
  }
  if (files.empty()) {
    throw InputError("'" + folder.string() + "' has no mesh",
                     "Put .ply, .obj, .stl, .off or .dae files of closed meshes there");
  }
  std::sort(files.begin(), files.end());
  std::vector<ClutterSolid> solids;
  for (const fs::path& file : files) {
    solids.push_back(read_solid(file, scale));
    for (const ClutterSolid& other : solids) {
      if (&other != &solids.back() && other.name == solids.back().name) {
        throw InputError("'" + file.string() + "' has the name of another mesh beside it",
                         "Rename one of them");
      }
    }
  }
  return solids;
}

Scene clutter_scene(const std::vector<ClutterSolid>& solids, const std::vector<ClutterBody>& bodies,
                    const fs::path& meshes, double varied, std::uint64_t seed) {
  Scene scene;
  RandomDraw draw(seed);
  scene.camera.seed = static_cast<std::uint32_t>(draw.one_of(1u << 30));
  vary_look(varied, draw, scene);
  step_back_until_all_is_seen(solids, bodies, scene.camera);
  for (const ClutterBody& body : bodies) {
    const ClutterSolid& solid = solids.at(body.solid);
    SceneObject object;
    object.name = body.name;
    object.shape = "mesh";
    object.file = meshes / (solid.name + ".ply");
    object.mass = solid.mass;
    object.friction = solid.friction;
    object.X_WB = body.X_WB;
    object.texture = draw_texture(draw);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

std::vector<ClutterTruth> clutter_truth(const std::vector<ClutterSolid>& solids,
                                        const std::vector<ClutterBody>& bodies,
                                        const Scene& scene) {
  std::vector<SampledSurface> surfaces;
  std::vector<VisibleBody> visible;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& mesh = solids.at(bodies[i].solid).mesh_B;
    surfaces.emplace_back(*mesh);
    visible.push_back({bodies[i].name, mesh, bodies[i].X_WB, scene.objects.at(i).texture,
                       geometry::bounds(*mesh).max().z()});
  }
  const std::vector<int> together = label_counts(scene, visible);
  std::vector<ClutterTruth> truths(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    ClutterTruth& truth = truths[i];
    truth.pixels = together[i];
    truth.alone_pixels = label_counts(scene, {visible[i]})[0];
    truth.lowest = surfaces[i].lowest(bodies[i].X_WB);
    truth.tilt = std::acos(std::clamp(bodies[i].X_WB.linear()(2, 2), -1.0, 1.0));
    for (std::size_t j = 0; j < bodies.size(); ++j) {
      if (i == j) continue;
      const SurfaceGap gap =
          surface_gap(surfaces[i], bodies[i].X_WB, surfaces[j], bodies[j].X_WB, kTouching);
      if (gap.distance >= kTouching) continue;
      truth.touches.push_back(j);
      if (gap.normal_W.z() > kFacesUp) truth.borne_by.push_back(j);
    }
  }
  return truths;
}

void write_clutter(const fs::path& file, const std::vector<ClutterSolid>& solids,
                   const std::vector<ClutterBody>& bodies, const std::vector<ClutterTruth>& truths,
                   const Scene& scene) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    geometry::write_mesh_file(scene.objects.at(i).file, *solids.at(bodies[i].solid).mesh_B);
  }
  write_scene(file, scene, "Things that were dropped until they rest; the truth is beside it.");
  std::string text =
      "# Of each object of " + file.filename().string() +
      ": how it was put down and how it lies. Pixels: of the left image.\nobjects:\n";
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const ClutterTruth& truth = truths.at(i);
    text += fmt::format(
        "  - {{name: {}, solid: {}, put: {}, touches: {}, borne_by: {}, lowest: "
        "{:.4f}, tilt: {:.4f}, pixels: {}, alone_pixels: {}, visible: {:.3f}}}\n",
        quoted(bodies[i].name), quoted(solids[bodies[i].solid].name), to_string(bodies[i].placing),
        quoted(names_of(truth.touches, bodies)), quoted(names_of(truth.borne_by, bodies)),
        truth.lowest, truth.tilt, truth.pixels, truth.alone_pixels, truth.visible());
  }
  const fs::path beside = file.parent_path() / (file.stem().string() + "_truth.yaml");
  std::ofstream out(beside);
  out << text;
  out.flush();
  if (!out) throw InputError("'" + beside.string() + "' cannot be written", "Check its folder");
}

}  // namespace prehend::simulation
