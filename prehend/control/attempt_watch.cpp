#include "prehend/control/attempt_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prehend/control/hand_sample.h"

namespace prehend::control {
namespace {

using belief::HandSample;
using geometry::RigidTransform;

constexpr double kLeastShift = 0.003;  // m, of the hand between samples of a way
constexpr double kLeastTurn = 0.03;    // rad, of a joint or the hand
constexpr std::size_t kMoments = 16;
// How far the pads move a thing from the first touch to when it is gripped: share of their way, and
// what it turns by on that, over its half width.
constexpr double kTakenAlong = 0.5, kHalfWidth = 0.04, kMostTurn = 0.5;
constexpr double kLeastTaken = 0.0005;  // m
// m, standard, of where a fingertip without a pad has met it.
constexpr double kTipDeviation = 0.003;

bool is_apart(const HandSample& a, const HandSample& b) {
  return (a.X_WH.translation() - b.X_WH.translation()).norm() > kLeastShift ||
         (a.X_WH.linear() - b.X_WH.linear()).norm() > kLeastTurn ||
         (a.joints - b.joints).cwiseAbs().maxCoeff() > kLeastTurn;
}

}  // namespace

AttemptWatch::AttemptWatch(const robot::Platform& platform, double contact_force,
                           double touch_force)
    : platform_(platform),
      chain_(platform.arm_chain()),
      evidence_(platform.hand),
      load_(platform.hand, touch_force),
      contact_force_(contact_force),
      touch_force_(touch_force) {}

double AttemptWatch::force_of(const std::string& pad) const {
  const auto found = std::find_if(percepts_.pads.begin(), percepts_.pads.end(),
                                  [&](const PadPercept& one) { return one.name == pad; });
  return found == percepts_.pads.end() ? 0 : found->sum;
}

bool AttemptWatch::pads_touch() const {
  return std::any_of(percepts_.pads.begin(), percepts_.pads.end(), [&](const PadPercept& pad) {
    return pad.sum > touch_force_ && !not_believed_.contains(pad.name);
  });
}

std::vector<belief::Contact> AttemptWatch::contacts() const {
  std::vector<belief::Contact> contacts;
  for (const touch::PadFrame& frame : percepts_.frames) {
    if (not_believed_.contains(frame.pad) || !(force_of(frame.pad) > touch_force_)) continue;
    const auto pad = std::find_if(percepts_.pads.begin(), percepts_.pads.end(),
                                  [&](const PadPercept& one) { return one.name == frame.pad; });
    const double spoke = percepts_.time - pad->age;
    const auto moment = std::min_element(
        moments_.begin(), moments_.end(), [spoke](const Moment& a, const Moment& b) {
          return std::abs(a.time - spoke) < std::abs(b.time - spoke);
        });
    for (const belief::Contact& contact : evidence_.contacts(moment->hand, {frame})) {
      contacts.push_back(contact);
    }
  }
  return contacts;
}

void AttemptWatch::begin(const ArmCycle& cycle) {
  open_ = true;
  surprises_before_ = cycle.surprises().size();
  not_believed_.clear();
  for (const PadPercept& pad : percepts_.pads) {
    if (pad.sum > touch_force_ || !std::isfinite(pad.sum)) not_believed_.insert(pad.name);
  }
  way_.clear();
  approached_ = 0;
  first_touch_.reset();
  attempt_.clear();
}

void AttemptWatch::extend_way() {
  double age = 0;
  for (const PadPercept& pad : percepts_.pads) age = std::max(age, pad.age);
  const double spoke = percepts_.time - age;
  const Moment* last = nullptr;
  for (const Moment& moment : moments_) {
    if (moment.time <= spoke) last = &moment;
  }
  if (last == nullptr) return;
  if (way_.empty() || is_apart(way_.back(), last->hand)) way_.push_back(last->hand);
}

// m, that any pad went.
double AttemptWatch::farthest(const HandSample& from, const HandSample& to) const {
  std::vector<RigidTransform> X_HL_from, X_HL_to;
  platform_.hand.link_poses(from.joints, X_HL_from);
  platform_.hand.link_poses(to.joints, X_HL_to);
  double way = 0;
  for (const robot::HandPad& pad : platform_.hand.pads) {
    const auto link = static_cast<std::size_t>(pad.link);
    const Eigen::Vector3d p = pad.X_LP.translation();
    way = std::max(way, (from.X_WH * X_HL_from[link] * p - to.X_WH * X_HL_to[link] * p).norm());
  }
  return way;
}

void AttemptWatch::step(const ArmCycle& cycle, const ArmPercepts& percepts) {
  percepts_ = percepts;
  const std::optional<HandSample> hand = hand_sample(platform_, chain_, percepts);
  if (!hand) return;
  moments_.push_back({percepts.time, *hand});
  if (moments_.size() > kMoments) moments_.pop_front();
  load_.step(cycle, percepts, *hand);
  if (cycle.result().tries() != attempts_) {
    attempts_ = cycle.result().tries();
    begin(cycle);
  }
  const Phase phase = cycle.phase();
  if (!open_) return;
  if (phase != Phase::kApproach && phase != Phase::kGrasp) return conclude(cycle);
  const std::optional<Eigen::Vector3d> tip_H = cycle.met_with_H();
  // Which way the surface faces there, no wrist tells that feels a force alone.
  const auto at_tip = [&tip_H](const HandSample& sample) {
    return belief::Contact{sample.X_WH * *tip_H, Eigen::Vector3d::Zero(), kTipDeviation};
  };
  if (first_touch_) {
    // The wrist felt it before the cycle said what it was met with.
    if (tip_H && !attempt_.empty() && attempt_.back().contacts.empty()) {
      attempt_.back().contacts.push_back(at_tip(*first_touch_));
    }
    return;
  }
  const bool by_wrist =
      tip_H || (percepts.wrist_force && percepts.wrist_force->norm() > contact_force_);
  if (!pads_touch() && !by_wrist) {
    extend_way();
    if (phase == Phase::kApproach) approached_ = way_.size();
    return;
  }
  first_touch_ = hand;
  std::vector<belief::Contact> met = contacts();
  if (met.empty() && tip_H) met.push_back(at_tip(*hand));
  attempt_.push_back({{}, way_, std::move(met)});
}

void AttemptWatch::conclude(const ArmCycle& cycle) {
  open_ = false;
  ++concluded_;
  const std::vector<Surprise>& surprises = cycle.surprises();
  const bool stopped = std::any_of(
      surprises.begin() + static_cast<std::ptrdiff_t>(surprises_before_), surprises.end(),
      [](const Surprise& one) { return one.kind == SurpriseKind::kFingersTouch && one.felt > 0; });
  if (!first_touch_) {
    if (stopped) way_.resize(approached_);
    if (!way_.empty()) attempt_.push_back({{}, way_, {}});
    return;
  }
  std::vector<belief::Contact> now = contacts();
  if (now.empty()) return;
  const double taken = kTakenAlong * farthest(*first_touch_, moments_.back().hand) + kLeastTaken;
  attempt_.push_back({{taken, std::min(kMostTurn, taken / kHalfWidth)}, {}, std::move(now)});
}

}  // namespace prehend::control
