#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/robot/hand_model.h"

namespace prehend::grasp {

/// A link's shapes as balls beneath their faces, in a tree of balls round them.
struct LinkBalls {
  struct Node {
    Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m, in the link's frame
    double radius = 0;                                 // m; holds all below
    int first = 0, last = 0;  // of a leaf: its balls; of another node: last = 0, first = left child
    int right = 0;            // right child
    bool leaf() const { return last > 0; }
  };
  std::vector<Eigen::Vector3d> centers;  // m, in the link's frame
  std::vector<double> radii;             // m
  std::vector<Node> nodes;               // the first is the root; none for a link without shapes
  double reach = 0;                      // m, farthest point of a ball from the frame's origin
};

/// Surface of a hand for touching things with: every box, cylinder, ball and mesh (balls_within())
/// of every link covered from inside by balls. Faces are true to `tolerance`; edges are rounded, as
/// real fingers' are, by a fifth of the shape's smallest side, 3 to 10 mm. A thing thinner than the
/// gaps between balls is felt too, since the balls' radius is larger than their distance from one
/// another.
struct HandBalls {
  std::vector<LinkBalls> links;  // as in the model
  /// Bound of a point's way on link l while joint j alone moves by 1: [l][j] in m/rad or 1; 0 when
  /// j does not move l.
  std::vector<std::vector<double>> reach;
};

/// @throws std::invalid_argument for a tolerance that is not positive and finite;
/// geometry::InputError for a shape without volume.
HandBalls make_hand_balls(const robot::HandModel& hand, double tolerance = 0.00025);

}  // namespace prehend::grasp
