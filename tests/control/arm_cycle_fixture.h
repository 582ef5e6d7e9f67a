#pragma once

#include <map>
#include <string>
#include <vector>

#include "prehend/control/arm_cycle.h"

/// An arm of one joint and a hand of one finger that do at once what is asked.
namespace prehend::control {

/// Does at once what is asked; keeps it.
struct FakeArm : ArmPort {
  void follow(const JointTrajectory& path, double contact_force) override {
    asked.push_back(path);
    forces.push_back(contact_force);
    position = path.points.back().position;
  }
  MotionStatus motion() override {
    const auto found = says.find(asked.size());
    return found == says.end() ? MotionStatus::kReached : found->second;
  }
  std::string problem() override { return "the arm's words"; }
  void stop() override { ++stops; }
  std::vector<JointTrajectory> asked;
  std::vector<double> forces;
  std::vector<double> position{0.0};
  std::map<std::size_t, MotionStatus> says;  // of the n-th path
  int stops = 0;
};

struct FakeHand : HandPort {
  void move(const std::vector<std::string>&, const std::vector<double>& positions, double,
            bool until_contact, const std::vector<double>& effort) override {
    efforts.push_back(effort);
    asked.push_back(positions.front());
    last_closes = until_contact;
  }
  MotionStatus motion() override { return last_closes ? closes : opens; }
  std::string problem() override { return "the hand's words"; }
  std::vector<double> positions() override { return {position()}; }
  void stop() override { ++stops; }
  double position() const {
    if (asked.empty()) return 0;
    return last_closes && closes == MotionStatus::kContact ? touches_at : asked.back();
  }
  double touches_at = 0.62;  // rad
  std::vector<double> asked;
  std::vector<std::vector<double>> efforts;
  bool last_closes = false;
  MotionStatus closes = MotionStatus::kContact, opens = MotionStatus::kReached;
  int stops = 0;
};

inline JointTrajectory path(double from, double to) {
  return {{"j"}, {{0, {from}, {0}, {}}, {2, {to}, {0}, {}}}};
}

inline ArmGrasp fake_grasp() {
  ArmGrasp grasp;
  using motion::SegmentKind;
  grasp.segments = {{SegmentKind::kReach, path(0, 1)}, {SegmentKind::kApproach, path(1, 2)},
                    {SegmentKind::kLift, path(2, 3)},  {SegmentKind::kCarry, path(3, 4)},
                    {SegmentKind::kPlace, path(4, 5)}, {SegmentKind::kRetreat, path(5, 6)}};
  grasp.hand_joints = {"f"};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  grasp.hand = {one(0.1), one(0.6), one(1), one(-1), one(2)};
  grasp.place_length = 0.15;
  grasp.lifted_mass = 0.3;
  grasp.score = 0.71;
  return grasp;
}

struct Fakes {
  FakeArm arm;
  FakeHand hand;
  ArmPercepts now{0, {"j", "f"}, {0.0, 0.0}, Eigen::Vector3d::Zero()};
  std::vector<PadPercept> pads;
  double weight = 3;  // N, of what the hand closes on

  ArmPercepts& felt() {
    now.positions = {arm.position[0], hand.position()};
    now.wrist_force = Eigen::Vector3d(0, 0, hand.last_closes ? weight : 0);
    now.pads = pads;
    return now;
  }
  /// Until it is finished, or `until` the segment of that number was asked for.
  void run(ArmCycle& cycle, int steps = 4000, std::size_t until = 1000) {
    for (int i = 0; i < steps && !cycle.finished() && arm.asked.size() < until; ++i) {
      now.time += 0.02;
      cycle.step(felt());
    }
  }
};

inline const Surprise* surprise_of(const ArmCycle& cycle, SurpriseKind kind) {
  for (const Surprise& surprise : cycle.surprises()) {
    if (surprise.kind == kind) return &surprise;
  }
  return nullptr;
}

inline int surprising(const ArmCycle& cycle) {
  int count = 0;
  for (const Surprise& surprise : cycle.surprises()) count += surprise.surprising ? 1 : 0;
  return count;
}

}  // namespace prehend::control
