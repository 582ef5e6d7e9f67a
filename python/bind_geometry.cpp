#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/mesh_files.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/triangle_mesh.h"
#include "python/arrays.h"

namespace prehend::python {
namespace {

using geometry::PointCloud;
using geometry::TriangleMesh;

PointCloud make_cloud(const py::object& points, const py::object& colors, const py::object& normals,
                      int width, int height) {
  PointCloud cloud;
  cloud.points = read_rows<float, Eigen::Vector3f>(points, "points", "f");
  if (!colors.is_none())
    cloud.colors = read_rows<std::uint8_t, geometry::Rgb>(colors, "colors", "u");
  if (!normals.is_none()) {
    cloud.normals = read_rows<float, Eigen::Vector3f>(normals, "normals", "f");
  }
  const std::size_t n = cloud.points.size();
  if ((!colors.is_none() && cloud.colors.size() != n) ||
      (!normals.is_none() && cloud.normals.size() != n)) {
    throw py::value_error(fmt::format("there are {} points, {} colors and {} normals; give as many",
                                      n, cloud.colors.size(), cloud.normals.size()));
  }
  const bool is_image = width > 0 && height > 0;
  if (is_image ? static_cast<std::size_t>(width) * static_cast<std::size_t>(height) != n
               : width != 0 || height != 0) {
    throw py::value_error(fmt::format("{} points are no image of {} x {}", n, width, height));
  }
  cloud.width = width;
  cloud.height = height;
  return cloud;
}

TriangleMesh make_mesh(const py::object& vertices, const py::object& triangles) {
  TriangleMesh mesh;
  mesh.vertices = read_rows<double, Eigen::Vector3d>(vertices, "vertices", "f");
  mesh.triangles = read_rows<int, Eigen::Vector3i>(triangles, "triangles", "iu");
  const auto n = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= n) {
      throw py::value_error(fmt::format("a triangle names vertex {}, and there are {}",
                                        t.minCoeff() < 0 ? t.minCoeff() : t.maxCoeff(), n));
    }
  }
  return mesh;
}

void bind_clouds(py::module_& m) {
  py::class_<PointCloud>(m, "PointCloud", "Points [m] with optional colours and normals.")
      .def(py::init(&make_cloud), py::arg("points"), py::arg("colors") = py::none(),
           py::arg("normals") = py::none(), py::arg("width") = 0, py::arg("height") = 0,
           "points: n x 3 floating [m], NaN where invalid; colors: n x 3 uint8 red, green, blue; "
           "normals: n x 3 floating, unit; width, height: of an organized cloud, rows from the "
           "top. Arrays are copied.")
      .def("__len__", &PointCloud::size)
      .def("__repr__",
           [](const PointCloud& c) { return fmt::format("<PointCloud of {} points>", c.size()); })
      .def_readonly("width", &PointCloud::width, "Columns of an organized cloud, else 0.")
      .def_readonly("height", &PointCloud::height, "Rows of an organized cloud, else 0.")
      .def_property_readonly("is_organized", &PointCloud::organized,
                             "Whether the points are a row-major image.")
      .def_property_readonly(
          "points",
          [](const py::object& self) {
            return rows_of<float>(self.cast<const PointCloud&>().points, self);
          },
          "n x 3 float32 [m], a read-only view.")
      .def_property_readonly(
          "colors",
          [](const py::object& self) {
            return rows_of<std::uint8_t>(self.cast<const PointCloud&>().colors, self);
          },
          "n x 3 uint8 red, green, blue, or 0 x 3; a read-only view.")
      .def_property_readonly(
          "normals",
          [](const py::object& self) {
            return rows_of<float>(self.cast<const PointCloud&>().normals, self);
          },
          "n x 3 float32, unit, or 0 x 3; a read-only view.");
  m.def(
      "read_cloud",
      [](const std::filesystem::path& path) {
        py::gil_scoped_release free;
        return geometry::read_cloud_file(path).cloud;
      },
      py::arg("path"), "Reads a .pcd or .ply cloud. Raises InputError for what is none.");
  m.def(
      "write_cloud",
      [](const std::filesystem::path& path, const PointCloud& cloud) {
        py::gil_scoped_release free;
        geometry::write_cloud_file(path, cloud);
      },
      py::arg("path"), py::arg("cloud"), "Writes a .pcd or .ply cloud by the name's ending.");
}

void bind_meshes(py::module_& m) {
  py::class_<TriangleMesh>(m, "TriangleMesh", "Triangles, counter-clockwise seen from outside [m].")
      .def(py::init(&make_mesh), py::arg("vertices"), py::arg("triangles"),
           "vertices: v x 3 floating [m]; triangles: t x 3 whole numbers, indices of vertices. "
           "Arrays are copied.")
      .def("__repr__",
           [](const TriangleMesh& mesh) {
             return fmt::format("<TriangleMesh of {} vertices, {} triangles>", mesh.vertices.size(),
                                mesh.triangles.size());
           })
      .def_property_readonly(
          "vertices",
          [](const py::object& self) {
            return rows_of<double>(self.cast<const TriangleMesh&>().vertices, self);
          },
          "v x 3 float64 [m], a read-only view.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            return rows_of<int>(self.cast<const TriangleMesh&>().triangles, self);
          },
          "t x 3 int32, a read-only view.")
      .def_property_readonly(
          "is_watertight",
          [](const TriangleMesh& mesh) {
            return !mesh.empty() && geometry::find_defects(mesh).watertight();
          },
          "Whether it bounds a solid.")
      .def_property_readonly(
          "defects",
          [](const TriangleMesh& mesh) { return geometry::find_defects(mesh).to_string(); },
          "'watertight', or what keeps it from that, in words.")
      .def_property_readonly(
          "volume", [](const TriangleMesh& mesh) { return geometry::mass_properties(mesh).volume; },
          "m^3, of a closed mesh; negative when it is inside out.")
      .def_property_readonly(
          "center_of_mass",
          [](const TriangleMesh& mesh) { return geometry::mass_properties(mesh).center_of_mass; },
          "3 numbers [m], of the solid with one density.")
      .def_property_readonly("area", &geometry::surface_area, "m^2.");
  m.def(
      "read_mesh",
      [](const std::filesystem::path& path, double scale) {
        py::gil_scoped_release free;
        return geometry::read_mesh_file(path, scale);
      },
      py::arg("path"), py::arg("scale") = 1.0,
      "Reads .obj, .ply, .stl, .dae or .off; scale: metres per unit of the file.");
  m.def(
      "write_mesh",
      [](const std::filesystem::path& path, const TriangleMesh& mesh) {
        py::gil_scoped_release free;
        geometry::write_mesh_file(path, mesh);
      },
      py::arg("path"), py::arg("mesh"), "Writes .obj, .ply or .stl by the name's ending.");
}

}  // namespace

void bind_geometry(py::module_& module) {
  bind_clouds(module);
  bind_meshes(module);
}

}  // namespace prehend::python
