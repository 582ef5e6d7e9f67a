#include "nodes/grasp_cycle/arm_grasps.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "nodes/grasp_cycle/arm_ports.h"
#include "prehend/geometry/errors.h"

namespace prehend::nodes {
namespace {

constexpr double kLeastWay = 1e-3;  // rad, of a joint that closes

template <class Values>
Eigen::VectorXd vector_of(const Values& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

robot::ClosingWay closing_way_of(const msgs::Grasp& grasp) {
  robot::ClosingWay way;
  way.open = vector_of(grasp.open_position());
  way.closed = vector_of(grasp.closed_position());
  if (grasp.closing_rate_size() > 0) {
    way.rate = vector_of(grasp.closing_rate());
    way.lower = vector_of(grasp.least_position());
    way.upper = vector_of(grasp.largest_position());
    return way;
  }
  const double infinity = std::numeric_limits<double>::infinity();
  way.rate = (way.closed - way.open).unaryExpr([](double closes) {
    return std::abs(closes) > kLeastWay ? std::copysign(1.0, closes) : 0.0;
  });
  way.lower = Eigen::VectorXd::Constant(way.closed.size(), -infinity);
  way.upper = Eigen::VectorXd::Constant(way.closed.size(), infinity);
  return way;
}

}  // namespace

bool is_executable(const msgs::Grasp& grasp) {
  return grasp.arm_size() > 0 && grasp.hand_joint_name_size() > 0 &&
         grasp.open_position_size() == grasp.hand_joint_name_size() &&
         grasp.closed_position_size() == grasp.hand_joint_name_size();
}

control::ArmGrasp from_message(const msgs::Grasp& grasp) {
  control::ArmGrasp result;
  result.pose = {convert::from_message(grasp.x_wg()), grasp.preshape()};
  for (const msgs::ArmSegment& segment : grasp.arm()) {
    result.segments.emplace_back(segment.name(), from_message(segment.trajectory()));
  }
  result.hand_joints.assign(grasp.hand_joint_name().begin(), grasp.hand_joint_name().end());
  result.hand = closing_way_of(grasp);
  try {
    result.hand.validate();
  } catch (const std::invalid_argument& error) {
    throw geometry::InputError(
        std::string("A grasp of which the hand cannot close: ") + error.what(),
        "Look for the fault in the node that published it");
  }
  result.lifted_mass = grasp.predicted().lifted_mass();
  result.score = grasp.score();
  result.robustness = grasp.has_robustness() ? grasp.robustness() : -1;
  return result;
}

std::string destination(const msgs::Grasp& grasp) {
  if (!grasp.has_move()) return "only lifted";
  const double away = convert::from_message(grasp.move()).norm();
  return away > 0 ? fmt::format("put {:.2f} m away", away)
                  : std::string("put back where it stands: there is no free place that is reached");
}

}  // namespace prehend::nodes
