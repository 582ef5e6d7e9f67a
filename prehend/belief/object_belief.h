#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/belief/displacement.h"
#include "prehend/belief/evidence.h"
#include "prehend/belief/shape_evidence.h"
#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/swept_space.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/reconstruct.h"

namespace prehend::belief {

struct BeliefOptions {
  ShapePrior prior;
  surface::SurfaceOptions surface;
  /// Nodes along the grid of coarse_mesh(); no more than those of `surface`.
  int coarse_resolution = 64;
  double swept_tolerance = 0.0015;  // m, >= 0: what is no deeper in swept space may be there
  double swept_spacing = 0;         // m, of its voxels, >= 0; 0: 1/64 of the object's extent

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What is believed of one shape after an update.
struct BelievedShape {
  std::string name;           // as ShapeHypothesis
  int index = 0;              // of the shape and its alternatives, the same in all updates
  double weight = 0;          // of all shapes 1
  double misfit = 0;          // as Displacement
  double log_likelihood = 0;  // of the evidence under this shape
  PriorTerms prior_terms = {};
};

/// Where an object was touched and where it is not, and what that makes of its predicted shape.
///
/// The object is one of several shapes (ShapeHypothesis: the completion and its alternatives) with
/// a weight each. Evidence is kept, and every update conditions the first prediction on all of it:
/// - a contact is matched with the nearest point of the shape that faces the same way, and measures
///   how far that is displaced along its normal;
/// - a point of the shape in swept space is displaced at least to that space's border (an
///   inequality, taken as an equality where it is violated: the active-set method);
/// - both weigh the shapes by their likelihood and displace each as Displacement says, the whole
///   side first, what remains locally;
/// - a contact that no part of a shape explains is a disc of surface of its own.
/// The surface goes through the displaced points, and nothing of it is left in swept space or where
/// the camera looked through.
///
/// Same evidence in any order: the same belief, to the last bit. Not thread-safe.
class ObjectBelief {
 public:
  /// @param shape with alternatives; @param table_W what it stands on, normal towards the object.
  /// @throws geometry::InputError when neither it nor an alternative gives a surface.
  ObjectBelief(const shape::CompletedShape& shape, const geometry::Plane& table_W,
               const BeliefOptions& options = {});
  /// An act begins that may move the object so far. Contacts are of the last act that began.
  void begin_act(const Motion& motion = {});
  /// @throws std::invalid_argument for a contact that is not finite, or whose deviation or normal
  /// is none.
  void add(const Contact& contact);
  /// Another look, at the object as it lies in the one that it was completed from, saw this to be
  /// empty.
  void add_seen_space(shape::SeenSpace space) { seen_spaces_.push_back(std::move(space)); }
  /// What another look saw of its surface, as the object lies in the one that it was completed
  /// from: the surface goes through these points, but those that yet another look saw through, and
  /// what was guessed of the same side of the object is left out. They weigh no shape: whatever of
  /// them is to do that is added as contacts.
  /// @throws std::invalid_argument for points without normals, or not finite.
  void add_seen(const geometry::PointCloud& seen_W);
  /// Where something may be swept: add balls and paths to it.
  geometry::SweptSpace& swept() { return swept_; }
  const geometry::SweptSpace& swept() const { return swept_; }
  const std::vector<Contact>& contacts() const { return contacts_; }

  /// Takes in all evidence. About 5 ms.
  void update();
  /// Of the last update, likeliest first.
  const std::vector<BelievedShape>& shapes() const { return shapes_; }
  /// The evidence speaks against every shape: with none it lies within kContradiction standard
  /// deviations on average, or none explains half of the contacts, or a third of them can be of no
  /// other part either, within the body or where it was seen to be empty, or no shape has any
  /// likelihood that is a number. Nothing is to be concluded from the belief then: begin again from
  /// a look.
  bool contradicted() const { return contradicted_; }
  static constexpr double kContradiction = 3;
  /// How far each act is thought to have moved the object, by the likeliest shape.
  const std::vector<Displacement::Moved>& moved() const;

  /// The surface of shapes()[i], with the object where it was first seen. @throws as reconstruct().
  geometry::TriangleMesh mesh(std::size_t i = 0) const;
  /// The same with BeliefOptions::coarse_resolution, several times as fast.
  geometry::TriangleMesh coarse_mesh(std::size_t i = 0) const;
  /// Some of the likeliest shape's points, spread over it, where they are thought to be, with the
  /// standard deviation of that along their normals [m].
  struct Site {
    Eigen::Vector3d p_W, normal_W;
    double deviation = 0;
    bool seen = false;  // or where something was seen
    int point = 0;      // of the hypothesis
  };
  std::vector<Site> sites() const;
  const geometry::Plane& table_W() const { return table_W_; }
  double extent() const { return extent_; }  // m, of the first prediction

  /// What a contact at one of the sites() would tell: by how much it would lower the sum of the
  /// sites' variances [m^2].
  double expected_gain(const Site& site, double deviation) const;

 private:
  const ShapeEvidence& shape(std::size_t i) const { return *all_[order_.at(i)]; }
  Evidence evidence() const;
  geometry::TriangleMesh mesh(std::size_t i, const surface::SurfaceOptions& surface) const;

  BeliefOptions options_;
  geometry::Plane table_W_;
  double extent_ = 0;
  std::vector<shape::SeenSpace> seen_spaces_;  // the first of the completion's look
  geometry::PointCloud seen_;                  // by add_seen()
  geometry::SweptSpace swept_;
  std::vector<Contact> contacts_;
  std::vector<int> acts_;  // of contacts
  std::vector<Motion> motions_;
  std::vector<std::unique_ptr<ShapeEvidence>> all_;
  std::vector<std::size_t> order_;  // of all_, as shapes_
  std::vector<BelievedShape> shapes_;
  bool contradicted_ = false;
};

}  // namespace prehend::belief
