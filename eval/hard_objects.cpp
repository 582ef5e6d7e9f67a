#include "eval/hard_objects.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "eval/household_objects.h"
#include "eval/implicit_mesh.h"

namespace prehend::eval {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::TriangleMesh;
using Mesh = std::shared_ptr<const TriangleMesh>;
using solids::cone_segment;
using solids::ellipsoid;
using solids::revolution;
using solids::rounded_box;
using solids::torus;

constexpr double kDegree = std::numbers::pi / 180;

// A solid within a box, meshed where it is.
Mesh meshed(const Implicit& solid, const Vector3d& low, const Vector3d& high, double cell) {
  const Vector3d margin = Vector3d::Constant(2 * cell);
  return std::make_shared<TriangleMesh>(mesh_of(solid, {low - margin, high + margin}, cell));
}

// The same, put on z = 0.
Mesh resting(const Implicit& solid, const Vector3d& low, const Vector3d& high, double cell) {
  return std::make_shared<TriangleMesh>(standing(*meshed(solid, low, high, cell)));
}

Mesh box_at(const Vector3d& center, const Vector3d& size, double cell = 0.002, double yaw = 0) {
  const Eigen::AngleAxisd R(-yaw, Vector3d::UnitZ());
  const double reach = size.head<2>().norm() / 2;
  const Vector3d half(reach, reach, size.z() / 2);
  return meshed(
      [=](const Vector3d& p) {
        return rounded_box(R * (p - center), {0, 0, 0}, size, 1.5 * cell);
      },
      center - half, center + half, cell);
}

double radius_of(const std::vector<Vector2d>& outline) {
  double radius = 0;
  for (const Vector2d& p : outline) radius = std::max(radius, p.x());
  return radius;
}

double height_of(const std::vector<Vector2d>& outline) {
  double height = 0;
  for (const Vector2d& p : outline) height = std::max(height, p.y());
  return height;
}

Mesh turned(const std::vector<Vector2d>& outline, double cell = 0.0015) {
  const double radius = radius_of(outline);
  return meshed([&](const Vector3d& p) { return revolution(p, outline); }, {-radius, -radius, 0},
                {radius, radius, height_of(outline)}, cell);
}

// An open vessel of a wall and a floor of the thickness `wall`, radii at the foot and the rim.
std::vector<Vector2d> vessel(double foot, double rim, double height, double wall) {
  return {{0, 0}, {foot, 0}, {rim, height}, {rim - wall, height}, {foot - wall, wall}, {0, wall}};
}

// A body of revolution that lies: its axis from `foot` along `direction`.
struct Pose {
  Vector3d origin;
  Eigen::Matrix3d R;  // of the body's axes
  Vector3d operator()(const Vector3d& p) const { return R.transpose() * (p - origin); }
};

Pose with_axis(const Vector3d& origin, const Vector3d& axis) {
  return {origin, Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis).toRotationMatrix()};
}

EvaluationObject object(std::string name, Mesh mesh_B, Viewing viewing, bool symmetric = true) {
  EvaluationObject made;
  made.name = std::move(name);
  made.mesh_B = std::move(mesh_B);
  made.symmetric = symmetric;
  made.viewing = std::move(viewing);
  return made;
}

Viewing from(double elevation, DepthSensor sensor = DepthSensor::kStereo) {
  Viewing viewing;
  viewing.elevation = elevation;
  viewing.sensor = sensor;
  return viewing;
}

Viewing among(std::vector<Mesh> others_B, double elevation,
              DepthSensor sensor = DepthSensor::kStereo) {
  Viewing viewing = from(elevation, sensor);
  viewing.others_B = std::move(others_B);
  return viewing;
}

constexpr DepthSensor kLight = DepthSensor::kStructuredLight;

const std::vector<Vector2d> kFlask = {{0, 0},        {0.03, 0},      {0.033, 0.003}, {0.033, 0.12},
                                      {0.028, 0.14}, {0.014, 0.165}, {0.012, 0.19},  {0, 0.19}};

// A jug with a handle in +x, standing.
double jug(const Vector3d& p, double radius, double height, double handle) {
  const double body = revolution(p, vessel(radius * 0.9, radius, height, 0.004));
  const double ring = torus(p, {radius - 0.002, 0, height / 2}, Vector3d::UnitY(), handle, 0.006);
  return std::min(body, std::max(ring, radius - 0.002 - std::hypot(p.x(), p.y())));
}

}  // namespace

std::vector<EvaluationObject> hard_objects() {
  std::vector<EvaluationObject> made;
  made.push_back(object("deep_bowl", turned(vessel(0.045, 0.08, 0.075, 0.005)), from(45)));
  made.push_back(object(
      "plate", turned({{0, 0}, {0.06, 0}, {0.11, 0.02}, {0.108, 0.024}, {0.06, 0.005}, {0, 0.005}}),
      from(35)));
  made.push_back(object("pot",
                        meshed(
                            [](const Vector3d& p) {
                              const double body = revolution(p, vessel(0.088, 0.09, 0.1, 0.004));
                              double handles = 1;
                              for (const double side : {-1.0, 1.0}) {
                                handles = std::min(handles, torus(p, {0, side * 0.092, 0.08},
                                                                  Vector3d::UnitZ(), 0.022, 0.005));
                              }
                              return std::min(body,
                                              std::max(handles, 0.0885 - std::hypot(p.x(), p.y())));
                            },
                            {-0.09, -0.12, 0}, {0.09, 0.12, 0.1}, 0.002),
                        from(50, kLight)));
  made.push_back(
      object("basket",
             meshed(
                 [](const Vector3d& p) {
                   const double outer = rounded_box(p, {0, 0, 0.045}, {0.2, 0.14, 0.09}, 0.004);
                   const double inner = rounded_box(p, {0, 0, 0.06}, {0.19, 0.13, 0.11}, 0.004);
                   return std::max(outer, -inner);
                 },
                 {-0.1, -0.07, 0}, {0.1, 0.07, 0.09}, 0.002),
             from(40)));
  {
    // Its neck on the edge of a box, its foot on the table.
    const double tilt = 17 * kDegree;
    const Pose pose =
        with_axis({-0.09, 0, 0.033 * std::cos(tilt)}, {std::cos(tilt), 0, std::sin(tilt)});
    made.push_back(object("bottle_on_box",
                          meshed([pose](const Vector3d& p) { return revolution(pose(p), kFlask); },
                                 {-0.11, -0.04, -0.01}, {0.12, 0.04, 0.13}, 0.002),
                          among({box_at({0.08, 0, 0.0285}, {0.06, 0.12, 0.057})}, 40)));
  }
  {
    // Lying on its handle: the body floats.
    const Pose pose = with_axis({0, 0, 0}, Vector3d::UnitX());
    made.push_back(object("pitcher_on_handle",
                          resting(
                              [pose](const Vector3d& p) {
                                const Vector3d q = pose(p);  // the handle is below
                                return jug(q, 0.055, 0.16, 0.04);
                              },
                              {-0.01, -0.06, -0.11}, {0.17, 0.06, 0.11}, 0.002),
                          from(30)));
  }
  made.push_back(object("ring",
                        meshed(
                            [](const Vector3d& p) {
                              return torus(p, {0, 0, 0.012}, Vector3d::UnitZ(), 0.05, 0.012);
                            },
                            {-0.065, -0.065, 0}, {0.065, 0.065, 0.024}, 0.0015),
                        from(55)));
  made.push_back(object(
      "hammer",
      meshed(
          [](const Vector3d& p) {
            const double shaft = cone_segment(p, {-0.15, 0, 0.014}, {0.1, 0, 0.014}, 0.014, 0.011);
            const double head = rounded_box(p, {0.11, 0, 0.0145}, {0.03, 0.11, 0.029}, 0.004);
            return std::min(shaft, head);
          },
          {-0.17, -0.06, 0}, {0.13, 0.06, 0.03}, 0.002),
      from(60)));
  made.push_back(object(
      "airplane",
      resting(
          [](const Vector3d& p) {
            const double fuselage =
                cone_segment(p, {-0.08, 0, 0.03}, {0.07, 0, 0.03}, 0.012, 0.022);
            const double wings = rounded_box(p, {0.02, 0, 0.028}, {0.045, 0.2, 0.008}, 0.003);
            const double tail = rounded_box(p, {-0.075, 0, 0.055}, {0.03, 0.008, 0.05}, 0.003);
            const double plane = rounded_box(p, {-0.075, 0, 0.035}, {0.03, 0.08, 0.007}, 0.003);
            return std::min({fuselage, wings, tail, plane});
          },
          {-0.1, -0.11, 0}, {0.1, 0.11, 0.085}, 0.002),
      from(45)));
  made.push_back(object("vase",
                        turned({{0, 0},
                                {0.03, 0},
                                {0.036, 0.05},
                                {0.018, 0.16},
                                {0.028, 0.24},
                                {0.025, 0.24},
                                {0.014, 0.16},
                                {0.032, 0.05},
                                {0.027, 0.004},
                                {0, 0.004}}),
                        from(20)));
  made.push_back(object("upper_of_two", box_at({0, 0, 0.1}, {0.07, 0.11, 0.06}),
                        among({box_at({0, 0, 0.035}, {0.1, 0.15, 0.07})}, 35)));
  made.push_back(object("top_of_three", box_at({0.005, 0, 0.115}, {0.09, 0.06, 0.05}),
                        among({box_at({0, 0, 0.02}, {0.14, 0.1, 0.04}),
                               box_at({-0.005, 0.005, 0.065}, {0.1, 0.09, 0.05})},
                              30, kLight)));
  made.push_back(object("behind_a_board", box_at({0, 0, 0.05}, {0.08, 0.15, 0.1}),
                        among({box_at({0.1, -0.055, 0.045}, {0.02, 0.06, 0.09})}, 25)));
  {
    Viewing cut = from(40);
    cut.look_aside = {0.85, 0};
    made.push_back(object("cut_box", box_at({0, 0, 0.06}, {0.09, 0.14, 0.12}), cut));
  }
  made.push_back(object("die", box_at({0, 0, 0.008}, {0.016, 0.016, 0.016}, 0.0005), from(60)));
  {
    Viewing far = from(45);
    far.distance = 1.3;
    made.push_back(object("crate", box_at({0, 0, 0.11}, {0.4, 0.28, 0.22}, 0.005), far));
  }
  {
    Viewing dark = from(45, kLight);
    dark.missing = 0.4;
    made.push_back(object("dark_flask", turned(kFlask), dark));
  }
  made.push_back(object("one_of_two_pushed", box_at({0, 0, 0.045}, {0.06, 0.1, 0.09}),
                        among({box_at({0.005, 0.105, 0.05}, {0.07, 0.1, 0.1})}, 40)));
  return made;
}

std::vector<EvaluationObject> held_out_objects() {
  std::vector<EvaluationObject> made;
  made.push_back(object("salad_bowl",
                        turned({{0, 0},
                                {0.05, 0},
                                {0.09, 0.02},
                                {0.115, 0.06},
                                {0.11, 0.06},
                                {0.086, 0.025},
                                {0.048, 0.006},
                                {0, 0.006}}),
                        from(25)));
  made.push_back(
      object("saucer",
             turned({{0, 0}, {0.04, 0}, {0.075, 0.014}, {0.074, 0.018}, {0.04, 0.005}, {0, 0.005}}),
             from(60)));
  made.push_back(object(
      "pan",
      meshed(
          [](const Vector3d& p) {
            const double body = revolution(p, vessel(0.075, 0.095, 0.045, 0.004));
            const double handle = cone_segment(p, {0.09, 0, 0.038}, {0.22, 0, 0.055}, 0.009, 0.01);
            return std::min(body, handle);
          },
          {-0.1, -0.1, 0}, {0.235, 0.1, 0.07}, 0.002),
      from(45, kLight)));
  made.push_back(object("bucket",
                        meshed(
                            [](const Vector3d& p) {
                              const double body = revolution(p, vessel(0.05, 0.07, 0.11, 0.004));
                              const double bail =
                                  std::max(torus(p, {0, 0, 0.1}, Vector3d::UnitX(), 0.066, 0.004),
                                           0.1 - p.z());
                              return std::min(body, bail);
                            },
                            {-0.075, -0.075, 0}, {0.075, 0.075, 0.175}, 0.002),
                        from(35)));
  {
    const double lean = 55 * kDegree;
    const Pose pose =
        with_axis({-0.045, 0, 0.031 * std::cos(lean)}, {std::cos(lean), 0, std::sin(lean)});
    const std::vector<Vector2d> can = {{0, 0},         {0.031, 0},    {0.033, 0.002},
                                       {0.033, 0.108}, {0.031, 0.11}, {0, 0.11}};
    made.push_back(object("can_leaning",
                          meshed([&](const Vector3d& p) { return revolution(pose(p), can); },
                                 {-0.09, -0.04, -0.01}, {0.06, 0.04, 0.14}, 0.002),
                          among({box_at({0.065, 0, 0.04}, {0.04, 0.16, 0.08})}, 45)));
  }
  {
    Pose pose{Vector3d::Zero(), Eigen::Matrix3d()};
    pose.R << 0, -1, 0, 0, 0, 1, -1, 0, 0;  // the handle is below, the mouth in +y
    made.push_back(
        object("mug_on_handle",
               resting([pose](const Vector3d& p) { return jug(pose(p), 0.042, 0.1, 0.026); },
                       {-0.08, -0.01, -0.08}, {0.08, 0.11, 0.08}, 0.0015),
               from(50)));
  }
  made.push_back(object("hoop_on_edge",
                        resting(
                            [](const Vector3d& p) {
                              return torus(p, {0, 0, 0.07}, Vector3d::UnitX(), 0.055, 0.01);
                            },
                            {-0.012, -0.07, 0}, {0.012, 0.07, 0.14}, 0.0015),
                        among({box_at({-0.035, 0, 0.03}, {0.05, 0.05, 0.06})}, 35)));
  made.push_back(object(
      "wrench",
      resting(
          [](const Vector3d& p) {
            const double shaft = rounded_box(p, {0, 0, 0.006}, {0.16, 0.02, 0.012}, 0.003);
            const double head = rounded_box(p, {0.095, 0, 0.007}, {0.05, 0.05, 0.014}, 0.003);
            const double jaw = rounded_box(p, {0.115, 0, 0.007}, {0.035, 0.022, 0.05}, 0.002);
            const double ring = torus(p, {-0.095, 0, 0.007}, Vector3d::UnitZ(), 0.016, 0.007);
            return std::min({shaft, std::max(head, -jaw), ring});
          },
          {-0.125, -0.03, 0}, {0.125, 0.03, 0.016}, 0.0015),
      from(70)));
  made.push_back(object(
      "dragonfly",
      resting(
          [](const Vector3d& p) {
            const double body = cone_segment(p, {-0.09, 0, 0.02}, {0.05, 0, 0.026}, 0.007, 0.015);
            const double head = ellipsoid(p, {0.07, 0, 0.03}, {0.018, 0.02, 0.018});
            const double fore = rounded_box(p, {0.035, 0, 0.034}, {0.03, 0.18, 0.007}, 0.003);
            const double hind = rounded_box(p, {-0.005, 0, 0.032}, {0.028, 0.15, 0.007}, 0.003);
            return std::min({body, head, fore, hind});
          },
          {-0.1, -0.1, 0}, {0.1, 0.1, 0.06}, 0.0015),
      from(40, kLight)));
  made.push_back(object("flute_vase",
                        turned({{0, 0},
                                {0.034, 0},
                                {0.034, 0.008},
                                {0.012, 0.02},
                                {0.014, 0.1},
                                {0.03, 0.21},
                                {0.027, 0.21},
                                {0.011, 0.1},
                                {0.009, 0.03},
                                {0, 0.03}}),
                        from(15)));
  made.push_back(object("upper_overhanging",
                        box_at({0.015, 0.01, 0.13}, {0.1, 0.07, 0.05}, 0.002, 20 * kDegree),
                        among({box_at({0, 0, 0.0525}, {0.08, 0.08, 0.105})}, 45, kLight)));
  made.push_back(object(
      "top_of_four", box_at({0, 0.004, 0.14}, {0.07, 0.07, 0.04}),
      among({box_at({0, 0, 0.015}, {0.12, 0.12, 0.03}), box_at({0.004, 0, 0.05}, {0.11, 0.1, 0.04}),
             box_at({0, 0, 0.095}, {0.09, 0.08, 0.05})},
            25)));
  {
    const Mesh can = turned({{0, 0}, {0.028, 0}, {0.03, 0.002}, {0.03, 0.1}, {0, 0.1}}, 0.002);
    TriangleMesh before = *can;
    for (Vector3d& v : before.vertices) v += Vector3d(0.1, 0.035, 0);
    made.push_back(object("behind_a_can",
                          box_at({0, 0, 0.06}, {0.06, 0.13, 0.12}, 0.002, 15 * kDegree),
                          among({std::make_shared<TriangleMesh>(std::move(before))}, 30)));
  }
  {
    Viewing cut = from(35);
    cut.look_aside = {0, -0.8};
    made.push_back(object("cut_flask", turned(kFlask), cut));
  }
  made.push_back(object("nut",
                        meshed(
                            [](const Vector3d& p) {
                              const double hexagon =
                                  std::max({std::abs(p.x()), std::abs(p.x() / 2 + p.y() * 0.866),
                                            std::abs(p.x() / 2 - p.y() * 0.866)}) -
                                  0.0075;
                              return std::max({hexagon, std::abs(p.z() - 0.0045) - 0.0045,
                                               0.0035 - std::hypot(p.x(), p.y())});
                            },
                            {-0.01, -0.01, 0}, {0.01, 0.01, 0.009}, 0.0004),
                        from(65)));
  {
    Viewing far = from(35, kLight);
    far.distance = 1.6;
    made.push_back(object("carton", box_at({0, 0, 0.15}, {0.6, 0.35, 0.3}, 0.006), far));
  }
  {
    Viewing shiny = from(50, kLight);
    shiny.missing = 0.5;
    made.push_back(object(
        "shiny_can", turned({{0, 0}, {0.033, 0}, {0.035, 0.002}, {0.035, 0.12}, {0, 0.12}}, 0.002),
        shiny));
  }
  made.push_back(object("book_among_books", box_at({0, 0, 0.07}, {0.12, 0.03, 0.14}),
                        among({box_at({-0.005, 0.0325, 0.06}, {0.1, 0.025, 0.12}),
                               box_at({0.003, -0.04, 0.075}, {0.13, 0.04, 0.15})},
                              40)));
  return made;
}

}  // namespace prehend::eval
