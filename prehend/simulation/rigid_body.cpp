#include "prehend/simulation/rigid_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <stdexcept>

#include <Eigen/Eigenvalues>

#include "prehend/contact/rotation.h"
#include "prehend/geometry/errors.h"

namespace prehend::simulation {
namespace {

constexpr double kSampleSpacing = 0.006;  // m, below the fingertip's smaller side (9 mm)

// A stiff point contact: 0.1 mm for 10 N. Static and dynamic friction are equal, hence passive.
contact::TexelLaw stiff_law(double friction) {
  contact::TexelLaw law;
  law.stiffness = 1e5;
  law.damping = 200;
  law.bristle_stiffness = 1e5;
  // Small against h sigma0: a point that begins to touch while sliding feels sigma1 dz/dt at once.
  law.bristle_damping = 0;
  law.viscous_friction = 0;
  law.static_friction = friction;
  law.dynamic_friction = friction;
  return law;
}

// Keeps the first of the points that fall into one cell of a grid.
class GridThinning {
 public:
  explicit GridThinning(double spacing) : spacing_(spacing) {}
  bool is_first(const Eigen::Vector3d& p) {
    const std::array<std::int64_t, 3> cell{cell_of(p.x()), cell_of(p.y()), cell_of(p.z())};
    return cells_.insert(cell).second;
  }

 private:
  std::int64_t cell_of(double x) const {
    return static_cast<std::int64_t>(std::floor(x / spacing_));
  }
  double spacing_;
  std::set<std::array<std::int64_t, 3>> cells_;
};

}  // namespace

std::vector<Eigen::Vector3d> sample_surface(const geometry::TriangleMesh& mesh, double spacing) {
  std::vector<Eigen::Vector3d> samples;
  GridThinning thinning(spacing);
  for (const auto& v : mesh.vertices) {
    if (thinning.is_first(v)) samples.push_back(v);
  }
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
                          &c = mesh.vertices[t[2]];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int parts = static_cast<int>(std::ceil(longest / (0.7 * spacing)));
    for (int i = 0; i <= parts; ++i) {
      for (int j = 0; i + j <= parts; ++j) {
        const double u = static_cast<double>(i) / parts, v = static_cast<double>(j) / parts;
        const Eigen::Vector3d p = a + u * (b - a) + v * (c - a);
        if (thinning.is_first(p)) samples.push_back(p);
      }
    }
  }
  return samples;
}

BodyModel make_body(const std::string& name, geometry::TriangleMesh mesh_B, double mass,
                    double friction, double table_friction, const contact::TexelLaw& pad_law,
                    const FeltShape* felt) {
  if (!(std::isfinite(mass) && mass > 0)) {
    throw std::invalid_argument("mass of object '" + name + "' must be finite and positive");
  }
  if (!(std::isfinite(friction) && friction >= 0)) {
    throw std::invalid_argument("friction of object '" + name +
                                "' must be finite and not negative");
  }
  BodyModel model;
  model.name = name;
  model.query = std::make_shared<geometry::MeshQuery>(std::move(mesh_B));
  model.mesh = std::shared_ptr<const geometry::TriangleMesh>(model.query, &model.query->mesh());
  model.box = geometry::bounds(*model.mesh);
  const double extent = model.box.sizes().maxCoeff();
  if (!(extent > 1e-4 && extent < 10)) {
    throw geometry::InputError("object '" + name + "' is " + std::to_string(extent) + " m long",
                               "Give its mesh in metres");
  }
  const geometry::MassProperties solid = geometry::mass_properties(*model.mesh);
  if (!(solid.volume > 1e-9 * extent * extent * extent)) {
    throw geometry::InputError("the mesh of object '" + name + "' encloses no volume",
                               "Close it and turn its triangles outward");
  }
  model.mass = mass;
  model.center_of_mass = solid.center_of_mass;
  for (int corner = 0; corner < 8; ++corner) {
    const auto p = model.box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    model.radius = std::max(model.radius, (p - model.center_of_mass).norm());
  }
  model.felt = felt ? *felt : FeltShape{contact::Shape::mesh(*model.mesh), {}};
  if (!felt) model.felt.X_BS.setIdentity();
  model.inertia = mass / solid.volume * solid.unit_density_inertia;
  model.hull_points = geometry::convex_hull(model.mesh->vertices).vertices;
  model.surface_points = sample_surface(*model.mesh, std::max(kSampleSpacing, 0.02 * extent));
  model.pad_law = pad_law;
  const double ratio =
      pad_law.dynamic_friction > 0 ? pad_law.static_friction / pad_law.dynamic_friction : 1.0;
  model.pad_law.dynamic_friction = friction;
  model.pad_law.static_friction = friction * ratio;
  model.table_law = stiff_law(table_friction);
  model.rigid_pad_law = stiff_law(friction);
  model.rigid_law = stiff_law(std::min(friction, 0.3));  // bare metal of fingers and housing
  return model;
}

PrincipalAxes principal_axes(const BodyModel& model) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(model.inertia);
  PrincipalAxes principal;
  principal.X_BC.linear() = axes.eigenvectors();
  if (principal.X_BC.linear().determinant() < 0) principal.X_BC.linear().col(0) *= -1;
  principal.X_BC.translation() = model.center_of_mass;
  principal.moments = axes.eigenvalues();
  return principal;
}

geometry::RigidTransform body_pose(const BodyModel& model, const BodyState& state) {
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();
  X_WB.linear() = state.q_WB.toRotationMatrix();
  X_WB.translation() = state.p_WBcm - X_WB.linear() * model.center_of_mass;
  return X_WB;
}

void set_body_pose(const BodyModel& model, const geometry::RigidTransform& X_WB, BodyState& state) {
  state.q_WB = Eigen::Quaterniond(X_WB.linear()).normalized();
  state.p_WBcm = X_WB * model.center_of_mass;
}

double lowest_point(const BodyModel& model, const BodyState& state) {
  const Eigen::Vector3d up_B = state.q_WB.conjugate() * Eigen::Vector3d::UnitZ();
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& p : model.hull_points) {
    lowest = std::min(lowest, up_B.dot(p - model.center_of_mass));
  }
  return state.p_WBcm.z() + lowest;
}

void integrate(double h, BodyState& state) {
  state.p_WBcm += h * state.velocity;
  state.q_WB = (contact::rotation_by(h * state.angular_velocity) * state.q_WB).normalized();
}

namespace {

// Where the points are, from the centre of mass, that touch a plane under the body.
std::vector<Eigen::Vector2d> feet_of(const BodyModel& model, const BodyState& state) {
  constexpr double kFlat = 1e-6;  // m, of points that carry together
  const double lowest = lowest_point(model, state);
  const Eigen::Matrix3d R_WB = state.q_WB.toRotationMatrix();
  std::vector<Eigen::Vector2d> feet;
  for (const Eigen::Vector3d& p : model.hull_points) {
    const Eigen::Vector3d arm = R_WB * (p - model.center_of_mass);
    if (state.p_WBcm.z() + arm.z() < lowest + kFlat) feet.push_back(arm.head<2>());
  }
  return feet;
}

}  // namespace

std::size_t carrying_points(const BodyModel& model, const BodyState& state) {
  return feet_of(model, state).size();
}

bool stands_stably(const BodyModel& model, const BodyState& state, double margin) {
  constexpr double kOnTable = 1e-4;  // m
  if (std::abs(lowest_point(model, state)) > kOnTable) return false;
  // Over the feet when in no direction all of them are nearer than the margin.
  const std::vector<Eigen::Vector2d> feet = feet_of(model, state);
  constexpr int kDirections = 64;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    double farthest = -std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& foot : feet) {
      farthest = std::max(farthest, foot.x() * std::cos(angle) + foot.y() * std::sin(angle));
    }
    if (!(farthest > margin)) return false;
  }
  return true;
}

}  // namespace prehend::simulation
