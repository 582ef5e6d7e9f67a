#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "prehend/contact/shape.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/simulation/engines/multibody.h"
#include "prehend/simulation/object_surface.h"
#include "prehend/simulation/rigid_body.h"
#include "prehend/simulation/robot_bodies.h"

namespace prehend::simulation {

/// Where robot, objects and table (z = 0) touch. Robot parts are boxes, cylinders, spheres and
/// meshes; objects are met as what they are (box, ball, can) or as their meshes: points on the
/// parts, a few millimetres apart, against the object's surface, and points of the object's surface
/// against the parts. Fingers meet one another as primitives, or where one of them is a mesh by
/// points of each in the other. So meshes need not be convex. What lies before a tactile
/// pad's foam is left to its texels (engines::EnginePad).
class RobotTouch : public engines::TouchFinder {
 public:
  struct Object {
    int body = 0;  // of the Multibody
    BodyModel model;
    geometry::RigidTransform X_CB = geometry::RigidTransform::Identity();  // mesh in the body
  };

  static constexpr double kPointSpacing = 0.004;  // m, on fingers
  static constexpr double kArmSpacing = 0.015;    // m, between points on the arm

  /// @param pads of the hand, whose order RobotBodies::Pad means.
  RobotTouch(const RobotBodies& robot, const std::vector<robot::HandPad>& pads,
             std::vector<Object> objects);

  void find(const engines::Multibody& system, const engines::MultibodyState& base, double h,
            const Eigen::VectorXd& u, std::vector<engines::TouchPoint>& touches) override;

  const std::vector<Object>& objects() const { return objects_; }

 private:
  /// Of a flat pad: what is in it, texels feel.
  struct Foam {
    geometry::RigidTransform X_PS;
    Eigen::Vector2d half = Eigen::Vector2d::Zero();  // m
    double thickness = 0;                            // m
    bool holds(const Eigen::Vector3d& p_S) const;
  };
  /// Of any other pad, behind which its link is not cut away: what of the link is less than
  /// `thickness` below the pad's face is foam.
  struct FoamOnSurface {
    geometry::RigidTransform X_PS;
    std::shared_ptr<const geometry::MeshQuery> face_P;
    double thickness = 0;  // m
    struct Place {
      double below = 0;       // m, the face; negative: over it
      Eigen::Vector3d out_S;  // unit, the face's normal there
    };
    /// Where p_S is, if it is over or below the face and no more than `reach` [m] from it.
    std::optional<Place> find(const Eigen::Vector3d& p_S, double reach) const;
  };
  struct Part {
    int body, finger, rank;
    bool carried;
    engines::EngineShape shape;
    geometry::RigidTransform X_BS;
    contact::Shape felt;
    double radius;                          // m, of a ball round S's origin that holds it
    std::vector<Eigen::Vector3d> points_S;  // m, on its surface
    std::vector<Eigen::Vector3d> hard_S;    // m, the same, those in a FoamOnSurface moved behind it
    std::vector<Eigen::Vector3d> normals_S;  // there, outward; on edges the mean of the faces'
    std::vector<Foam> foams;
    std::vector<FoamOnSurface> surface_foams;
    Eigen::AlignedBox3d box_S;                        // m
    std::shared_ptr<const geometry::MeshQuery> mesh;  // of a mesh; `shape` and `felt` mean nothing

    /// Whether a point is inside, less than ObjectSurface::kDeepest deep, and the nearest face's
    /// normal.
    bool holds(const Eigen::Vector3d& p_S, Eigen::Vector3d& normal_S, double& depth) const;
    /// How deep a point that is `depth` [m] inside is in what is no foam [m]; at most 0: in foam.
    double hard_depth(const Eigen::Vector3d& p_S, double depth) const;
  };
  void find_part_object(const Part& part, std::size_t object, double margin,
                        std::vector<engines::TouchPoint>& touches);
  void find_table(int body, const std::vector<Eigen::Vector3d>& points,
                  const geometry::RigidTransform& X_WP, double reach,
                  std::vector<engines::TouchPoint>& touches);
  /// Points of two parts in one another, into found_.
  void find_part_part(const Part& a, const Part& b);
  void find_objects(std::size_t a, std::size_t b, std::vector<engines::TouchPoint>& touches);
  void add(int a, int b, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W, double depth,
           std::vector<engines::TouchPoint>& touches) const;

  std::vector<Part> parts_;
  std::vector<Object> objects_;
  std::vector<ObjectSurface> surfaces_;  // of objects_
  // Of the call under way.
  const engines::MultibodyState* base_ = nullptr;
  std::vector<double> speed_;  // m/s, of each body's surface at most
  std::vector<engines::ConvexContact> found_;
};

}  // namespace prehend::simulation
