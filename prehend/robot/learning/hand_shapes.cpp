#include "prehend/robot/learning/hand_shapes.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"

namespace prehend::robot::learning {
namespace {

using formats::LinkDescription;
using formats::Shape;

constexpr double kPoint = 0.004;      // m, the longest side of one
constexpr double kPointShare = 0.01;  // of the volume of the shape beside it

class ShapeCompleter {
 public:
  explicit ShapeCompleter(formats::ShapeMeshes& meshes) : meshes_(meshes) {}

  /// Whether the link has a shape then.
  bool complete(LinkDescription& link) {
    std::erase_if(link.collisions, [&](const Shape& shape) { return !is_readable(shape); });
    if (link.collisions.empty()) {
      for (const Shape& shape : link.visuals) {
        if (is_readable(shape)) link.collisions.push_back(shape);
      }
      from_seen_ += link.collisions.empty() ? 0 : 1;
    }
    drop_points(link.collisions);
    return !link.collisions.empty();
  }

  /// Of the last that was not read; empty: all were.
  const std::string& unread() const { return unread_; }

  void say(std::vector<Said>& said) const {
    if (!unread_.empty()) said.push_back({"shapes", "some are not read: " + unread_, 0.5});
    if (from_seen_ > 0) {
      said.push_back({"shapes",
                      fmt::format("{} links are touched where they are seen: they had no collision "
                                  "shape",
                                  from_seen_),
                      0.8});
    }
    if (points_ > 0) {
      said.push_back({"shapes",
                      fmt::format("{} of at most {:.0f} mm are left out: points by which a "
                                  "simulator collides",
                                  points_, 1000 * kPoint),
                      0.8});
    }
  }

 private:
  bool is_readable(const Shape& shape) {
    try {
      return !meshes_.of(shape).triangles.empty();
    } catch (const geometry::InputError& error) {
      unread_ = error.problem();
      return false;
    }
  }

  void drop_points(std::vector<Shape>& shapes) {
    if (shapes.size() < 2) return;
    std::vector<Eigen::Vector3d> sizes;
    double largest = 0;  // m^3, of the boxes round them
    for (const Shape& shape : shapes) {
      sizes.emplace_back(geometry::bounds(meshes_.of(shape)).sizes());
      largest = std::max(largest, sizes.back().prod());
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      if (sizes[i].maxCoeff() <= kPoint && sizes[i].prod() < kPointShare * largest) {
        ++points_;
      } else {
        std::swap(shapes[kept++], shapes[i]);
      }
    }
    shapes.resize(kept);
  }

  formats::ShapeMeshes& meshes_;
  std::string unread_;
  int from_seen_ = 0, points_ = 0;
};

}  // namespace

void complete_shapes(formats::RobotDescription& robot, formats::ShapeMeshes& meshes,
                     std::vector<Said>& said) {
  ShapeCompleter completer(meshes);
  int with_shape = 0;
  for (LinkDescription& link : robot.links) {
    const bool has_shape = completer.complete(link);
    with_shape += has_shape && robot.joint_above(link.name) != nullptr ? 1 : 0;
  }
  if (with_shape == 0) {
    throw geometry::InputError(
        "No finger of '" + robot.name + "' has a shape" +
            (completer.unread().empty() ? "" : ": " + completer.unread()),
        "Put its meshes where the file names them, or give ROS_PACKAGE_PATH");
  }
  completer.say(said);
}

}  // namespace prehend::robot::learning
