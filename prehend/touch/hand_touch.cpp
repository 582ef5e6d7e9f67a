#include "prehend/touch/hand_touch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace prehend::touch {
namespace {

std::optional<double> position_of(const std::string& joint, const std::vector<std::string>& joints,
                                  const std::vector<double>& positions) {
  for (const std::string& name : {joint, "hand_" + joint}) {
    const auto found = std::find(joints.begin(), joints.end(), name);
    if (found != joints.end()) {
      return positions.at(static_cast<std::size_t>(found - joints.begin()));
    }
  }
  return std::nullopt;
}

// Of the texels that are there, in the plane of x and y.
Eigen::AlignedBox2d outline(const contact::PadLayout& layout) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (!(layout.area(i) > 0)) continue;
    const double half = std::sqrt(layout.area(i)) / 2;
    const Eigen::Vector2d p(layout.x[i], layout.y[i]);
    box.extend((p.array() - half).matrix());
    box.extend((p.array() + half).matrix());
  }
  return box;
}

// Nothing when the pad does not touch.
std::optional<PadContact> contact_of(const PadFrame& frame, const geometry::RigidTransform& X_HP,
                                     double least_force) {
  const contact::PadLayout& layout = frame.felt->layout;
  const FeltTexels felt = felt_texels(*frame.felt, frame.counts);
  PadContact contact;
  contact.pad = frame.pad;
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  int touched = 0, full = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double force = felt.force[i];
    if (!(force > 0 && layout.area(i) > 0)) continue;
    ++touched;
    full += felt.state[i] == Texel::kFull ? 1 : 0;
    contact.force += force;
    contact.area += layout.area(i);
    contact.largest_pressure = std::max(contact.largest_pressure, force / layout.area(i));
    center += force * layout.position(i);
    normal += force * layout.normal(i);
  }
  if (!(contact.force > least_force)) return std::nullopt;
  center /= contact.force;
  contact.full = static_cast<double>(full) / touched;
  Eigen::Vector2d variance = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double share = layout.area(i) > 0 ? felt.force[i] / contact.force : 0;
    const Eigen::Vector3d off = layout.position(i) - center;
    variance += share * off.head<2>().cwiseAbs2();
    contact.arm += share * off.norm();
  }
  contact.spread = variance.cwiseSqrt();
  contact.p_H = X_HP * center;
  contact.n_H = X_HP.linear() * normal.normalized();
  contact.along_H = X_HP.linear().col(1);
  contact.place = center.head<2>();
  const Eigen::AlignedBox2d box = outline(layout);
  contact.margin_to_tip = box.max().y() - center.y();
  contact.margin = std::min((center.head<2>() - box.min()).minCoeff(),
                            (box.max() - center.head<2>()).minCoeff());
  return contact;
}

}  // namespace

std::shared_ptr<const FeltPad> felt_pad_of(const robot::HandPad& pad, bool mirrored) {
  FeltPad felt{*pad.layout, pad.model.law, pad.model.newton_per_count, pad.model.full_scale};
  if (mirrored) felt = felt_pad(pad.model, true);
  return std::make_shared<const FeltPad>(std::move(felt));
}

Eigen::VectorXd joint_positions(const robot::HandModel& hand,
                                const std::vector<std::string>& joints,
                                const std::vector<double>& positions) {
  Eigen::VectorXd motors(hand.size());
  const std::vector<std::string> names = hand.actuated_names();
  for (int i = 0; i < hand.size(); ++i) {
    const auto at = position_of(names[static_cast<std::size_t>(i)], joints, positions);
    if (!at) {
      throw std::invalid_argument("HandTouch: nothing says where the joint '" +
                                  names[static_cast<std::size_t>(i)] + "' of the hand " +
                                  hand.name + " is");
    }
    motors[i] = *at;
  }
  Eigen::VectorXd all = hand.all_positions(motors);
  for (Eigen::Index i = 0; i < all.size(); ++i) {
    const std::string& name = hand.model.joints[static_cast<std::size_t>(i)].name;
    if (const auto at = position_of(name, joints, positions)) all[i] = *at;
  }
  return all;
}

HandTouch::HandTouch(robot::HandModel hand) : hand_(std::move(hand)) {}

std::vector<PadContact> HandTouch::contacts(const std::vector<std::string>& joints,
                                            const std::vector<double>& positions,
                                            const std::vector<PadFrame>& frames,
                                            double least_force) const {
  return contacts(joint_positions(hand_, joints, positions), frames, least_force);
}

std::vector<PadContact> HandTouch::contacts(const Eigen::VectorXd& joints,
                                            const std::vector<PadFrame>& frames,
                                            double least_force) const {
  std::vector<geometry::RigidTransform> X_HL;
  hand_.link_poses(joints, X_HL);
  std::vector<PadContact> contacts;
  for (const PadFrame& frame : frames) {
    const auto pad = std::find_if(hand_.pads.begin(), hand_.pads.end(),
                                  [&](const auto& one) { return one.name == frame.pad; });
    if (pad == hand_.pads.end()) {
      throw std::invalid_argument("HandTouch: the hand " + hand_.name + " has no pad '" +
                                  frame.pad + "'");
    }
    const geometry::RigidTransform X_HP = X_HL[static_cast<std::size_t>(pad->link)] * pad->X_LP;
    if (auto contact = contact_of(frame, X_HP, least_force)) {
      contacts.push_back(std::move(*contact));
    }
  }
  return contacts;
}

}  // namespace prehend::touch
