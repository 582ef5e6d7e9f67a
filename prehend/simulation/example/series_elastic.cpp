// An actuator in a shared library: a motor that holds its position whatever its load, and a spring
// between it and the joint (Pratt and Williamson, "Series elastic actuators", IROS 1995).

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "prehend/simulation/actuator.h"

namespace {

using namespace prehend::simulation;
using prehend::contact::SlideCommand;
using prehend::robot::JointMode;

class SeriesElastic final : public Actuator {
 public:
  std::string name() const override { return "series_elastic"; }
  std::string about() const override { return "a stiff motor with a spring to the joint"; }
  std::vector<ActuatorParameter> parameters() const override {
    return {{"stiffness", "N m/rad or N/m", "of the spring", {}},
            {"damping", "N m s/rad or N s/m", "of the spring", 0.0}};
  }
  void configure(const ActuatedJoint& joint, const std::vector<double>& values) override {
    joint_ = joint;
    stiffness_ = values[0];
    damping_ = values[1];
    if (!(stiffness_ > 0)) throw std::invalid_argument("stiffness must be positive");
    if (!(damping_ >= 0)) throw std::invalid_argument("damping must not be negative");
  }
  bool takes(JointMode mode) const override { return mode != JointMode::kVoltage; }
  ActuatorMechanics mechanics() const override { return {.stiffness = stiffness_}; }

  // The motor's position, where the spring is relaxed.
  std::vector<double> initial_state(double position) const override { return {position}; }

  SlideCommand drive(const ActuatorRequest& request, double h, const JointMotion& start,
                     std::span<double> state) const override {
    const double wanted = request.mode == JointMode::kEffort
                              ? start.position + request.value / stiffness_
                              : request.value;
    const double way = joint_.max_velocity * h;
    state[0] += std::clamp(wanted - state[0], -way, way);
    // The spring takes no more than the motor can hold.
    const double most = request.most_effort / stiffness_;
    state[0] = std::clamp(state[0], start.position - most, start.position + most);
    return {.stiffness = stiffness_,
            .reference = state[0],
            .damping = damping_,
            .limit = request.most_effort};
  }
  void observe(double, const JointMotion&, double, std::span<double>) const override {}
  double current(std::span<const double>) const override {
    return std::numeric_limits<double>::quiet_NaN();
  }

 private:
  ActuatedJoint joint_;
  double stiffness_ = 1, damping_ = 0;
};

}  // namespace

extern "C" {

int prehend_actuator_interface() { return kActuatorInterface; }

Actuator* prehend_create_actuator() { return new SeriesElastic; }
}
