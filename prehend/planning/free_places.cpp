#include "prehend/planning/free_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

constexpr std::size_t kSides = 64;    // directions in which outlines are compared
constexpr double kSamePlace = 0.02;   // m
constexpr double kRegionStep = 0.04;  // m
constexpr double kEdge = 0.03;        // m: what is put nearer to a region's edge may be beside it
constexpr double kStands = 0.01;      // m, over the table: so far a predicted bottom may be off
constexpr double kUpright = 0.1;      // of a normal's z: below, the table says nothing of x and y
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Sides = std::array<Eigen::Vector2d, kSides>;

const Sides& sides() {
  static const Sides all = [] {
    Sides made;
    for (std::size_t i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kSides;
      made[i] = {std::cos(angle), std::sin(angle)};
    }
    return made;
  }();
  return all;
}

/// Axes of the table in the world: y along the world's as far as the table allows.
struct TableAxes {
  Eigen::Vector3d x, y, up;

  explicit TableAxes(const Eigen::Vector3d& normal) : up(normal) {
    Eigen::Vector3d along = Eigen::Vector3d::UnitY() - normal.y() * normal;
    if (along.norm() < 1e-3) along = Eigen::Vector3d::UnitX() - normal.x() * normal;
    y = along.normalized();
    x = y.cross(up);
  }
  Eigen::Vector2d flat(const Eigen::Vector3d& p) const { return {x.dot(p), y.dot(p)}; }
  Eigen::Vector3d in_world(const Eigen::Vector2d& p) const { return p.x() * x + p.y() * y; }
};

/// The convex outline on the table: how far it reaches in each direction of sides().
struct Outline {
  std::array<double, kSides> reach;
  Eigen::AlignedBox2d box;

  Outline() { reach.fill(-kInfinity); }
  void add(const Eigen::Vector2d& p) {
    box.extend(p);
    for (std::size_t i = 0; i < kSides; ++i) reach[i] = std::max(reach[i], sides()[i].dot(p));
  }
};

Outline outline_of(const std::vector<Eigen::Vector3d>& points, const TableAxes& axes) {
  Outline outline;
  for (const Eigen::Vector3d& p : points) outline.add(axes.flat(p));
  return outline;
}

/// Distance of `object`, moved by `move`, to `other`.
double room(const Outline& object, const Eigen::Vector2d& move, const Outline& other) {
  double most = -kInfinity;
  for (std::size_t i = 0; i < kSides; ++i) {
    const double reach = object.reach[i] + sides()[i].dot(move);
    most = std::max(most, -other.reach[(i + kSides / 2) % kSides] - reach);
  }
  return most;
}

class Chooser {
 public:
  Chooser(const geometry::Plane& table, const std::vector<Eigen::Vector3d>& object_W,
          const std::vector<std::vector<Eigen::Vector3d>>& others_W, const PlaceOptions& options)
      : axes_(table.normal), options_(options), stands_(outline_of(object_W, axes_)) {
    for (const auto& points : others_W) {
      if (!points.empty()) others_.push_back(outline_of(points, axes_));
    }
    double lowest = kInfinity;  // m, over the table
    for (const Eigen::Vector3d& p : object_W) lowest = std::min(lowest, table.signed_distance(p));
    if (lowest > kStands) down_W_ = -lowest * table.normal;
    middle_W_ = options.middle_W && std::abs(table.normal.z()) >= kUpright
                    ? on_table(table, *options.middle_W)
                    : axes_.in_world(stands_.box.center()) + table.offset * table.normal;
  }

  FreePlaces given(const geometry::Plane& table) const {
    FreePlaces places;
    const Eigen::Vector2d& at = *options_.given_W;
    const std::string name = fmt::format("the place {:.3f}, {:.3f}", at.x(), at.y());
    if (std::abs(table.normal.z()) < kUpright) {
      places.problem = name + " says nothing on a table that stands upright";
      return places;
    }
    const Eigen::Vector3d move_W = on_table(table, at) - middle_W_;
    if (move_W.norm() < kSamePlace) {
      places.problem = "the object stands at " + name + " already";
      return places;
    }
    std::size_t nearest = 0;
    if (room_at(axes_.flat(move_W), &nearest) < options_.clearance) {
      const Eigen::Vector3d other =
          axes_.in_world(others_[nearest].box.center()) + table.offset * table.normal;
      places.problem = fmt::format("{} is occupied by what stands at {:.3f}, {:.3f}", name,
                                   other.x(), other.y());
      return places;
    }
    if (const std::string why = unreachable(move_W); !why.empty()) {
      places.problem = name + " cannot be reached: " + why;
      return places;
    }
    places.moves_W = {move_W + down_W_};
    return places;
  }

  FreePlaces chosen() const {
    Choice choice;
    for (int ring = 0;; ++ring) {
      const double distance = options_.distance + ring * options_.step;
      if (distance > options_.farthest + 1e-9) break;
      for (int i = 0; i < options_.directions; ++i) {
        const double angle = std::numbers::pi * (0.5 + 2.0 * i / options_.directions);
        consider(axes_.in_world(distance * Eigen::Vector2d(std::cos(angle), std::sin(angle))),
                 choice);
      }
    }
    FreePlaces places;
    places.moves_W = choice.ordered();
    places.moves_W.push_back(Eigen::Vector3d::Zero());
    return places;
  }

  // The middle first, then rings of squares round it.
  FreePlaces in_region(const geometry::Plane& table) const {
    const PlaceOptions::Region& region = *options_.region_W;
    FreePlaces places;
    if (std::abs(table.normal.z()) < kUpright) {
      places.problem =
          "the place '" + region.name + "' says nothing on a table that stands upright";
      return places;
    }
    const Eigen::Array2i most = (0.5 * region.size / kRegionStep).array().floor().cast<int>();
    Choice choice;
    for (int ring = 0; ring <= most.maxCoeff(); ++ring) {
      for (int i = -std::min(ring, most.x()); i <= std::min(ring, most.x()); ++i) {
        for (int j = -std::min(ring, most.y()); j <= std::min(ring, most.y()); ++j) {
          if (std::max(std::abs(i), std::abs(j)) != ring) continue;
          const Eigen::Vector2d aside = kRegionStep * Eigen::Vector2d(i, j);
          const double inside = (0.5 * region.size - aside.cwiseAbs()).minCoeff();
          consider(on_table(table, region.center + aside) - middle_W_, choice, inside < kEdge);
        }
      }
    }
    places.moves_W = choice.ordered();
    if (!places.moves_W.empty()) return places;
    places.problem = fmt::format("the place '{}' at {:.3f}, {:.3f} is full{}", region.name,
                                 region.center.x(), region.center.y(),
                                 choice.why.empty() ? "" : ", or cannot be reached: " + choice.why);
    return places;
  }

 private:
  struct Choice {
    struct Found {
      Eigen::Vector3d move_W;
      double room = 0;
    };
    std::vector<Found> roomy, narrow, at_edge;
    std::string why;  // of a place with room that cannot be reached

    std::vector<Eigen::Vector3d> ordered() {
      const auto has_more_room = [](const Found& a, const Found& b) { return a.room > b.room; };
      std::stable_sort(narrow.begin(), narrow.end(), has_more_room);
      std::stable_sort(at_edge.begin(), at_edge.end(), has_more_room);
      std::vector<Eigen::Vector3d> moves_W;
      for (const auto* all : {&roomy, &narrow, &at_edge}) {
        for (const Found& found : *all) moves_W.push_back(found.move_W);
      }
      return moves_W;
    }
  };

  void consider(const Eigen::Vector3d& move_W, Choice& choice, bool is_at_edge = false) const {
    const double found = room_at(axes_.flat(move_W), nullptr);
    if (found < options_.clearance) return;
    if (const std::string why = unreachable(move_W); !why.empty()) {
      choice.why = why;
      return;
    }
    auto& list =
        is_at_edge ? choice.at_edge : (found >= options_.enough ? choice.roomy : choice.narrow);
    list.push_back({move_W + down_W_, found});
  }

  /// Straight up or down to the table.
  static Eigen::Vector3d on_table(const geometry::Plane& table, const Eigen::Vector2d& at) {
    const double z = (table.offset - table.normal.head<2>().dot(at)) / table.normal.z();
    return {at.x(), at.y(), z};
  }

  double room_at(const Eigen::Vector2d& move, std::size_t* nearest) const {
    double least = kInfinity;
    for (std::size_t i = 0; i < others_.size(); ++i) {
      const double found = room(stands_, move, others_[i]);
      if (found >= least) continue;
      least = found;
      if (nearest) *nearest = i;
    }
    return least;
  }
  std::string unreachable(const Eigen::Vector3d& move_W) const {
    return options_.unreachable ? options_.unreachable(move_W) : std::string();
  }

  TableAxes axes_;
  const PlaceOptions& options_;
  Outline stands_;  // the object
  std::vector<Outline> others_;
  Eigen::Vector3d middle_W_ = Eigen::Vector3d::Zero();  // on the table
  Eigen::Vector3d down_W_ = Eigen::Vector3d::Zero();    // m, to the table, of what stands higher
};

}  // namespace

void PlaceOptions::validate() const {
  const text::Require require{"PlaceOptions."};
  require(distance > 0 && std::isfinite(distance), "distance must be positive");
  require(farthest >= distance && std::isfinite(farthest), "farthest must be at least distance");
  require(step > 0, "step must be positive");
  require(directions > 0, "directions must be positive");
  require(clearance >= 0, "clearance must not be negative");
  require(enough >= clearance, "enough must be at least clearance");
  require(!given_W || given_W->allFinite(), "given_W must be finite");
  require(!middle_W || middle_W->allFinite(), "middle_W must be finite");
  require(!region_W || (!given_W && region_W->center.allFinite() && region_W->size.allFinite() &&
                        region_W->size.minCoeff() > 0),
          "region_W must be finite, with positive sides, and no given_W");
}

FreePlaces free_places(const geometry::Plane& table_W, const std::vector<Eigen::Vector3d>& object_W,
                       const std::vector<std::vector<Eigen::Vector3d>>& others_W,
                       const PlaceOptions& options) {
  options.validate();
  if (object_W.empty()) throw std::invalid_argument("free_places: the object has no points");
  const Chooser chooser(table_W, object_W, others_W, options);
  if (options.given_W) return chooser.given(table_W);
  return options.region_W ? chooser.in_region(table_W) : chooser.chosen();
}

std::optional<Eigen::Vector2d> read_place(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const std::size_t comma = text.find(',');
  const auto number = [](const std::string& part, double& value) {
    std::size_t end = 0;
    try {
      value = std::stod(part, &end);
    } catch (const std::exception&) {
      return false;
    }
    return part.find_first_not_of(' ', end) == std::string::npos && std::isfinite(value);
  };
  Eigen::Vector2d place;
  if (comma == std::string::npos || !number(text.substr(0, comma), place.x()) ||
      !number(text.substr(comma + 1), place.y())) {
    throw geometry::InputError("'" + text + "' is no place",
                               "Give x,y on the table in metres, as place:=0.1,-0.2");
  }
  return place;
}

}  // namespace prehend::planning
