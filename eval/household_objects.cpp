#include "eval/household_objects.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "eval/implicit_mesh.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_files.h"

namespace prehend::eval {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::TriangleMesh;

constexpr double kCell = 0.002;  // m

// Meshes a solid that fits in a box of the given half widths and height over the table.
TriangleMesh meshed(const Implicit& solid, double half_x, double half_y, double height) {
  const double margin = 2 * kCell;
  return standing(mesh_of(solid,
                          {Vector3d(-half_x - margin, -half_y - margin, -margin),
                           Vector3d(half_x + margin, half_y + margin, height + margin)},
                          kCell));
}

TriangleMesh box(const Vector3d& size) {
  return meshed(
      [size](const Vector3d& p) {
        return solids::rounded_box(p, {0, 0, size.z() / 2}, size, 0.002);
      },
      size.x() / 2, size.y() / 2, size.z());
}

TriangleMesh household_revolution(const std::vector<Vector2d>& outline) {
  double radius = 0, height = 0;
  for (const Vector2d& p : outline) {
    radius = std::max(radius, p.x());
    height = std::max(height, p.y());
  }
  return meshed([&outline](const Vector3d& p) { return solids::revolution(p, outline); }, radius,
                radius, height);
}

const std::vector<Vector2d> kCan = {{0, 0},         {0.031, 0},    {0.033, 0.002}, {0.033, 0.106},
                                    {0.031, 0.109}, {0.03, 0.109}, {0.03, 0.106},  {0, 0.106}};
const std::vector<Vector2d> kBottle = {
    {0, 0},         {0.033, 0},    {0.036, 0.004}, {0.036, 0.14},   {0.033, 0.16},   {0.024, 0.18},
    {0.015, 0.195}, {0.013, 0.21}, {0.013, 0.215}, {0.0155, 0.215}, {0.0155, 0.235}, {0, 0.235}};
const std::vector<Vector2d> kBowl = {{0, 0},         {0.035, 0},     {0.036, 0.004}, {0.055, 0.018},
                                     {0.068, 0.036}, {0.075, 0.06},  {0.071, 0.06},  {0.064, 0.038},
                                     {0.052, 0.022}, {0.034, 0.008}, {0, 0.007}};
const std::vector<Vector2d> kMugBody = {
    {0, 0}, {0.037, 0}, {0.04, 0.003}, {0.04, 0.095}, {0.036, 0.095}, {0.036, 0.006}, {0, 0.006}};
const std::vector<Vector2d> kCone = {{0, 0}, {0.05, 0}, {0.05, 0.006}, {0.008, 0.16}, {0, 0.16}};

double mug(const Vector3d& p) {
  // The handle ends in the wall, not in the hollow.
  const double handle =
      std::max(solids::torus(p, {0.042, 0, 0.05}, Vector3d::UnitY(), 0.026, 0.0055),
               0.038 - std::hypot(p.x(), p.y()));
  return std::min(solids::revolution(p, kMugBody), handle);
}

double spray_bottle(const Vector3d& p) {
  // Elliptic body: a can of revolution, squeezed along y.
  static const std::vector<Vector2d> kBody = {{0, 0},        {0.042, 0},   {0.045, 0.004},
                                              {0.045, 0.1},  {0.04, 0.13}, {0.022, 0.165},
                                              {0.016, 0.18}, {0, 0.18}};
  const double body = 0.65 * solids::revolution({p.x(), p.y() / 0.65, p.z()}, kBody);
  const double neck = solids::cone_segment(p, {0, 0, 0.16}, {0, 0, 0.2}, 0.013, 0.013);
  const double head = solids::rounded_box(p, {0.012, 0, 0.214}, {0.085, 0.026, 0.032}, 0.006);
  const double nozzle = solids::cone_segment(p, {0.05, 0, 0.218}, {0.064, 0, 0.218}, 0.009, 0.007);
  const double trigger =
      solids::cone_segment(p, {0.034, 0, 0.204}, {0.046, 0, 0.165}, 0.006, 0.005);
  return std::min({body, neck, head, nozzle, trigger});
}

double milk_carton(const Vector3d& p) {
  const double body = solids::rounded_box(p, {0, 0, 0.085}, {0.07, 0.07, 0.17}, 0.002);
  // The gable: a roof over y whose faces rise at 45 degrees, and the seam on top.
  const double slope = (std::abs(p.y()) + p.z() - 0.205) * std::numbers::sqrt2 / 2;
  const double gable = std::max({slope, std::abs(p.x()) - 0.034, 0.16 - p.z()});
  const double seam = solids::rounded_box(p, {0, 0, 0.207}, {0.068, 0.006, 0.024}, 0.002);
  return std::min({body, gable, seam});
}

double detergent_bottle(const Vector3d& p) {
  static const std::vector<Vector2d> kBody = {
      {0, 0}, {0.056, 0}, {0.06, 0.005}, {0.06, 0.12}, {0.05, 0.165}, {0.03, 0.195}, {0, 0.2}};
  const double body = 0.6 * solids::revolution({p.x(), p.y() / 0.6, p.z()}, kBody);
  // The grip is a slot through the upper part, the cap stands beside the middle.
  const double slot =
      std::hypot(p.x() + 0.026, std::max(std::abs(p.z() - 0.13) - 0.016, 0.0)) - 0.011;
  const double cap = solids::cone_segment(p, {0.014, 0, 0.185}, {0.014, 0, 0.216}, 0.018, 0.015);
  return std::min(std::max(body, -slot), cap);
}

// A sitting animal that looks over its shoulder, with one raised arm.
double toy(const Vector3d& p) {
  const double body = solids::ellipsoid(p, {0, 0, 0.036}, {0.042, 0.034, 0.036});
  const double head = solids::ellipsoid(p, {0.012, 0.01, 0.088}, {0.025, 0.024, 0.027});
  const double neck =
      solids::cone_segment(p, {0.004, 0.004, 0.05}, {0.01, 0.008, 0.08}, 0.02, 0.018);
  const double snout =
      solids::cone_segment(p, {0.022, 0.026, 0.084}, {0.034, 0.044, 0.08}, 0.011, 0.008);
  const double tail =
      solids::cone_segment(p, {-0.036, 0, 0.03}, {-0.062, 0.012, 0.06}, 0.012, 0.007);
  const double arm =
      solids::cone_segment(p, {0.01, -0.026, 0.055}, {0.036, -0.052, 0.07}, 0.011, 0.009);
  const double foot = solids::ellipsoid(p, {0.042, 0.018, 0.01}, {0.02, 0.013, 0.01});
  return std::min({body, head, neck, snout, tail, arm, foot});
}

EvaluationObject object(std::string name, TriangleMesh mesh, bool lies_too = false,
                        bool symmetric = true) {
  return {
      std::move(name), std::make_shared<TriangleMesh>(std::move(mesh)), symmetric, lies_too, {}};
}

}  // namespace

double household_mass(double volume) { return std::clamp(400 * volume, 0.02, 0.6); }

TriangleMesh standing(TriangleMesh mesh) {
  const Eigen::AlignedBox3d bounds = geometry::bounds(mesh);
  const Vector3d foot(bounds.center().x(), bounds.center().y(), bounds.min().z());
  for (Vector3d& v : mesh.vertices) v -= foot;
  return mesh;
}

TriangleMesh lying(TriangleMesh mesh) {
  for (Vector3d& v : mesh.vertices) v = {v.z(), v.y(), -v.x()};
  return standing(std::move(mesh));
}

std::vector<EvaluationObject> household_objects() {
  std::vector<EvaluationObject> objects;
  objects.push_back(object("cereal_box", box({0.06, 0.15, 0.21}), true));
  objects.push_back(object("tea_box", box({0.08, 0.105, 0.07})));
  objects.push_back(object("can", household_revolution(kCan), true));
  objects.push_back(object("bottle", household_revolution(kBottle), true));
  objects.push_back(object("bowl", household_revolution(kBowl)));
  objects.push_back(object("mug", meshed(mug, 0.075, 0.042, 0.1)));
  objects.push_back(object("spray_bottle", meshed(spray_bottle, 0.075, 0.035, 0.24), true));
  objects.push_back(object("cone", household_revolution(kCone)));
  objects.push_back(object(
      "ball", meshed([](const Vector3d& p) { return (p - Vector3d(0, 0, 0.04)).norm() - 0.04; },
                     0.042, 0.042, 0.082)));
  objects.push_back(object("milk_carton", meshed(milk_carton, 0.04, 0.04, 0.222)));
  objects.push_back(object("detergent_bottle", meshed(detergent_bottle, 0.065, 0.04, 0.235)));
  objects.push_back(object("toy", meshed(toy, 0.075, 0.065, 0.12), false, false));
  return objects;
}

std::vector<EvaluationObject> scanned_objects(const std::filesystem::path& shared_data) {
  struct Scan {
    const char* name;
    const char* file;
    double scale;
    bool y_up;
    bool lies_too;
    bool symmetric;
  };
  static constexpr Scan kScans[] = {
      {"cracker_box", "ycb/003_cracker_box.ply", 1, false, true, true},
      {"sugar_box", "ycb/004_sugar_box.ply", 1, false, false, true},
      {"soup_can", "ycb/005_tomato_soup_can.ply", 1, false, true, true},
      {"mustard_bottle", "ycb/006_mustard_bottle.ply", 1, false, true, true},
      {"meat_can", "ycb/010_potted_meat_can.ply", 1, false, false, true},
      {"windex_bottle", "ycb/022_windex_bottle.ply", 1, false, true, true},
      {"mug", "ycb/025_mug.ply", 1, false, false, true},
      {"cup", "ycb/065-d_cups.ply", 1, false, false, true},
      {"power_drill", "ycb/035_power_drill.ply", 1, false, false, false},
      {"baseball", "ycb/055_baseball.ply", 1, false, false, true},
      {"duck", "other/duck.obj", 0.05, true, false, true},
      {"clown", "other/dexnet_clown.obj", 2, false, false, false}};
  std::vector<EvaluationObject> objects;
  for (const Scan& scan : kScans) {
    const std::filesystem::path file = shared_data / "meshes" / scan.file;
    if (!std::filesystem::exists(file)) continue;
    TriangleMesh mesh = geometry::read_mesh_file(file, scan.scale);
    if (scan.y_up) {
      for (Vector3d& v : mesh.vertices) v = {v.x(), -v.z(), v.y()};
    }
    objects.push_back(object(scan.name, standing(std::move(mesh)), scan.lies_too, scan.symmetric));
  }
  if (objects.empty()) {
    throw geometry::InputError(
        "There are no scanned meshes in '" + (shared_data / "meshes").string() + "'",
        "Check the environment variable PREHEND_SHARED_DATA");
  }
  return objects;
}

std::vector<EvaluationObject> objects_of_folder(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw geometry::InputError("The folder of meshes '" + folder.string() + "' does not exist",
                               "Name a folder with OBJ, PLY or STL files in metres");
  }
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (ending == ".obj" || ending == ".ply" || ending == ".stl") files.push_back(entry.path());
  }
  if (files.empty()) {
    throw geometry::InputError("The folder '" + folder.string() + "' has no mesh",
                               "Name a folder with OBJ, PLY or STL files in metres");
  }
  std::sort(files.begin(), files.end());
  std::vector<EvaluationObject> objects;
  int tall = 0;
  for (const std::filesystem::path& file : files) {
    TriangleMesh mesh = geometry::read_mesh_file(file);
    const double longest = geometry::bounds(mesh).sizes().maxCoeff();
    if (!(longest >= 0.01 && longest <= 1)) {
      throw geometry::InputError(
          "The mesh '" + file.string() + "' is " + std::to_string(longest) + " m long",
          "State its vertices in metres; 1 cm to 1 m can be evaluated");
    }
    const TriangleMesh merged = geometry::with_merged_vertices(mesh, 1e-6 * longest);
    const geometry::MeshDefects defects = geometry::find_defects(merged);
    if (defects.boundary_edges > 0) {
      throw geometry::InputError(
          "The mesh '" + file.string() + "' is not closed (" + defects.to_string() + ")",
          "Close its holes; the truth must bound a solid");
    }
    // Tall ones are also evaluated lying, as many as in the other sets.
    const Eigen::Vector3d size = geometry::bounds(merged).sizes();
    const bool lies_too = tall < 4 && size.z() >= 1.5 * std::min(size.x(), size.y());
    tall += lies_too;
    objects.push_back(object(file.stem().string(), standing(merged), lies_too, false));
  }
  return objects;
}

}  // namespace prehend::eval
