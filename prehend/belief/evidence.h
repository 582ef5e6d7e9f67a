#pragma once

#include <vector>

#include <Eigen/Core>

namespace prehend::belief {

/// A place where something of known pose met the object.
struct Contact {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();       // on the surface [m]
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // unit, outward of the object; 0: not known
  double deviation = 0.001;                            // m, standard, of p_W along the normal, > 0
};

/// How far an act may have moved the object on its support: standard deviations, >= 0.
struct Motion {
  double along = 0;  // m, in each direction along the support
  double turn = 0;   // rad, about the support's normal
};

}  // namespace prehend::belief
