#pragma once

#include <vector>

#include <Eigen/Core>

namespace prehend::grasp {

/// A contact of the hand with the object.
struct Contact {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, into the object
  double friction = 0;        // coefficient, >= 0; 0 is a frictionless contact
  double torsion_radius = 0;  // m, >= 0; torque about the normal <= friction * torsion_radius * fn;
                              // 0 is a point contact
};

struct ForceClosureOptions {
  int cone_edges = 8;            // >= 3, of the linearised friction cone
  double rank_tolerance = 1e-7;  // relative to the largest singular value
  double margin = 1e-6;  // >= 0; the smallest weight of a wrench, times their number, above which
                         // the origin counts as strictly inside

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Primitive wrenches of the contacts for unit normal force as columns (6 x n): force over torque
/// about `center`, torque divided by `length` [m] so that both have one unit. The cone's edges are
/// n + friction * t_j (inside the true cone: conservative); torsion adds n +- friction *
/// torsion_radius as a torque about n. Together they span an inner approximation of the soft
/// finger's elliptic limit surface (Howe and Cutkosky, "Practical force-motion models for sliding
/// manipulation", IJRR 1996). A frictionless contact gives n alone.
Eigen::Matrix<double, 6, Eigen::Dynamic> primitive_wrenches(const std::vector<Contact>& contacts,
                                                            const Eigen::Vector3d& center,
                                                            double length, int cone_edges);

struct ForceClosure {
  bool closed = false;
  int rank = 0;        // of the primitive wrenches
  double margin = 0;   // n * max min lambda_i over W lambda = 0, sum lambda = 1; <= 0: not closed
  double quality = 0;  // see evaluate_force_closure; 0 when not closed
};

/// Decides whether the contacts hold the object against any wrench: the origin lies strictly inside
/// the convex hull of the primitive wrenches W. That is so exactly when W has rank 6 and a strictly
/// positive combination of its columns is zero; the latter is the linear programme
///   max t   subject to   W lambda = 0,  sum lambda = 1,  lambda_i >= t
/// solved by GLPK's simplex method, in rational arithmetic where rounding makes that one cycle. Two
/// point contacts are never closed (rank 5: no torque about their line).
///
/// `quality` is the largest r for which all twelve wrenches +-r e_k are in the hull, e_k the axes
/// of the wrench space: twelve exact linear programmes. The radius epsilon of the largest ball
/// (Ferrari and Canny, "Planning optimal grasps", ICRA 1992) obeys
///   quality / sqrt(6) <= epsilon <= quality,
/// without the cost of a hull in six dimensions. It does not change when the object, the torsion
/// radii and `length` are scaled together.
/// @throws std::invalid_argument for `length` <= 0, no finite contact or a normal that is not unit.
ForceClosure evaluate_force_closure(const std::vector<Contact>& contacts,
                                    const Eigen::Vector3d& center, double length,
                                    const ForceClosureOptions& options = {});

}  // namespace prehend::grasp
