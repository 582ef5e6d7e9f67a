#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/hand_model.h"
#include "python/arrays.h"
#include "python/bound_types.h"

namespace prehend::python {
namespace {

Chain choose_chain(const std::filesystem::path& folder, const robot::HandModel& hand, double budget,
                   double tolerance) {
  if (!(budget > 0) && !(tolerance > 0)) {
    throw geometry::InputError("A chain is chosen by a budget or a tolerance",
                               "Give budget= [s of processor] or tolerance= [m], above 0");
  }
  return {fidelity::choose_chain(
              folder, fidelity::chain_front_name(fidelity::ChainInput::kCloud, hand.name), budget,
              tolerance),
          hand.name};
}

}  // namespace

void bind_chains(py::module_& m) {
  py::class_<Chain>(m, "Chain",
                    "How all stages from a cloud to ranked grasps work, chosen from chains that "
                    "were measured.")
      .def_readonly("hand", &Chain::hand, "The name of the hand that it was chosen for.")
      .def_property_readonly(
          "knobs",
          [](const Chain& chain) {
            py::dict knobs;
            for (const auto& [name, value] : chain.chosen.setting.knobs) {
              knobs[py::str(name)] = value;
            }
            return knobs;
          },
          "What was chosen: value by name, as shape.thinning.")
      .def_property_readonly(
          "seconds", [](const Chain& chain) { return chain.chosen.setting.seconds; },
          "s of processor, as it was measured, from a cloud.")
      .def_property_readonly(
          "not_lifted", [](const Chain& chain) { return chain.chosen.setting.error; },
          "0..1 of the views, not lifted at the first attempt, as it was measured.")
      .def_property_readonly(
          "mesh_error",
          [](const Chain& chain) {
            return fidelity::tolerated_error(chain.chosen.front, chain.chosen.setting);
          },
          "m, mean distance of the true surface to the mesh, as it was measured.")
      .def("__repr__", [](const Chain& chain) {
        return fmt::format("<Chain for {}: {} ({})>", chain.hand, to_string(chain.chosen.setting),
                           fidelity::measured_text(chain.chosen.front, chain.chosen.setting));
      });
  m.def("choose_chain", &choose_chain, py::arg("folder"), py::arg("hand"), py::kw_only(),
        py::arg("budget") = 0.0, py::arg("tolerance") = 0.0,
        "Of the measured chains in the folder, for the Hand: the most often lifted within a budget "
        "[s of processor], or the fastest within a tolerance [m] of the mesh. Raises InputError, "
        "with the nearest one, where none keeps it.");
}

}  // namespace prehend::python
