#include "prehend/grasp/wrench/dense_programme.h"

#include <glpk.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "prehend/grasp/wrench/glpk_problem.h"

namespace prehend::grasp {
namespace {

constexpr int kLargestIterations = 2000;

bool is_optimal(glp_prob* programme, int return_code) {
  return return_code == 0 && glp_get_status(programme) == GLP_OPT;
}

}  // namespace

std::optional<Eigen::VectorXd> DenseProgramme::maximise() const {
  const Eigen::Index n = objective.size(), p = equal.rows(), q = below.rows();
  if ((p > 0 && equal.cols() != n) || (q > 0 && below.cols() != n) || right.size() != p ||
      most.size() != q || n == 0) {
    throw std::invalid_argument("DenseProgramme: sizes do not fit");
  }
  if (!objective.allFinite() || !equal.allFinite() || !right.allFinite() || !below.allFinite() ||
      !most.allFinite()) {
    throw std::invalid_argument("DenseProgramme: a number is not finite");
  }
  const GlpkProblem programme = make_glpk_problem();
  glp_set_obj_dir(programme.get(), GLP_MAX);
  glp_add_rows(programme.get(), static_cast<int>(p + q));
  for (Eigen::Index i = 0; i < p; ++i) {
    glp_set_row_bnds(programme.get(), static_cast<int>(i) + 1, GLP_FX, right[i], right[i]);
  }
  for (Eigen::Index i = 0; i < q; ++i) {
    glp_set_row_bnds(programme.get(), static_cast<int>(p + i) + 1, GLP_UP, 0, most[i]);
  }
  glp_add_cols(programme.get(), static_cast<int>(n));
  // GLPK counts from one and wants no zeros.
  std::vector<int> rows(static_cast<std::size_t>(p + q) + 1);
  std::vector<double> values(rows.size());
  for (Eigen::Index j = 0; j < n; ++j) {
    const int column = static_cast<int>(j) + 1;
    glp_set_col_bnds(programme.get(), column, GLP_LO, 0, 0);
    glp_set_obj_coef(programme.get(), column, objective[j]);
    int entries = 0;
    for (Eigen::Index i = 0; i < p + q; ++i) {
      const double value = i < p ? equal(i, j) : below(i - p, j);
      if (value == 0) continue;
      ++entries;
      rows[static_cast<std::size_t>(entries)] = static_cast<int>(i) + 1;
      values[static_cast<std::size_t>(entries)] = value;
    }
    glp_set_mat_col(programme.get(), column, entries, rows.data(), values.data());
  }
  glp_smcp parameters;
  glp_init_smcp(&parameters);
  parameters.msg_lev = GLP_MSG_OFF;
  parameters.it_lim = kLargestIterations;
  const int code = glp_simplex(programme.get(), &parameters);
  if (!is_optimal(programme.get(), code)) {
    const int status = glp_get_status(programme.get());
    if (code == 0 && (status == GLP_NOFEAS || status == GLP_UNBND)) return std::nullopt;
    glp_std_basis(programme.get());
    if (!is_optimal(programme.get(), glp_exact(programme.get(), &parameters))) {
      return std::nullopt;
    }
  }
  Eigen::VectorXd x(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    x[j] = glp_get_col_prim(programme.get(), static_cast<int>(j) + 1);
  }
  return x;
}

}  // namespace prehend::grasp
