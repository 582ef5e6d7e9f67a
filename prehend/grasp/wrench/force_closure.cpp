#include "prehend/grasp/wrench/force_closure.h"

#include <glpk.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "prehend/grasp/wrench/glpk_problem.h"
#include "prehend/text/require.h"

namespace prehend::grasp {
namespace {

using Wrenches = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// A programme of some 20 variables takes about 20 iterations.
constexpr int kClosureIterations = 500;

// Linear programmes over the weights lambda_1..n >= 0 of the primitive wrenches with sum 1, and one
// more variable, GLPK's column n + 1: maximise it subject to W lambda + c x = 0.
class WrenchProgramme {
 public:
  explicit WrenchProgramme(const Wrenches& wrenches)
      : programme_(make_glpk_problem()), count_(static_cast<int>(wrenches.cols())) {
    glp_set_obj_dir(programme_.get(), GLP_MAX);
    glp_add_rows(programme_.get(), 7);
    for (int row = 1; row <= 6; ++row) glp_set_row_bnds(programme_.get(), row, GLP_FX, 0, 0);
    glp_set_row_bnds(programme_.get(), 7, GLP_FX, 1, 1);
    glp_add_cols(programme_.get(), count_ + 1);
    for (int i = 0; i < count_; ++i) {
      glp_set_col_bnds(programme_.get(), i + 1, GLP_LO, 0, 0);
      set_column(i + 1, wrenches.col(i), 1);
    }
    glp_set_col_bnds(programme_.get(), count_ + 1, GLP_FR, 0, 0);
    glp_set_obj_coef(programme_.get(), count_ + 1, 1);
  }

  // The largest x; `feasible` is false, and the result 0, when no weights fulfil the equations.
  // `wrench`, `sum`: the extra variable's coefficients in the six wrench rows and in the sum.
  double maximise(const Eigen::Matrix<double, 6, 1>& wrench, double sum, bool* feasible) {
    set_column(count_ + 1, wrench, sum);
    glp_smcp parameters;
    glp_init_smcp(&parameters);
    parameters.msg_lev = GLP_MSG_OFF;
    parameters.it_lim = kClosureIterations;
    glp_std_basis(programme_.get());
    *feasible = solved(glp_simplex(programme_.get(), &parameters));
    if (!*feasible) {
      // With six zeros on the right-hand side the programme is degenerate, and rounding can make
      // the simplex method cycle or lose its feasibility: once more in rational arithmetic.
      glp_std_basis(programme_.get());
      *feasible = solved(glp_exact(programme_.get(), &parameters));
    }
    return *feasible ? glp_get_obj_val(programme_.get()) : 0;
  }

 private:
  bool solved(int return_code) const {
    return return_code == 0 && glp_get_status(programme_.get()) == GLP_OPT;
  }

  void set_column(int column, const Eigen::Matrix<double, 6, 1>& wrench, double sum) {
    // GLPK counts from one and wants no zeros.
    int rows[8];
    double values[8];
    int entries = 0;
    for (int k = 0; k < 7; ++k) {
      const double value = k < 6 ? wrench[k] : sum;
      if (value == 0) continue;
      ++entries;
      rows[entries] = k + 1;
      values[entries] = value;
    }
    glp_set_mat_col(programme_.get(), column, entries, rows, values);
  }

  GlpkProblem programme_;
  int count_;
};

// Two unit vectors perpendicular to each other and to `n`.
void tangents(const Eigen::Vector3d& n, Eigen::Vector3d* t1, Eigen::Vector3d* t2) {
  *t1 = n.unitOrthogonal();
  *t2 = n.cross(*t1);
}

// max over lambda >= 0, sum lambda = 1, W lambda = 0 of min_i lambda_i. With lambda = mu + t 1 this
// is max t subject to W mu + (W 1) t = 0, sum mu + n t = 1, mu >= 0.
double smallest_weight(const Wrenches& wrenches, WrenchProgramme* programme) {
  bool feasible = false;
  const double t = programme->maximise(wrenches.rowwise().sum(),
                                       static_cast<double>(wrenches.cols()), &feasible);
  return feasible ? t : -std::numeric_limits<double>::infinity();
}

double axis_quality(WrenchProgramme* programme) {
  double quality = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 6; ++k) {
    for (double sign : {1.0, -1.0}) {
      const Eigen::Matrix<double, 6, 1> column = -sign * Eigen::Matrix<double, 6, 1>::Unit(k);
      bool feasible = false;
      const double r = programme->maximise(column, 0, &feasible);
      quality = std::min(quality, feasible ? r : 0.0);
    }
  }
  return quality;
}

}  // namespace

void ForceClosureOptions::validate() const {
  const text::Require require{"ForceClosureOptions."};
  require(cone_edges >= 3, "cone_edges must be at least 3");
  require(rank_tolerance > 0 && rank_tolerance < 1, "rank_tolerance must be between 0 and 1");
  require(margin >= 0 && margin < 1, "margin must be between 0 and 1");
}

Wrenches primitive_wrenches(const std::vector<Contact>& contacts, const Eigen::Vector3d& center,
                            double length, int cone_edges) {
  std::vector<Eigen::Matrix<double, 6, 1>> columns;
  for (const Contact& contact : contacts) {
    const Eigen::Vector3d arm = (contact.point - center) / length;
    const auto add = [&](const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
      Eigen::Matrix<double, 6, 1> wrench;
      wrench << force, arm.cross(force) + torque;
      columns.push_back(wrench);
    };
    const Eigen::Vector3d& n = contact.normal;
    if (contact.friction == 0) {
      add(n, Eigen::Vector3d::Zero());
      continue;
    }
    Eigen::Vector3d t1, t2;
    tangents(n, &t1, &t2);
    for (int edge = 0; edge < cone_edges; ++edge) {
      const double angle = 2 * std::numbers::pi * edge / cone_edges;
      add(n + contact.friction * (std::cos(angle) * t1 + std::sin(angle) * t2),
          Eigen::Vector3d::Zero());
    }
    if (contact.torsion_radius > 0) {
      const double torsion = contact.friction * contact.torsion_radius / length;
      add(n, torsion * n);
      add(n, -torsion * n);
    }
  }
  Wrenches wrenches(6, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    wrenches.col(static_cast<Eigen::Index>(i)) = columns[i];
  }
  return wrenches;
}

ForceClosure evaluate_force_closure(const std::vector<Contact>& contacts,
                                    const Eigen::Vector3d& center, double length,
                                    const ForceClosureOptions& options) {
  options.validate();
  if (!(length > 0) || !std::isfinite(length)) {
    throw std::invalid_argument("evaluate_force_closure: length must be positive and finite");
  }
  for (const Contact& contact : contacts) {
    if (!contact.point.allFinite() || !(std::abs(contact.normal.norm() - 1) < 1e-6) ||
        !(contact.friction >= 0) || !(contact.torsion_radius >= 0)) {
      throw std::invalid_argument(
          "evaluate_force_closure: a contact needs a finite point, a unit normal, friction >= 0 "
          "and "
          "torsion_radius >= 0");
    }
  }
  ForceClosure result;
  if (contacts.empty()) return result;

  const Wrenches wrenches = primitive_wrenches(contacts, center, length, options.cone_edges);
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(wrenches);
  svd.setThreshold(options.rank_tolerance);
  result.rank = static_cast<int>(svd.rank());
  WrenchProgramme programme(wrenches);
  const double smallest = smallest_weight(wrenches, &programme);
  result.margin = std::isfinite(smallest) ? smallest * static_cast<double>(wrenches.cols()) : -1.0;
  result.closed = result.rank == 6 && result.margin > options.margin;
  if (result.closed) result.quality = axis_quality(&programme);
  return result;
}

}  // namespace prehend::grasp
