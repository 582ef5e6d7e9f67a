#include "msgs/convert/belief.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "msgs/convert/geometry.h"
#include "msgs/convert/load.h"
#include "msgs/convert/mend.h"
#include "prehend/geometry/errors.h"

namespace prehend::convert {
namespace {

using geometry::InputError;

constexpr double kUnit = 1e-3;  // that a unit normal's length may be off

double read_finite(double value, double least, const char* what) {
  if (std::isfinite(value) && value >= least) return value;
  throw InputError(
      std::string("Evidence of an attempt with ") + what + " of " + std::to_string(value),
      kSenderMend);
}

msgs::TouchContact contact_message(const belief::Contact& contact) {
  msgs::TouchContact message;
  *message.mutable_p() = to_message(contact.p_W);
  if (!contact.normal_W.isZero()) *message.mutable_normal() = to_message(contact.normal_W);
  message.set_deviation(contact.deviation);
  return message;
}

belief::Contact read_contact(const msgs::TouchContact& message) {
  belief::Contact contact;
  contact.p_W = from_message(message.p());
  if (message.has_normal()) contact.normal_W = from_message(message.normal());
  const double length = contact.normal_W.norm();
  if (!contact.p_W.allFinite() || (message.has_normal() && !(std::abs(length - 1) < kUnit))) {
    throw InputError("Evidence of an attempt with a contact that has no place or no unit normal",
                     kSenderMend);
  }
  contact.deviation = read_finite(message.deviation(), 1e-9, "a contact's deviation");
  return contact;
}

}  // namespace

msgs::AttemptEvidence to_message(const belief::Attempt& attempt) {
  msgs::AttemptEvidence message;
  for (const belief::Act& act : attempt) {
    msgs::TouchAct& one = *message.add_acts();
    one.set_moved_along(act.motion.along);
    one.set_moved_turn(act.motion.turn);
    for (const belief::HandSample& sample : act.free_way) {
      msgs::HandPose& pose = *one.add_free_way();
      *pose.mutable_x_wh() = to_message(sample.X_WH);
      pose.mutable_position()->Assign(sample.joints.begin(), sample.joints.end());
    }
    for (const belief::Contact& contact : act.contacts) {
      *one.add_contacts() = contact_message(contact);
    }
  }
  return message;
}

belief::Attempt from_message(const msgs::AttemptEvidence& message) {
  belief::Attempt attempt;
  for (const msgs::TouchAct& one : message.acts()) {
    belief::Act act;
    act.motion = {read_finite(one.moved_along(), 0, "a motion"),
                  read_finite(one.moved_turn(), 0, "a turn")};
    for (const msgs::HandPose& pose : one.free_way()) {
      belief::HandSample sample{from_message(pose.x_wh()), Eigen::VectorXd(pose.position_size())};
      std::copy(pose.position().begin(), pose.position().end(), sample.joints.begin());
      if (!sample.X_WH.matrix().allFinite() || !sample.joints.allFinite()) {
        throw InputError("Evidence of an attempt with a pose of the hand that is not finite",
                         kSenderMend);
      }
      act.free_way.push_back(std::move(sample));
    }
    for (const msgs::TouchContact& contact : one.contacts()) {
      act.contacts.push_back(read_contact(contact));
    }
    attempt.push_back(std::move(act));
  }
  return attempt;
}

msgs::Belief to_message(const belief::Recollection& recollection) {
  msgs::Belief message;
  for (const belief::BelievedShape& shape : recollection.after) {
    msgs::BelievedShape& one = *message.add_shapes();
    one.set_name(shape.name);
    one.set_weight(shape.weight);
    one.set_misfit(shape.misfit);
    const auto before =
        std::find_if(recollection.before.begin(), recollection.before.end(),
                     [&shape](const auto& other) { return other.index == shape.index; });
    one.set_weight_before(before == recollection.before.end() ? 0 : before->weight);
  }
  for (const belief::Contact& contact : recollection.contacts) {
    *message.add_contacts() = contact_message(contact);
  }
  *message.mutable_x_moved() = to_message(recollection.X_moved);
  message.set_looks(static_cast<std::uint32_t>(recollection.looks));
  message.set_change(recollection.change);
  set_load(recollection.load, &message);
  message.set_load_problem(recollection.load_problem);
  return message;
}

}  // namespace prehend::convert
