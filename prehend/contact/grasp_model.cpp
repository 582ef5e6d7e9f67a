#include "prehend/contact/grasp_model.h"

#include <cmath>

#include <Eigen/Eigenvalues>

#include "prehend/contact/require.h"
#include "prehend/contact/texel.h"

namespace prehend::contact {
namespace {

void validate_slide(const SlideModel& slide, const std::string& owner) {
  require_positive(slide.mass, owner + "mass");
  require(std::isfinite(slide.start), owner + "start", "finite");
  require_not_negative(slide.static_friction, owner + "static_friction");
  require_not_negative(slide.dynamic_friction, owner + "dynamic_friction");
  require(slide.dynamic_friction <= slide.static_friction, owner + "dynamic_friction",
          "at most static_friction");
  require_not_negative(slide.viscous_friction, owner + "viscous_friction");
  require_positive(slide.stribeck_velocity, owner + "stribeck_velocity");
  require_positive(slide.bristle_stiffness, owner + "bristle_stiffness");
}

}  // namespace

Eigen::Matrix3d box_inertia(double mass, const Eigen::Vector3d& size) {
  const Eigen::Vector3d s = size.cwiseAbs2();
  return (mass / 12 * Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y())).asDiagonal();
}

GroundModel stiff_ground(double mass, double friction, std::vector<Eigen::Vector3d> points_B) {
  GroundModel ground;
  ground.law.stiffness = 1e5;
  ground.law.damping =
      std::sqrt(1e5 * mass / std::max<double>(1, static_cast<double>(points_B.size())));
  ground.law.bristle_stiffness = 1e5;
  ground.law.bristle_damping = 0;
  ground.law.static_friction = ground.law.dynamic_friction = friction;
  ground.law.bristle_law = BristleLaw::kElastoPlastic;
  ground.law.return_map = true;
  ground.points_B = std::move(points_B);
  return ground;
}

geometry::RigidTransform GripperMotion::pose_at(double t) const {
  const double s = t - time;
  geometry::RigidTransform X = X_WG;
  X.translation() += s * velocity + 0.5 * s * s * acceleration;
  const double rate = angular_velocity.norm();
  if (rate > 0) {
    X.linear() =
        Eigen::AngleAxisd(s * rate, angular_velocity / rate).toRotationMatrix() * X.linear();
  }
  return X;
}

void validate(const GraspModel& model) {
  require(model.gravity.allFinite(), "GraspModel::gravity", "finite");
  require_positive(model.mass, "GraspModel::mass");
  require(model.inertia.allFinite() && model.inertia.isApprox(model.inertia.transpose(), 1e-9),
          "GraspModel::inertia", "finite and symmetric");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> inertia(model.inertia,
                                                               Eigen::EigenvaluesOnly);
  require(inertia.eigenvalues()[0] > 0, "GraspModel::inertia", "positive definite");
  require(model.X_WB.matrix().allFinite(), "GraspModel::X_WB", "finite");
  require(model.slides.size() <= GraspModel::kMostSlides, "GraspModel::slides", "at most 6");
  for (std::size_t i = 0; i < model.slides.size(); ++i) {
    validate_slide(model.slides[i], "GraspModel::slides[" + std::to_string(i) + "].");
  }
  for (std::size_t i = 0; i < model.pads.size(); ++i) {
    const std::string owner = "GraspModel::pads[" + std::to_string(i) + "].";
    const PadMount& pad = model.pads[i];
    validate(pad.law);
    require(pad.X_GP.matrix().allFinite(), owner + "X_GP", "finite");
    require(pad.slide >= -1 && pad.slide < static_cast<int>(model.slides.size()), owner + "slide",
            "-1 or the index of a slide");
    require(pad.direction_G.allFinite(), owner + "direction_G", "finite");
  }
  if (!model.ground) return;
  validate(model.ground->law);
  for (const Eigen::Vector3d& p : model.ground->points_B) {
    require(p.allFinite(), "GraspModel::ground.points_B", "finite");
  }
}

void validate(const SlideCommand& command) {
  require(std::isfinite(command.force), "SlideCommand::force", "finite");
  require_not_negative(command.stiffness, "SlideCommand::stiffness");
  require(std::isfinite(command.reference), "SlideCommand::reference", "finite");
  require_not_negative(command.damping, "SlideCommand::damping");
  require(std::isfinite(command.speed), "SlideCommand::speed", "finite");
  require(command.limit >= 0, "SlideCommand::limit", "not negative");
  require_not_negative(command.more_friction, "SlideCommand::more_friction");
}

}  // namespace prehend::contact
