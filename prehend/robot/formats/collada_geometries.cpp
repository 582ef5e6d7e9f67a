#include "prehend/robot/formats/collada_geometries.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/collada_solid.h"

namespace prehend::robot::formats {
namespace {

using geometry::TriangleMesh;

/// An attribute that counts something.
std::size_t count_of(const XmlElement& element, const char* name, std::size_t otherwise) {
  const auto number = element.number(name);
  if (!number) return otherwise;
  constexpr double kMost = 1e9;
  if (!(*number >= 0 && *number <= kMost) || *number != std::floor(*number)) {
    element.fail(fmt::format("{}=\"{:g}\" is no count", name, *number),
                 "Write a whole number, 0 or more");
  }
  return static_cast<std::size_t>(*number);
}

TriangleMesh without_doubles(const std::vector<Eigen::Vector3d>& points,
                             const std::vector<Eigen::Vector3i>& triangles) {
  const TriangleMesh mesh{points, triangles};
  const double extent = geometry::bounds(mesh).diagonal().norm();
  // Some writers repeat the corners of each triangle.
  return extent > 0 ? geometry::with_merged_vertices(mesh, 1e-7 * extent) : TriangleMesh();
}

}  // namespace

ColladaGeometries::Geometry& ColladaGeometries::of(const XmlElement& instance) {
  const std::string url = instance.attribute("url").value_or("");
  const auto known = geometries_.find(url);
  if (known != geometries_.end()) return known->second;
  const auto element = document_.by_url(url);
  if (!element) {
    if (!url.starts_with("#")) {
      instance.drop("it is in another document");
      return geometries_[url];
    }
    instance.fail("geometry '" + url + "' is not there", "Mend its url");
  }
  element->attribute("name");
  Geometry result;
  double length = length_;
  if (const auto asset = element->child("asset")) {
    if (const auto unit = asset->child("unit")) length = unit->number("meter").value_or(1);
    if (!(length > 0)) asset->fail("a unit of no length", "Write metres");
  }
  const auto mesh = element->child("mesh"), convex = element->child("convex_mesh");
  if (mesh) {
    result.parts = read_mesh(*mesh, length);
  } else if (convex && !convex->attribute("convex_hull_of")) {
    result.parts = read_mesh(*convex, length);
  } else if (convex) {
    const auto other = document_.by_url(convex->attribute("convex_hull_of").value_or(""));
    const auto of = other ? other->child("mesh") : std::nullopt;
    if (!of) convex->fail("the mesh that it is the hull of is not there", "Mend convex_hull_of");
    result.parts.push_back(
        {"", std::make_shared<const TriangleMesh>(geometry::convex_hull(read_points(*of, length))),
         ""});
  } else {
    element->drop("its geometry is no mesh");
  }
  for (const XmlElement& extra : element->children("extra")) {
    const auto technique = extra.child("technique");
    if (extra.attribute("type").value_or("") != "geometry_info" || !technique) {
      extra.drop("it is of its writer's own");
      continue;
    }
    technique->attribute("profile");
    result.is_seen = bool_in(technique->child("visible"), true);
    result.primitive = collada_solid(*technique, length);
    const bool is_it = result.primitive && result.parts.size() == 1 &&
                       is_same_solid(*result.primitive, *result.parts[0].surface);
    if (result.primitive && !is_it) {
      technique->drop("its mesh is kept, which is no such solid");
      result.primitive.reset();
    }
  }
  return geometries_.emplace(url, std::move(result)).first->second;
}

std::vector<Eigen::Vector3d> ColladaGeometries::read_points(const XmlElement& mesh, double length) {
  const auto vertices = mesh.child("vertices");
  if (!vertices) mesh.fail("the mesh has no vertices", "Give them");
  vertices->attribute("id");
  for (const XmlElement& input : vertices->children("input")) {
    const std::string source = input.attribute("source").value_or("");
    if (input.attribute("semantic").value_or("") == "POSITION") {
      return read_source(source, input, length);
    }
    input.drop("normals, colours and textures of points are not kept");
    const auto unused = document_.by_url(source);
    if (unused && told_.insert(source).second) {
      unused->drop("normals, colours and textures of points are not kept");
    }
  }
  vertices->fail("the vertices have no positions", "Give an input of semantic POSITION");
}

std::vector<Eigen::Vector3d> ColladaGeometries::read_source(const std::string& url,
                                                            const XmlElement& user, double length) {
  const auto source = document_.by_url(url);
  if (!source) user.fail("source '" + url + "' is not there", "Mend the name of its source");
  const auto technique = source->child("technique_common");
  const auto accessor = technique ? technique->child("accessor") : std::nullopt;
  std::optional<XmlElement> array;
  if (accessor) array = document_.by_url(accessor->attribute("source").value_or(""));
  if (!accessor || !array || array->name() != "float_array") {
    source->fail("the source has no accessor, or no numbers", "Give a float_array and an accessor");
  }
  const std::vector<double> numbers = array->text_numbers(0);
  if (count_of(*array, "count", numbers.size()) != numbers.size()) {
    // OpenRAVE's first writer counted points.
    array->approximate("all of its numbers are read, which are not as many as its count says");
  }
  for (const char* digits : {"digits", "magnitude"}) array->attribute(digits);
  const std::size_t count = count_of(*accessor, "count", 0);
  const std::size_t stride = count_of(*accessor, "stride", 1);
  const std::size_t offset = count_of(*accessor, "offset", 0);
  for (const XmlElement& param : accessor->children("param")) {
    param.attribute("name");
    param.attribute("type");
  }
  if (stride < 3 || (count > 0 && offset + (count - 1) * stride + 3 > numbers.size())) {
    accessor->fail(fmt::format("{} points of stride {} from {} are not in {} numbers", count,
                               stride, offset, numbers.size()),
                   "Mend count, stride or offset");
  }
  std::vector<Eigen::Vector3d> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double* first = numbers.data() + offset + i * stride;
    points[i] = length * Eigen::Vector3d(first[0], first[1], first[2]);
  }
  return points;
}

void ColladaGeometries::read_triangles(const XmlElement& primitive, std::size_t points,
                                       std::vector<Eigen::Vector3i>& triangles) {
  const std::string kind = primitive.name();
  primitive.attribute("count");
  primitive.attribute("name");
  std::size_t stride = 0;
  std::optional<std::size_t> offset;
  for (const XmlElement& input : primitive.children("input")) {
    const std::size_t its = count_of(input, "offset", 0);
    constexpr std::size_t kMostInputs = 64;
    if (its > kMostInputs) input.fail("the offset is larger than any", "Mend it");
    stride = std::max(stride, its + 1);
    input.attribute("set");
    if (input.attribute("semantic").value_or("") == "VERTEX") {
      input.attribute("source");
      offset = its;
      continue;
    }
    const std::string source = input.attribute("source").value_or("");
    input.drop("normals, colours and textures of points are not kept");
    const auto unused = document_.by_url(source);
    if (unused && told_.insert(source).second) {
      unused->drop("normals, colours and textures of points are not kept");
    }
  }
  if (!offset) primitive.fail("<" + kind + "> has no input of semantic VERTEX", "Give one");
  const auto corners_in = [&](const XmlElement& list) {
    const std::vector<double> numbers = list.text_numbers(0);
    if (numbers.size() % stride != 0) {
      list.fail(fmt::format("{} indices are not in rows of {}", numbers.size(), stride), "Mend it");
    }
    std::vector<int> corners;
    corners.reserve(numbers.size() / stride);
    for (std::size_t i = *offset; i < numbers.size(); i += stride) {
      const double index = numbers[i];
      if (!(index >= 0 && index < static_cast<double>(points)) || index != std::floor(index)) {
        list.fail(fmt::format("index {:g} is none of the {} points", index, points), "Mend it");
      }
      corners.push_back(static_cast<int>(index));
    }
    return corners;
  };
  const auto add_fan = [&](const int* corners, std::size_t count) {
    for (std::size_t i = 2; i < count; ++i) {
      triangles.emplace_back(corners[0], corners[i - 1], corners[i]);
    }
  };
  if (kind == "polylist") {
    const auto list = primitive.child("p"), sizes = primitive.child("vcount");
    if (!list || !sizes) return;
    const std::vector<int> corners = corners_in(*list);
    std::size_t first = 0;
    for (const double size : sizes->text_numbers(0)) {
      if (!(size >= 0) || size != std::floor(size) ||
          size > static_cast<double>(corners.size() - first)) {
        sizes->fail(fmt::format("a polygon of {:g} corners is not in <p>", size), "Mend vcount");
      }
      add_fan(corners.data() + first, static_cast<std::size_t>(size));
      first += static_cast<std::size_t>(size);
    }
    return;
  }
  for (const XmlElement& list : primitive.children("p")) {
    const std::vector<int> corners = corners_in(list);
    if (kind == "triangles") {
      if (corners.size() % 3 != 0) list.fail("a triangle lacks corners", "Mend it");
      for (std::size_t i = 0; i < corners.size(); i += 3) add_fan(corners.data() + i, 3);
    } else if (kind == "tristrips") {
      for (std::size_t i = 2; i < corners.size(); ++i) {
        const bool is_odd = i % 2 != 0;
        triangles.emplace_back(corners[i - 2], corners[is_odd ? i : i - 1],
                               corners[is_odd ? i - 1 : i]);
      }
    } else {
      add_fan(corners.data(), corners.size());
    }
  }
  for (const XmlElement& one : primitive.children("ph")) one.drop("polygons with holes");
}

std::vector<ColladaGeometries::Part> ColladaGeometries::read_mesh(const XmlElement& mesh,
                                                                  double length) {
  const std::vector<Eigen::Vector3d> points = read_points(mesh, length);
  std::vector<std::pair<std::string, std::vector<Eigen::Vector3i>>> by_symbol;
  bool has_lists = false;
  for (const XmlElement& one : mesh.children()) {
    const std::string kind = one.name();
    if (kind == "source" || kind == "vertices") continue;
    if (kind != "triangles" && kind != "polylist" && kind != "polygons" && kind != "trifans" &&
        kind != "tristrips") {
      one.drop("it has no surface");
      continue;
    }
    has_lists = true;
    const std::string symbol = one.attribute("material").value_or("");
    auto found = std::find_if(by_symbol.begin(), by_symbol.end(),
                              [&](const auto& its) { return its.first == symbol; });
    if (found == by_symbol.end()) found = by_symbol.insert(by_symbol.end(), {symbol, {}});
    read_triangles(one, points.size(), found->second);
  }
  std::vector<Part> parts;
  for (const auto& [symbol, triangles] : by_symbol) {
    TriangleMesh surface = without_doubles(points, triangles);
    if (surface.triangles.empty()) continue;
    parts.push_back({symbol, std::make_shared<const TriangleMesh>(std::move(surface)), ""});
  }
  if (!has_lists && points.size() > 3) {
    parts.push_back({"", std::make_shared<const TriangleMesh>(geometry::convex_hull(points)), ""});
  }
  return parts;
}

}  // namespace prehend::robot::formats
