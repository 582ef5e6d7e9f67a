#include "tools/robot_model/model_words.h"

#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

namespace prehend::tools {
namespace {

using namespace robot::formats;
using Kind = JointDescription::Kind;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMillimetres = 1000;

bool turns(const JointDescription& joint) { return joint.kind == Kind::kRevolute; }

}  // namespace

std::string kind_word(Kind kind) {
  switch (kind) {
    case Kind::kFixed:
      return "fixed";
    case Kind::kRevolute:
      return "revolute";
    case Kind::kPrismatic:
      return "prismatic";
    case Kind::kBall:
      return "ball";
    case Kind::kFloating:
      return "floating";
    case Kind::kPlanar:
      return "planar";
  }
  return "";
}

std::string limit_words(const JointDescription& joint) {
  if (joint.kind != Kind::kRevolute && joint.kind != Kind::kPrismatic) return "";
  if (!joint.lower && !joint.upper) return "no limit";
  const double unit = turns(joint) ? kDegrees : kMillimetres;
  const auto text = [&](const std::optional<double>& limit) {
    return limit ? fmt::format("{:.4g}", unit * *limit) : std::string("no limit");
  };
  return text(joint.lower) + " to " + text(joint.upper) + (turns(joint) ? "°" : " mm");
}

std::string effort_words(const JointDescription& joint) {
  if (!joint.effort) return "";
  return fmt::format("{:.4g} {}", *joint.effort, turns(joint) ? "N m" : "N");
}

std::string speed_words(const JointDescription& joint) {
  if (!joint.velocity) return "";
  return turns(joint) ? fmt::format("{:.4g} °/s", kDegrees * *joint.velocity)
                      : fmt::format("{:.4g} mm/s", kMillimetres * *joint.velocity);
}

std::string drag_words(const JointDescription& joint) {
  std::vector<std::string> words;
  if (joint.damping != 0) {
    words.push_back(
        fmt::format("damping {:.4g} {}", joint.damping, turns(joint) ? "N m s/rad" : "N s/m"));
  }
  if (joint.friction != 0) {
    words.push_back(fmt::format("friction {:.4g} {}", joint.friction, turns(joint) ? "N m" : "N"));
  }
  if (joint.stiffness) {
    words.push_back(fmt::format("spring {:.4g} {} from {:.4g}", *joint.stiffness,
                                turns(joint) ? "N m/rad" : "N/m", joint.rest));
  }
  if (joint.break_away) words.push_back(fmt::format("clutch {:.4g} N m", *joint.break_away));
  if (joint.passive) words.emplace_back("no motor");
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string follows_words(const JointDescription& joint) {
  if (!joint.follows) return "";
  const Follows& follows = *joint.follows;
  if (!follows.is_linear()) {
    return fmt::format("{:.4g} of {}", fmt::join(follows.coefficients, ", "), follows.joint);
  }
  return fmt::format("{:.4g} * {}{}", follows.multiplier(), follows.joint,
                     follows.offset() != 0 ? fmt::format(" + {:.4g}", follows.offset()) : "");
}

std::string inertial_words(const LinkDescription& link) {
  if (!link.inertial) return "no mass";
  const Inertial& inertial = *link.inertial;
  const Eigen::Vector3d center = kMillimetres * inertial.X_LI.translation();
  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertial.inertia, Eigen::EigenvaluesOnly)
          .eigenvalues();
  return fmt::format(
      "{:.4g} kg, centre at {:.1f} {:.1f} {:.1f} mm, principal inertias {:.3g} {:.3g} {:.3g} kg m²",
      inertial.mass, center.x(), center.y(), center.z(), principal[0], principal[1], principal[2]);
}

}  // namespace prehend::tools
