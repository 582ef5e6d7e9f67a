#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/contact/shape.h"
#include "prehend/contact/texel_law.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/simulation/texture.h"

namespace prehend::simulation {

/// What texels and other objects' points meet of an object: a shape in its own frame S.
struct FeltShape {
  contact::Shape shape = contact::Shape::box(Eigen::Vector3d::Ones());
  geometry::RigidTransform X_BS = geometry::RigidTransform::Identity();
};

/// What does not change of an object. Frame B is the mesh's.
struct BodyModel {
  std::uint32_t id = 0;  // never used twice in a world
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> mesh;
  std::shared_ptr<const geometry::MeshQuery> query;
  Eigen::AlignedBox3d box;  // of the mesh in B [m]
  double radius = 0;        // m, of a ball round the centre of mass that holds the mesh
  FeltShape felt;
  double mass = 0;                                           // kg
  Eigen::Vector3d center_of_mass = Eigen::Vector3d::Zero();  // in B [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();     // about it, in B [kg m^2]
  bool is_static = false;
  std::vector<Eigen::Vector3d> hull_points;     // in B: what can touch a plane
  std::vector<Eigen::Vector3d> surface_points;  // in B, a few millimetres apart: what touches boxes
                                                // and other bodies
  contact::TexelLaw pad_law;                    // against a texel
  contact::TexelLaw table_law;                  // a hull point against the table
  contact::TexelLaw rigid_pad_law;              // a surface point against a pad without texels
  contact::TexelLaw rigid_law;  // a surface point against fingers, housing and other bodies
  Texture texture;
};

/// What changes of an object.
struct BodyState {
  Eigen::Quaterniond q_WB = Eigen::Quaterniond::Identity();
  Eigen::Vector3d p_WBcm = Eigen::Vector3d::Zero();            // m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          // m/s, of the centre of mass
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  // rad/s, world
  double still_time = 0;                                       // s without perceptible motion
  bool asleep = false;
  bool touches_left_pad = false;
  bool touches_right_pad = false;
  bool touches_table = false;
  bool touches_gripper = false;

  template <class Archive>
  void archive(Archive& archive) {
    archive(q_WB, p_WBcm, velocity, angular_velocity, still_time, asleep, touches_left_pad,
            touches_right_pad, touches_table, touches_gripper);
  }
};

/// Makes the model of a solid of mass `mass` [kg] bounded by `mesh_B`; `pad_law` is that of the
/// gripper's pads, `friction` that of the object on them, `table_friction` on the table. `felt`:
/// what texels feel; null: the mesh.
/// @throws std::invalid_argument when mass or friction is not finite and positive (friction: not
/// negative), geometry::InputError for a mesh that is empty, not finite or encloses no volume.
BodyModel make_body(const std::string& name, geometry::TriangleMesh mesh_B, double mass,
                    double friction, double table_friction, const contact::TexelLaw& pad_law,
                    const FeltShape* felt = nullptr);

/// Points of the surface of `mesh`, about `spacing` [m] apart, vertices first (thinned to the
/// spacing). Deterministic.
std::vector<Eigen::Vector3d> sample_surface(const geometry::TriangleMesh& mesh, double spacing);

/// Frame C of a body: at its centre of mass, along its principal axes.
struct PrincipalAxes {
  geometry::RigidTransform X_BC = geometry::RigidTransform::Identity();
  Eigen::Vector3d moments = Eigen::Vector3d::Ones();  // kg m^2, about C's axes
};
PrincipalAxes principal_axes(const BodyModel& model);

/// Pose of frame B.
geometry::RigidTransform body_pose(const BodyModel& model, const BodyState& state);

/// Puts frame B at X_WB.
void set_body_pose(const BodyModel& model, const geometry::RigidTransform& X_WB, BodyState& state);

/// Height of the lowest hull point over z = 0 [m].
double lowest_point(const BodyModel& model, const BodyState& state);

/// Moves by the velocities over `h` [s]; the orientation by the exponential map.
void integrate(double h, BodyState& state);

/// Whether the body at rest on z = 0 stays as it is under gravity: it stands on the table and its
/// centre of mass is over the points that carry it, by `margin` [m] at least.
bool stands_stably(const BodyModel& model, const BodyState& state, double margin);

/// How many points touch a plane under the body.
std::size_t carrying_points(const BodyModel& model, const BodyState& state);

}  // namespace prehend::simulation
