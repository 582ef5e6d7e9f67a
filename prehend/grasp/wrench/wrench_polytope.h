#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace prehend::grasp {

/// A simplicial polytope in six dimensions round a point, grown by points outside it: what
/// wrench_hull() expands. Facets know their neighbours, so growing touches only what is near: the
/// facets that a point is beyond are found from one of them, and a new facet's plane is the one of
/// the pencil of its two old neighbours that holds the point. Planes carry a bound of their
/// rounding errors and are made anew from their points where that is too large.
class WrenchPolytope {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  /// Of `simplex`, seven columns in general position. Keeps a reference to the wrenches, of at most
  /// unit norm.
  WrenchPolytope(const Wrenches& wrenches, const std::vector<int>& simplex);

  /// A facet was too thin to have a normal: what follows is not to be relied on.
  bool failed() const { return failed_; }
  int made() const { return made_; }

  /// The facet nearest to the origin, of those nearer than `farthest`; -1 when there is none.
  /// Facets farther than any `farthest` that was given are not asked for again: it must not grow.
  int nearest(double farthest);
  double offset(int facet) const { return at(facet).offset; }
  const Vector6& normal(int facet) const { return at(facet).normal; }
  /// Makes the facet's plane anew from its points.
  void refine(int facet) { set_plane_by_points(at(facet)); }

  /// Takes in the point, a column that lies beyond `facet`.
  void grow(int point, int facet, double tolerance);

 private:
  static constexpr int kDimension = 6;
  struct Facet {
    Vector6 normal = Vector6::Zero();  // unit, outward
    double offset = 0;                 // of the plane from the origin
    double error = 0;                  // bound of the plane's
    double height = 0;                 // of the point of this round over it
    int round = 0;                     // in which height was found
    int serial = 0;                    // places are used again
    bool visible = false;
    std::array<int, kDimension> vertices{};
    std::array<int, kDimension> neighbors{};  // across the ridge without that vertex
    std::array<int, kDimension> made{};       // new facets on those ridges, in this round
  };
  struct Entry {
    double offset;
    int facet, serial;
  };

  Facet& at(int facet) { return facets_[static_cast<std::size_t>(facet)]; }
  const Facet& at(int facet) const { return facets_[static_cast<std::size_t>(facet)]; }
  int new_place();
  void keep(int facet);
  void set_plane_by_points(Facet& facet);
  bool sees(int facet, const Vector6& p, double tolerance);
  void connect(int facet, int old_facet, int replaced);
  static int index_of(const std::array<int, kDimension>& list, int value);

  const Wrenches& wrenches_;
  Vector6 inside_;
  std::vector<Facet> facets_;
  std::vector<int> free_, visible_;
  std::vector<Entry> heap_;
  double farthest_;
  int made_ = 0, round_ = 0;
  bool failed_ = false;
};

}  // namespace prehend::grasp
