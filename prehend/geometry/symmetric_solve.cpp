#include "prehend/geometry/symmetric_solve.h"

#include <Eigen/Cholesky>

namespace prehend::geometry {

template <int Size>
Eigen::Matrix<double, Size, 1> symmetric_solve(const Eigen::Matrix<double, Size, Size>& A,
                                               const Eigen::Matrix<double, Size, 1>& b) {
  return A.ldlt().solve(b);
}

template Eigen::Vector3d symmetric_solve<3>(const Eigen::Matrix3d&, const Eigen::Vector3d&);
template Eigen::Vector4d symmetric_solve<4>(const Eigen::Matrix4d&, const Eigen::Vector4d&);
template Eigen::Matrix<double, 6, 1> symmetric_solve<6>(const Eigen::Matrix<double, 6, 6>&,
                                                        const Eigen::Matrix<double, 6, 1>&);

void cholesky_solve_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::VectorXd> b) {
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(A);
  factors.solveInPlace(b);
}

}  // namespace prehend::geometry
