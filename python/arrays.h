#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <Eigen/Core>

#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"

// Between NumPy's arrays and the library's types.
namespace prehend::python {

namespace py = pybind11;

/// Rows of `data` as a read-only array of n x 3 without a copy; `owner` keeps it alive.
template <class Number, class Row>
py::array rows_of(const std::vector<Row>& data, const py::handle& owner) {
  static_assert(sizeof(Row) == 3 * sizeof(Number));
  const auto n = static_cast<py::ssize_t>(data.size());
  const auto* first = reinterpret_cast<const Number*>(data.data());
  py::array_t<Number> array({n, py::ssize_t{3}}, first, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// An image's pixels as a read-only array of height x width without a copy.
template <class Number, class Pixel>
py::array image_of(const geometry::Image<Pixel>& image, const py::handle& owner) {
  static_assert(sizeof(Number) == sizeof(Pixel));
  py::array_t<Number> array(
      {static_cast<py::ssize_t>(image.height), static_cast<py::ssize_t>(image.width)},
      reinterpret_cast<const Number*>(image.data.data()), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// Numbers without an owner: a copy.
template <class Number>
py::array numbers_of(const std::vector<Number>& data) {
  return py::array_t<Number>(static_cast<py::ssize_t>(data.size()), data.data());
}

/// Copies an array of n x 3 whose numbers are of one of `kinds` (NumPy's letters: f floating, i and
/// u whole). @throws TypeError, ValueError naming `what`.
template <class Number, class Row>
std::vector<Row> read_rows(const py::object& given, const char* what, const char* kinds) {
  const py::array any = py::array::ensure(given);
  if (!any) throw py::type_error(std::string(what) + " is no array of numbers");
  if (std::string(kinds).find(any.dtype().kind()) == std::string::npos) {
    throw py::type_error(std::string(what) + " has numbers of type " +
                         std::string(py::str(any.dtype())) + "; give n x 3 of " +
                         std::string(py::str(py::dtype::of<Number>())));
  }
  if (any.size() == 0) return {};
  if (any.ndim() != 2 || any.shape(1) != 3) {
    throw py::value_error(std::string(what) + " has the shape " +
                          std::string(py::str(any.attr("shape"))) + "; give n x 3");
  }
  const auto array = py::array_t<Number, py::array::c_style | py::array::forcecast>::ensure(any);
  if (!array) throw py::error_already_set();
  std::vector<Row> rows(static_cast<std::size_t>(any.shape(0)));
  const Number* from = array.data();
  for (Row& row : rows) {
    for (std::size_t k = 0; k < 3; ++k) row[static_cast<int>(k)] = *from++;
  }
  return rows;
}

/// A pose as 4 x 4. @throws ValueError when it is none.
geometry::RigidTransform read_pose(const Eigen::Matrix4d& matrix, const char* what);

void bind_geometry(py::module_& module);
void bind_prediction(py::module_& module);
void bind_robots(py::module_& module);
void bind_grasps(py::module_& module);
void bind_recordings(py::module_& module);
void bind_graph(py::module_& module);
void bind_world(py::module_& module);
void bind_beliefs(py::module_& module);
void bind_chains(py::module_& module);

}  // namespace prehend::python
