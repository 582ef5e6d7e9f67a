#pragma once

#include <Eigen/Core>

namespace prehend::geometry {

/// Solves A x = b for a symmetric, positive or negative semidefinite A by its LDL^T decomposition
/// with pivoting (G. Golub, C. Van Loan, "Matrix Computations", 4.2.8). Where A is singular, x has
/// zeros along what it cannot decide. Compiled once for the sizes that are used.
template <int Size>
Eigen::Matrix<double, Size, 1> symmetric_solve(const Eigen::Matrix<double, Size, Size>& A,
                                               const Eigen::Matrix<double, Size, 1>& b);

extern template Eigen::Vector3d symmetric_solve<3>(const Eigen::Matrix3d&, const Eigen::Vector3d&);
extern template Eigen::Vector4d symmetric_solve<4>(const Eigen::Matrix4d&, const Eigen::Vector4d&);
extern template Eigen::Matrix<double, 6, 1> symmetric_solve<6>(const Eigen::Matrix<double, 6, 6>&,
                                                               const Eigen::Matrix<double, 6, 1>&);

/// Solves A x = b for a symmetric positive definite A of any size by Cholesky's decomposition, of
/// which only the lower triangle is read; no memory is allocated. `A` becomes its factor, `b`
/// becomes x. Where A is not positive definite, x is not finite or meaningless.
void cholesky_solve_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::VectorXd> b);

}  // namespace prehend::geometry
