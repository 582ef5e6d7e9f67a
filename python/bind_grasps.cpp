#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "prehend/fidelity/plan_settings.h"
#include "prehend/grasp/planner.h"
#include "prehend/grasp/planner_options.h"
#include "prehend/robot/hand_model.h"
#include "python/arrays.h"
#include "python/bound_types.h"

namespace prehend::python {
namespace {

using geometry::TriangleMesh;
using grasp::Grasp;
using grasp::GraspPlan;
using grasp::Rejection;

void apply(const Chain& chain, const robot::HandModel& hand, double budget,
           grasp::PlannerOptions* options) {
  if (budget > 0) {
    throw geometry::InputError("budget is given beside a chain, which has one of its own",
                               "Leave one of them out");
  }
  if (chain.hand != hand.name) {
    throw geometry::InputError(
        "The chain was chosen for the hand " + chain.hand + ", and the hand is " + hand.name,
        "Choose one for it: prehend.chain(hand, ...)");
  }
  const fidelity::ChosenChain& chosen = chain.chosen;
  fidelity::apply_plan_front(chosen.front, chosen.budget, chosen.tolerance, options);
}

GraspPlan plan(const surface::ObjectModel& object, const robot::HandModel& hand,
               const std::pair<Eigen::Vector3d, double>& table,
               const std::vector<TriangleMesh>& obstacles,
               const std::optional<Eigen::Vector3d>& approach, double budget, std::uint64_t seed,
               const std::optional<Chain>& chain) {
  if (!(budget >= 0)) throw py::value_error("budget is seconds, 0: none");
  if (!(std::abs(table.first.norm() - 1) < 1e-6)) {
    throw py::value_error("the table's normal is no unit vector");
  }
  grasp::PlannerOptions options = grasp::default_options(hand);
  options.budget = budget;
  if (chain) apply(*chain, hand, budget, &options);
  options.candidates.seed = options.uncertainty.seed = seed;
  grasp::Reachability reachability;
  if (approach) reachability.approach_W = *approach;
  py::gil_scoped_release free;
  return grasp::plan_grasps(object, {table.first, table.second}, {obstacles, {}},
                            grasp::HandToClose(hand), reachability, options);
}

}  // namespace

void bind_grasps(py::module_& m) {
  py::class_<Grasp>(m, "Grasp", "A grasp of any hand, in the world frame.")
      .def_property_readonly(
          "tool_pose", [](const Grasp& g) { return Eigen::Matrix4d(g.X_WG.matrix()); },
          "4 x 4: the preshape's tool G when the hand closes.")
      .def_property_readonly(
          "hand_pose", [](const Grasp& g) { return Eigen::Matrix4d(g.X_WH.matrix()); },
          "4 x 4: the hand's root when it closes.")
      .def_readonly("approach_direction", &Grasp::approach_W, "3 numbers, unit.")
      .def_readonly("preshape", &Grasp::preshape)
      .def_readonly("score", &Grasp::score, "0..1, what the list is ranked by.")
      .def_readonly("quality", &Grasp::quality,
                    "epsilon: radius of the largest ball of wrenches that it resists.")
      .def_readonly("robustness", &Grasp::robustness,
                    "0..1: share of disturbed trials in which it holds; -1: not assessed.")
      .def_readonly("force", &Grasp::force, "N, per pad; 0: the motors' limits set it.")
      .def_readonly("open", &Grasp::open, "Motors [rad or m] before it closes.")
      .def_readonly("closed", &Grasp::closed, "Motors [rad or m] where it touches.")
      .def_readonly("guessed_contact", &Grasp::guessed_contact,
                    "0..1 of the force on surface that nobody saw.")
      .def_readonly("generator", &Grasp::generator)
      .def_readonly("remark", &Grasp::remark, "What to know of it; often ''.")
      .def_property_readonly("contacts", &grasp::contact_points, "Points [m] where it touches.")
      .def("__repr__", [](const Grasp& g) {
        return fmt::format("<Grasp {} score {:.2f} robustness {:.2f}>", g.preshape, g.score,
                           g.robustness);
      });
  py::class_<Rejection>(m, "Rejection", "Where candidates fell.")
      .def_property_readonly("reason",
                             [](const Rejection& r) { return grasp::to_string(r.reason); })
      .def_readonly("generator", &Rejection::generator, "'' when there is only one.")
      .def_readonly("count", &Rejection::count)
      .def_readonly("nearest_miss", &Rejection::nearest_miss, "As '74.0 mm > 69.0 mm'; often ''.")
      .def("__repr__", [](const Rejection& r) {
        return fmt::format("<Rejection of {}: {}>", r.count, grasp::to_string(r.reason));
      });
  py::class_<GraspPlan>(m, "GraspPlan", "Ranked grasps and the ledger of all other candidates.")
      .def_readonly("grasps", &GraspPlan::grasps, "Best first.")
      .def_readonly("rejections", &GraspPlan::rejections)
      .def_readonly("candidates", &GraspPlan::candidates, "How many: grasps and all rejections.")
      .def_readonly("problem", &GraspPlan::problem, "Why there is no grasp; '' when there is one.");
  m.def("plan_grasps", &plan, py::arg("object"), py::arg("hand"), py::kw_only(),
        py::arg("table") = std::pair(Eigen::Vector3d(0, 0, 1), 0.0),
        py::arg("obstacles") = std::vector<TriangleMesh>(),
        py::arg("approach_direction") = py::none(), py::arg("budget") = 0.0, py::arg("seed") = 1,
        py::arg("chain") = py::none(),
        "Plans grasps of an ObjectModel with a Hand. table: (normal, offset [m]); obstacles: "
        "meshes; approach_direction: 3 numbers, the only one that is tried; budget: seconds, 0: "
        "none; chain: a Chain of that hand in its place. Same input and seed, same plan, unless "
        "there is a budget.");
}

}  // namespace prehend::python
