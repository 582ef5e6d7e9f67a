// The arm leaves what it has put down, and goes back the way it came.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {
namespace {

constexpr double kOnPath = 0.03;       // rad or m, from a path: it stands there
constexpr double kLeastWay = 0.01;     // of a path, that is gone back
constexpr double kRelief = 0.02;       // m, back up from what it presses on
constexpr double kSmallRelief = 0.01;  // m
constexpr int kMostReliefs = 6;        // of fingers that open
constexpr int kMostHits = 3;           // of a retreat
constexpr double kBackOff = 0.003;     // m, from what the jaws touch: they are to slide past it
constexpr double kOffHit = 0.02;  // rad or m, of the joint that goes farthest, from what it hit

}  // namespace

void ArmCycle::clear_view() {
  // Behind a place: back by its way down, which is free as the retreat ends on it.
  constexpr std::size_t kPlaceAndRetreat = 2;
  if (gone_.size() < kPlaceAndRetreat) return look_now();
  const PlaceOnPath above =
      nearest_on(gone_[gone_.size() - 2], percepts_.names, percepts_.positions);
  gone_.pop_back();
  if (above.off > kOnPath) return look_now();
  clears_ = true;
  go_back();
}

bool ArmCycle::back_off(bool is_between) {
  const JointTrajectory* approach = segment(motion::SegmentKind::kApproach);
  const double length = grasp().approach_length;
  if (!options_.reacts || approach == nullptr || !(length > 0)) return false;
  const double gone = nearest_on(*approach, percepts_.names, percepts_.positions).share;
  const double came = way_gone(*approach, gone) * length;
  if (!(came > kBackOff) || (!is_between && length - came > options_.largest_shortfall)) {
    return false;
  }
  const JointTrajectory back = reversed(part_of(*approach, gone));
  enter(Step::kBackOff,
        fmt::format("going back from what it touches, {:.0f} mm before the end of the approach",
                    1e3 * (length - came)));
  follow(part_of(back, std::max(time_of_way(back, kBackOff / came), kLeastWay)), 0, false);
  return true;
}

bool ArmCycle::presses() const {
  return is_at_place() && failure().empty() && can_relieve() && percepts_.wrist_force &&
         percepts_.wrist_force->norm() > options_.contact_force;
}

// Fingers that unroll come down, onto the table or the floor of a cup: opened by force they stay
// half closed, and hook what they stand in. What was put down is pressed from before they open: a
// hand that went up for that would take it along.
bool ArmCycle::opens_onto_something() const {
  return step_ == Step::kRelease && reliefs_ < kMostReliefs && !hand_.feels_its_grip() &&
         presses() && pressed_force() > pressed_at_release_ + options_.contact_force;
}

bool ArmCycle::can_relieve() const {
  return segment(motion::SegmentKind::kPlace) != nullptr && grasp().place_length > 0;
}

void ArmCycle::relieve(bool opens_on) {
  const JointTrajectory& place = *segment(motion::SegmentKind::kPlace);
  const double gone = nearest_on(place, percepts_.names, percepts_.positions).share;
  const double came = std::max(way_gone(place, gone) * grasp().place_length, kSmallRelief);
  const JointTrajectory back = reversed(part_of(place, std::max(gone, kLeastWay)));
  opens_on_ = opens_on;
  if (opens_on_) hand_.stop();
  ++reliefs_;
  enter(Step::kRelieve, "going up from what it presses on");
  const double share = std::min(1.0, (opens_on_ ? kSmallRelief : kRelief) / came);
  follow(part_of(back, std::max(time_of_way(back, share), kLeastWay)), 0, false);
}

// Between what stands beside its place a gripper's jaws do not open all the way.
bool ArmCycle::leaves_jammed() {
  if (step_ != Step::kRelease || !hand_.feels_its_grip() || !hand_.is_blocked()) return false;
  const bool is_free = hand_.still_felt().empty();
  const bool goes_up =
      !is_free && reliefs_ < kMostReliefs && is_at_place() && failure().empty() && can_relieve();
  if (!is_free && !goes_up) return false;
  add_surprise(SurpriseKind::kMotion, 1, 0,
               is_free ? "leaves with jaws that are open so far" : "goes up and opens on");
  if (goes_up) {
    relieve(true);
  } else {
    ended(Outcome::kDone);
  }
  return true;
}

bool ArmCycle::retreats_on() {
  const JointTrajectory* way = segment(motion::SegmentKind::kRetreat);
  if (step_ != Step::kRetreat || way == nullptr || hits_ >= kMostHits) return false;
  ++hits_;
  add_surprise(SurpriseKind::kMotion, 1, 0, "goes on from where it hit something");
  const double gone = nearest_on(*way, percepts_.names, percepts_.positions).share;
  enter(Step::kRetreat, "arm: retreat, as what it hit may have given way");
  follow(reversed(part_of(reversed(*way), std::max(1 - gone, kLeastWay))), options_.collision_force,
         false, displaced);
  return true;
}

void ArmCycle::open_hand(Step step, const std::string& detail) {
  hand_.move(grasp().hand_joints, {grasp().hand.open.begin(), grasp().hand.open.end()},
             options_.opening_speed, false, {});
  enter(step, detail);
}

void ArmCycle::open_to_release() {
  pressed_at_release_ = pressed_force();
  open_hand(Step::kRelease, failure().empty() ? "opening the hand" : failure() + "; opening");
}

void ArmCycle::put_back() {
  opened_less_ = true;
  const JointTrajectory way = gone_.back();
  gone_.pop_back();
  enter(Step::kPutBack, "putting back what the hand has taken along");
  follow(reversed(way), options_.collision_force, false);
}

void ArmCycle::open_less() {
  const Eigen::VectorXd positions = grasp().hand.at(gripped_ - options_.small_opening);
  hand_.move(grasp().hand_joints, {positions.begin(), positions.end()}, options_.opening_speed,
             false, {});
  enter(Step::kLoosenHold, "opening the hand by little");
}

void ArmCycle::retreat() {
  const JointTrajectory* way = segment(motion::SegmentKind::kRetreat);
  // What nobody saw would be dragged along.
  if (way && step_ != Step::kRelieve && presses()) return relieve(false);
  enter(Step::kRetreat, "arm: retreat");
  if (!way) return;
  follow(*way, options_.collision_force, true, reliefs_ > 0 ? displaced : joined);
}

void ArmCycle::go_back() {
  if (gone_.empty() && clears_) {
    clears_ = false;
    return look_now();
  }
  if (gone_.empty()) {
    if (!put_down_ || !failure().empty()) return ended(Outcome::kDone);
    holding_.begin_weighing();
    return enter(Step::kVerify, "looking whether the hand is empty");
  }
  enter(Step::kGoBack, "going back the way it came");
  go_back_along();
}

// Contact, or who stopped it, may have ended it on its way. Where it passes the end of an earlier
// way it turns into that: what was let go of in the air lies where those between lead.
void ArmCycle::go_back_along() {
  JointTrajectory way = gone_.back();
  gone_.pop_back();
  JointTrajectory end = way;
  end.points = {way.points.back()};
  const auto off = [this](const JointTrajectory& path) {
    return nearest_on(path, percepts_.names, percepts_.positions);
  };
  if (off(end).off > kOnPath) way = part_of(way, std::max(off(way).share, kLeastWay));
  way_back_ = reversed(way);
  for (std::size_t i = 0; i < gone_.size(); ++i) {
    const PlaceOnPath passed =
        nearest_on(way_back_, gone_[i].joints, gone_[i].points.back().position);
    if (passed.off > kOnPath) continue;
    gone_.resize(i + 1);
    way_back_ = part_of(way_back_, std::max(passed.share, kLeastWay));
    break;
  }
  follow(way_back_, options_.collision_force + pressed_force(), false);
}

// What fell where it came along is not pressed through: the next plan begins from where it stands.
bool ArmCycle::stays_before_hit() {
  if (step_ != Step::kGoBack || way_back_.points.empty()) return false;
  add_surprise(SurpriseKind::kMotion, 1, 0, "goes off what it hit and stays there");
  gone_.clear();
  const double gone = nearest_on(way_back_, percepts_.names, percepts_.positions).share;
  const JointTrajectory off = reversed(part_of(way_back_, std::max(gone, kLeastWay)));
  double farthest = 0;
  for (std::size_t j = 0; j < off.joints.size(); ++j) {
    farthest = std::max(farthest,
                        std::abs(off.points.back().position[j] - off.points.front().position[j]));
  }
  way_back_.points.clear();
  enter(Step::kGoBack, "going off what it hit on its way back");
  const double share = farthest > kOffHit ? kOffHit / farthest : 1.0;
  follow(part_of(off, std::max(time_of_way(off, share), kLeastWay)), 0, false);
  return true;
}

}  // namespace prehend::control
