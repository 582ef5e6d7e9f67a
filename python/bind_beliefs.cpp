// prehend.Belief: what touch makes of a prediction.

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "prehend/belief/object_belief.h"
#include "prehend/belief/probe.h"
#include "python/arrays.h"
#include "python/bound_types.h"

namespace prehend::python {
namespace {

using belief::ObjectBelief;
using belief::Probe;

belief::ProbeOptions probe_of(double radius, double deviation) {
  belief::ProbeOptions options;
  options.radius = radius;
  options.deviation = deviation;
  return options;
}

}  // namespace

void bind_beliefs(py::module_& m) {
  py::class_<Probe>(m, "Probe", "A straight motion of a fingertip, a ball.")
      .def_readonly("start", &Probe::start_W, "Of its centre [m].")
      .def_readonly("end", &Probe::end_W, "m, where it stops if nothing is met.")
      .def_readonly("at", &Probe::at_W, "m, on the surface, where it is thought to touch.")
      .def_readonly("gain", &Probe::gain, "m^2: by how much it lowers the mean variance.");
  py::class_<ObjectBelief>(
      m, "Belief",
      "What an object may be: several shapes with weights, corrected by contacts and by what was "
      "swept without one. The order of the evidence does not matter.")
      .def(py::init([](const Completion& completion) {
             return std::make_unique<ObjectBelief>(completion.get(), completion.support_W);
           }),
           py::arg("completion"),
           "Of a Completion, best with alternatives and other methods: "
           "scene.complete(alternatives=4, other_methods=True).")
      .def(
          "begin_act",
          [](ObjectBelief& b, double along, double turn) {
            b.begin_act({along, turn});
          },
          py::arg("along") = 0.0, py::arg("turn") = 0.0,
          "An act begins that may move the object so far along its support [m, rad, standard].")
      .def(
          "add_contact",
          [](ObjectBelief& b, const Eigen::Vector3d& point,
             const std::optional<Eigen::Vector3d>& normal, double deviation) {
            belief::Contact contact;
            contact.p_W = point;
            if (normal) contact.normal_W = *normal;
            contact.deviation = deviation;
            b.add(contact);
          },
          py::arg("point"), py::arg("normal") = py::none(), py::arg("deviation") = 0.001,
          "It was touched at `point` [m], where the surface has the outward unit `normal` (None: "
          "not known), with a standard `deviation` [m] along it.")
      .def(
          "add_swept",
          [](ObjectBelief& b, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
             double radius) {
            Probe probe;
            probe.start_W = start;
            probe.end_W = end;
            belief::add_probe(probe, end, std::nullopt, radius, &b);
          },
          py::arg("start"), py::arg("end"), py::arg("radius"),
          "A ball of `radius` [m] went from `start` to `end` [m] without touching it.")
      .def("update", &ObjectBelief::update, py::call_guard<py::gil_scoped_release>(),
           "Takes in what was added.")
      .def_property_readonly(
          "weights",
          [](const ObjectBelief& b) {
            std::vector<double> weights;
            for (const auto& shape : b.shapes()) weights.push_back(shape.weight);
            return weights;
          },
          "Of the shapes, likeliest first.")
      .def_property_readonly("contradicted", &ObjectBelief::contradicted,
                             "Whether the evidence speaks against every shape: look again then.")
      .def(
          "mesh", [](const ObjectBelief& b, std::size_t shape) { return b.mesh(shape); },
          py::arg("shape") = 0, py::call_guard<py::gil_scoped_release>(),
          "The surface of a shape, by its rank in `weights`.")
      .def_property_readonly(
          "sites",
          [](const ObjectBelief& b) {
            const auto sites = b.sites();
            Eigen::MatrixXd rows(static_cast<Eigen::Index>(sites.size()), 8);
            for (Eigen::Index i = 0; i < rows.rows(); ++i) {
              const auto& site = sites[static_cast<std::size_t>(i)];
              rows.row(i) << site.p_W.transpose(), site.normal_W.transpose(), site.deviation,
                  site.seen ? 1 : 0;
            }
            return rows;
          },
          "n x 8, over the likeliest shape: point [m], outward normal, standard deviation along it "
          "[m], 1 where it was seen.")
      .def(
          "best_probes",
          [](const ObjectBelief& b, int count, double radius, double deviation) {
            return belief::best_probes(b, count, probe_of(radius, deviation));
          },
          py::arg("count") = 1, py::arg("radius") = 0.006, py::arg("deviation") = 0.001,
          py::call_guard<py::gil_scoped_release>(),
          "Up to `count` Probes that would tell most, best first.");
}

}  // namespace prehend::python
