// The module prehend._prehend.

#include <cmath>

#include "prehend/geometry/errors.h"
#include "python/arrays.h"

namespace prehend::python {

geometry::RigidTransform read_pose(const Eigen::Matrix4d& matrix, const char* what) {
  constexpr double kTolerance = 1e-6;
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const bool is_pose = matrix.allFinite() &&
                       matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kTolerance) &&
                       (R.transpose() * R).isIdentity(kTolerance) && R.determinant() > 0;
  if (!is_pose) {
    throw py::value_error(std::string(what) +
                          " is no pose: give 4 x 4 with a rotation, a position in metres and the "
                          "last row 0 0 0 1");
  }
  return geometry::RigidTransform(matrix);
}

}  // namespace prehend::python

PYBIND11_MODULE(_prehend, module) {
  using namespace prehend::python;
  // A kind of ValueError, so that who expects one of bad input gets one.
  py::register_exception<prehend::geometry::InputError>(module, "InputError", PyExc_ValueError);
  bind_geometry(module);
  bind_robots(module);
  bind_chains(module);
  bind_prediction(module);
  bind_grasps(module);
  bind_recordings(module);
  bind_graph(module);
  bind_world(module);
  bind_beliefs(module);
}
