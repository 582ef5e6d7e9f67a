#include "eval/grasp/dexgrasp_hand.h"

#include <iterator>
#include <utility>

#include "prehend/surface/convex_pieces.h"

namespace prehend::eval {
namespace {

using geometry::TriangleMesh;
using simulation::RobotBodies;
using simulation::engines::EngineShape;

constexpr int kRound = 24;            // segments of what is round
constexpr double kConcavity = 0.003;  // m, of a link that may be filled

robot::HandModel with_friction(robot::HandModel hand, double friction) {
  hand.friction = friction;
  return hand;
}

robot::HandModel with_motors(robot::HandModel hand) {
  for (const robot::Breakaway& breakaway : hand.breakaways) {
    hand.model.joints[static_cast<std::size_t>(breakaway.joint)].mimic.reset();
    hand.actuated.push_back(breakaway.joint);
  }
  hand.breakaways.clear();
  return hand;
}

// Engines' own contacts know no foam: a pad's face is where the link begins.
RobotBodies bodies_of(robot::HandModel hand) {
  hand.pads.clear();
  const auto joints = static_cast<Eigen::Index>(hand.model.joints.size());
  return simulation::make_robot_bodies(hand.model, hand, "", geometry::RigidTransform::Identity(),
                                       Eigen::VectorXd::Zero(joints));
}

std::vector<TriangleMesh> pieces_of_part(const RobotBodies::Part& part) {
  if (part.solid) {
    surface::ConvexPiecesOptions options;
    options.concavity = kConcavity;
    return surface::convex_pieces(*part.solid, options).pieces;
  }
  const EngineShape& shape = part.shape;
  if (shape.kind == EngineShape::Kind::kBox) return {geometry::make_box(shape.size)};
  if (shape.kind == EngineShape::Kind::kSphere) {
    return {geometry::make_sphere(shape.radius, kRound)};
  }
  const double half = 0.5 * shape.length;
  return {geometry::make_revolution({{shape.radius, -half}, {shape.radius, half}}, kRound)};
}

}  // namespace

DexHand::DexHand(robot::HandModel hand, double friction)
    : model(with_friction(std::move(hand), friction)),
      freed(with_motors(model)),
      to_close(model),
      bodies(bodies_of(model)),
      pieces_B(bodies.bodies.size()) {
  for (const RobotBodies::Part& part : bodies.parts) {
    for (const TriangleMesh& piece : pieces_of_part(part)) {
      pieces_B[static_cast<std::size_t>(part.body)].push_back(
          geometry::transformed(piece, part.X_BS));
    }
  }
}

}  // namespace prehend::eval
