#include "prehend/belief/attempt_memory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/belief/points_beside.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/known/registration.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/shape_cloud.h"
#include "prehend/surface/vertex_origin.h"
#include "prehend/text/require.h"

namespace prehend::belief {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

constexpr double kLeastAlternative = 0.1;  // weight of a shape that grasps are tried on, too
constexpr double kOnTable = 0.002;         // m over it: what is touched lower is the table
constexpr std::size_t kMostAlternatives = 2;
constexpr float kTouchedConfidence = 0.95F;
constexpr std::size_t kMostObjects = 16;
constexpr std::size_t kMostLoads = 32;  // of an object
constexpr int kSamples = 1000;          // of a surface

Contact moved_contact(Contact contact, const RigidTransform& X) {
  contact.p_W = X * contact.p_W;
  contact.normal_W = X.linear() * contact.normal_W;
  return contact;
}

Attempt moved_attempt(Attempt attempt, const RigidTransform& X) {
  for (Act& act : attempt) {
    for (HandSample& sample : act.free_way) sample.X_WH = X * sample.X_WH;
    for (Contact& contact : act.contacts) contact = moved_contact(contact, X);
  }
  return attempt;
}

/// Drops the contacts that are with something else.
void keep_own(const geometry::Plane& table_W, const geometry::TriangleMesh& believed_W,
              const std::vector<geometry::TriangleMesh>& neighbours_W, Attempt* attempt) {
  const geometry::MeshQuery own(believed_W);
  const std::vector<geometry::MeshQuery> others(neighbours_W.begin(), neighbours_W.end());
  const auto is_other = [&](const Contact& contact) {
    if (table_W.signed_distance(contact.p_W) < kOnTable) return true;
    const double distance = own.nearest(contact.p_W)->distance;
    return std::any_of(others.begin(), others.end(), [&](const geometry::MeshQuery& other) {
      return other.nearest(contact.p_W)->distance < distance;
    });
  };
  for (Act& act : *attempt) std::erase_if(act.contacts, is_other);
}

void mark_touched(const std::vector<Contact>& contacts, double reach, surface::ObjectModel* model) {
  for (std::size_t v = 0; v < model->mesh_W.vertices.size(); ++v) {
    if (!surface::is_guessed(model->vertex_origin[v])) continue;
    const Vector3d& p = model->mesh_W.vertices[v];
    const bool touched = std::any_of(contacts.begin(), contacts.end(), [&](const Contact& one) {
      return (one.p_W - p).squaredNorm() < reach * reach;
    });
    if (!touched) continue;
    model->vertex_origin[v] = surface::SurfaceOrigin::kTouched;
    model->vertex_confidence[v] = std::max(model->vertex_confidence[v], kTouchedConfidence);
  }
  model->guessed_area = surface::guessed_area(model->mesh_W, model->vertex_origin);
}

}  // namespace

void AttemptMemoryOptions::validate() const {
  belief.validate();
  load.validate();
  const text::Require require{"AttemptMemoryOptions."};
  require(tolerance > 0 && tolerance < 0.1, "tolerance must be above 0, below 0.1 m");
  require(least_explained > 0 && least_explained <= 1,
          "least_explained must be above 0, at most 1");
  require(largest_motion > 0 && largest_motion < 10, "largest_motion must be above 0, below 10 m");
  require(placement >= 0 && placement < 0.1, "placement must be from 0 to 0.1 m");
  require(turn >= 0 && turn < 1, "turn must be from 0 to 1 rad");
  require(seen_deviation > 0 && seen_deviation < 0.1,
          "seen_deviation must be above 0, below 0.1 m");
  require(most_looks_points >= 0, "most_looks_points must not be negative");
  require(probes >= 0, "probes must not be negative");
  probe.validate();
}

AttemptMemory::AttemptMemory(robot::HandModel hand, const AttemptMemoryOptions& options)
    : evidence_(std::move(hand)), options_((options.validate(), options)) {}

geometry::PointCloud AttemptMemory::seen_of(const shape::CompletedShape& shape,
                                            const geometry::Plane& table_W) const {
  const surface::ShapeCloud points = surface::shape_cloud(shape, table_W, options_.model.points());
  std::vector<int> seen;
  for (std::size_t i = 0; i < points.basis.size(); ++i) {
    if (points.basis[i] == surface::SurfaceOrigin::kSeen) seen.push_back(static_cast<int>(i));
  }
  return geometry::select(points.cloud_W, seen);
}

void AttemptMemory::add(Attempt attempt, const shape::CompletedShape& shape,
                        const geometry::Plane& table_W, const geometry::TriangleMesh& believed_W,
                        const std::vector<geometry::TriangleMesh>& neighbours_W) {
  keep_own(table_W, believed_W, neighbours_W, &attempt);
  std::erase_if(attempt,
                [](const Act& act) { return act.free_way.empty() && act.contacts.empty(); });
  if (attempt.empty() || options_.use == EvidenceUse::kNone) return;
  seen_as({seen_of(shape, table_W), shape.seen_space, {std::move(attempt)}}, believed_W);
}

void AttemptMemory::add_look(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                             const geometry::TriangleMesh& believed_W) {
  if (options_.use < EvidenceUse::kLooks) return;
  seen_as({seen_of(shape, table_W), shape.seen_space, {}}, believed_W).stands = true;
}

void AttemptMemory::add_load(const LoadEvidence& load, const shape::CompletedShape& shape,
                             const geometry::Plane& table_W,
                             const geometry::TriangleMesh& believed_W) {
  load_belief({load}, options_.load);  // refuses what is no evidence
  if (load.is_empty() || options_.use == EvidenceUse::kNone) return;
  Look look{seen_of(shape, table_W), shape.seen_space, {}};
  std::vector<LoadEvidence>& loads = seen_as(std::move(look), believed_W).loads;
  if (loads.size() == kMostLoads) loads.erase(loads.begin());
  loads.push_back(load);
}

AttemptMemory::Object& AttemptMemory::seen_as(Look look, const geometry::TriangleMesh& believed_W) {
  const std::optional<Found> known = find(look);
  if (!known) {
    if (objects_.size() == kMostObjects) objects_.erase(objects_.begin());
    objects_.push_back({believed_W, {std::move(look)}, {}, false});
    return objects_.back();
  }
  // recall() has moved it to where this look saw it.
  Object& object = objects_[known->object];
  object.believed_W = believed_W;
  object.stands = false;
  // Of one look, once: what is told of it after an attempt is of the same.
  Look& last = object.looks.back();
  if (last.seen_W.points == look.seen_W.points) {
    for (Attempt& attempt : look.attempts) last.attempts.push_back(std::move(attempt));
  } else {
    object.looks.push_back(std::move(look));
  }
  return object;
}

double AttemptMemory::agreement(const Object& object, const Look& now) const {
  Eigen::AlignedBox3d box = geometry::bounds(object.believed_W);
  box.min().array() -= options_.tolerance;
  box.max().array() += options_.tolerance;
  if (!box.contains(geometry::centroid(now.seen_W))) return 0;
  const auto not_seen_through = [this](const geometry::PointCloud& cloud_W,
                                       const shape::SeenSpace& space) {
    if (space.empty_until.empty() || cloud_W.empty()) return 1.0;
    const RigidTransform X_CW = space.X_WC.inverse(Eigen::Isometry);
    std::size_t kept = 0;
    for (const Eigen::Vector3f& p_W : cloud_W.points) {
      kept += shape::depth_in_empty_space(space, X_CW * p_W.cast<double>()) <= options_.tolerance;
    }
    return static_cast<double>(kept) / static_cast<double>(cloud_W.size());
  };
  const Look& then = object.looks.back();
  return std::min(not_seen_through(then.seen_W, now.seen_space),
                  not_seen_through(now.seen_W, then.seen_space));
}

std::optional<AttemptMemory::Found> AttemptMemory::find(const Look& now) const {
  const geometry::PointCloud& seen_W = now.seen_W;
  std::optional<Found> best;
  grasp::OrientedPoints seen;
  for (std::size_t i = 0; i < seen_W.size(); ++i) {
    seen.points.push_back(seen_W.points[i].cast<double>());
    seen.normals.push_back(seen_W.normals[i].cast<double>());
  }
  const Vector3d center_W = geometry::centroid(seen_W);
  for (std::size_t o = 0; o < objects_.size(); ++o) {
    const Object& object = objects_[o];
    if (object.stands) {
      const double share = agreement(object, now);
      if (share > 0 && (!best || share > best->explained)) {
        best = Found{o, RigidTransform::Identity(), share};
      }
      continue;
    }
    const Vector3d then_W = geometry::centroid(object.looks.back().seen_W);
    if ((then_W - center_W).norm() > options_.largest_motion) continue;
    const geometry::MeshQuery surface(object.believed_W);
    for (const bool shifted : {false, true}) {
      RigidTransform X_then_now = RigidTransform::Identity();
      if (shifted) X_then_now.translation() = then_W - center_W;
      X_then_now = grasp::refined_pose(seen, surface, X_then_now, options_.tolerance);
      const double share =
          grasp::explained_by(seen.points, surface, X_then_now, options_.tolerance).share;
      const RigidTransform X_moved = X_then_now.inverse(Eigen::Isometry);
      if ((X_moved * then_W - then_W).norm() > options_.largest_motion) continue;
      if (best && share <= best->explained) continue;
      best = Found{o, X_moved, share};
    }
  }
  if (best && best->explained < options_.least_explained) return std::nullopt;
  return best;
}

void AttemptMemory::tell(const Object& object, const geometry::PointCloud& seen_W,
                         ObjectBelief* belief) const {
  const Motion registered{options_.placement, options_.turn};
  for (const Look& look : object.looks) {
    belief->begin_act(registered);
    if (options_.use >= EvidenceUse::kLooks) {
      const auto most = static_cast<std::size_t>(options_.most_looks_points);
      for (const std::size_t i : points_beside(look.seen_W, seen_W, most)) {
        const Vector3d p_W = look.seen_W.points[i].cast<double>();
        belief->add(
            {p_W, look.seen_W.normals[i].cast<double>().normalized(), options_.seen_deviation});
      }
      if (!look.seen_space.empty_until.empty()) belief->add_seen_space(look.seen_space);
      // Where it is exactly where it was, what was seen then is its surface as it is now.
      if (look.stood) belief->add_seen(look.seen_W);
    }
    for (const Attempt& attempt : look.attempts) {
      for (const Act& act : attempt) {
        belief->begin_act(act.motion);
        for (const Contact& contact : act.contacts) belief->add(contact);
        if (options_.use >= EvidenceUse::kEmptySpace && !act.free_way.empty()) {
          evidence_.sweep(act.free_way, {}, &belief->swept());
        }
      }
    }
  }
}

std::optional<Recollection> AttemptMemory::recall(const shape::CompletedShape& shape,
                                                  const geometry::Plane& table_W) {
  problem_.clear();
  if (objects_.empty()) return std::nullopt;
  const Look now{seen_of(shape, table_W), shape.seen_space, {}};
  const geometry::PointCloud& seen_W = now.seen_W;
  const std::optional<Found> found = find(now);
  if (!found) {
    problem_ = "nothing that was touched or looked at before looks like it now";
    return std::nullopt;
  }
  Object& object = objects_[found->object];
  const RigidTransform& X = found->X_moved;
  const bool stood = std::exchange(object.stands, false);
  object.believed_W = geometry::transformed(object.believed_W, X);
  for (Look& look : object.looks) {
    look.stood = look.stood && stood;
    look.seen_W = geometry::transformed(look.seen_W, X);
    look.seen_space.X_WC = X * look.seen_space.X_WC;
    for (Attempt& attempt : look.attempts) attempt = moved_attempt(std::move(attempt), X);
  }
  ObjectBelief belief(shape, table_W, options_.belief);
  Recollection result;
  result.before = belief.shapes();
  result.X_moved = X;
  result.explained = found->explained;
  result.looks = static_cast<int>(object.looks.size());
  const geometry::TriangleMesh predicted_W = belief.coarse_mesh();
  tell(object, seen_W, &belief);
  belief.update();
  if (belief.contradicted()) {
    problem_ = fmt::format(
        "what was felt of it contradicts what is seen now ({} contacts): it is forgotten",
        belief.contacts().size());
    objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(found->object));
    return std::nullopt;
  }
  if (options_.probes > 0) result.probes = best_probes(belief, options_.probes, options_.probe);
  LoadBelief load = load_belief(object.loads, options_.load);
  result.load = load.bounds;
  if (!load.contradiction.empty()) {
    result.load_problem = std::move(load.contradiction) + ": it is forgotten";
    object.loads.clear();
  }
  result.after = belief.shapes();
  result.contacts = belief.contacts();
  result.model = surface::model_of_shape(belief.mesh(), shape, options_.model.convex_pieces);
  constexpr double kReach = 2;  // spacings
  mark_touched(result.contacts, kReach * surface::spacing_of(shape.cloud_W), &result.model);
  result.model.shape_weights = {result.after.front().weight};
  for (std::size_t i = 1; i < result.after.size(); ++i) {
    if (result.after[i].weight < kLeastAlternative) break;
    if (result.model.alternatives_W.size() == kMostAlternatives) break;
    try {
      result.model.alternatives_W.push_back(belief.coarse_mesh(i));
      result.model.shape_weights.push_back(result.after[i].weight);
    } catch (const geometry::InputError&) {
      // A shape that gives no mesh is no alternative.
    }
  }
  result.change = surface::deviation(surface::sample_surface(result.model.mesh_W, kSamples, 1),
                                     geometry::MeshQuery(predicted_W))
                      .mean;
  object.believed_W = result.model.mesh_W;
  return result;
}

}  // namespace prehend::belief
