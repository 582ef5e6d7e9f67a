#include "nodes/grasp_cycle/arm_robot.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/cycle.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/pad_touch.h"
#include "prehend/graph/knob_parameters.h"

namespace prehend::nodes {
namespace {

constexpr const char* kHolding = "holding_";    // before the names of HoldingOptions
constexpr const char* kSlip = "slip_";          // before those of touch::HoldSlipOptions
constexpr const char* kOfGripper = "gripper_";  // before those of PadGripperOptions

// "put 0.15 m away", or what else becomes of the object.
std::string destination(const msgs::Grasp& grasp) {
  if (!grasp.has_move()) return "only lifted";
  const double away = convert::from_message(grasp.move()).norm();
  return away > 0 ? fmt::format("put {:.2f} m away", away)
                  : std::string("put back where it stands: there is no free place that is reached");
}

}  // namespace

control::ArmCycleOptions declare_arm_options(graph::Node& node) {
  control::ArmCycleOptions options;
  options.reacts = node.declare_parameter<bool>(
      {.name = "reacts",
       .default_value = options.reacts,
       .description =
           "stop the approach where the hand touches, and put the fingers round what they feel; a "
           "gripper that regulates its grip closes there where its pads are beside the object by "
           "then, else it lets go and looks again; false: open loop",
       .read_only = true});
  const graph::DeclareKnobs declare{node};
  control::ArmCycleOptions::knobs(options, declare);
  robot::GripOptions::knobs(options, declare);
  control::HoldingOptions::knobs(options.holding, graph::DeclareKnobs{node, kHolding});
  touch::HoldSlipOptions::knobs(options.slip, graph::DeclareKnobs{node, kSlip});
  return options;
}

control::PadGripperOptions declare_pad_gripper_options(graph::Node& node) {
  control::PadGripperOptions options;
  control::PadGripperOptions::knobs(options, graph::DeclareKnobs{node, kOfGripper});
  return options;
}

void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                const std::string& gripper_driver) {
  const bool has_gripper = platform.hand_port == robot::HandPort::kGripper;
  const bool is_of_hand = gripper_driver == kSdh || gripper_driver == kBarrett;
  if (has_gripper && is_of_hand) {
    throw std::invalid_argument(fmt::format(
        "platform {} moves its gripper through /gripper, but the hand is that of the driver {}, "
        "which offers /hand; name a platform with {}",
        platform.name, gripper_driver,
        gripper_driver == kSdh ? "an SDH-2, as kr5_sdh" : "a BarrettHand, as pa10_barrett"));
  }
  if (!has_gripper && gripper_driver != kSimulated && !is_of_hand) {
    throw std::invalid_argument(fmt::format(
        "platform {} moves its hand by its joints (/hand/move), but the gripper is that of the "
        "driver {}, which offers /gripper; name a platform with hand_port: gripper, as stage_pg70",
        platform.name, gripper_driver));
  }
  const auto refuse = [&](const std::vector<std::string>& names, const char* why) {
    for (const std::string& name : names) {
      if (!node.is_parameter_given(name)) continue;
      throw std::invalid_argument(
          fmt::format("parameter '{}' does not apply with platform {}: {}; leave it out", name,
                      platform.name, why));
    }
  };
  const std::vector<std::string> adapting{"adaptations", "shift_tolerance"};
  if (platform.hand.gripper) refuse(adapting, "its jaws meet in the middle");
  if (platform.hand.pads.empty()) refuse(adapting, "where its motors stop is not predicted");
  if (!node.parameter<bool>("reacts")) {
    refuse(adapting, "with reacts:=false nothing is felt");
    refuse({"largest_shortfall"}, "with reacts:=false jaws that touch something let go");
  }
  std::vector<std::string> names;
  if (has_gripper) {
    robot::GripOptions fingers;
    robot::GripOptions::knobs(fingers, text::ListKnobs{"", &names});
    names.erase(std::remove(names.begin(), names.end(), "touch_force"), names.end());
    names.push_back("small_opening");
    control::HoldingOptions holding;
    control::HoldingOptions::knobs(holding, text::ListKnobs{kHolding, &names});
    refuse(names,
           "its gripper closes until its pads feel the force of the plan, and they tell what is "
           "held");
    return;
  }
  control::PadGripperOptions gripper;
  control::PadGripperOptions::knobs(gripper, text::ListKnobs{kOfGripper, &names});
  names.push_back("largest_shortfall");
  refuse(names, "its hand is moved by its joints, not through /gripper");
  if (platform.hand.gripper) refuse({"grip_force"}, "its force is planned");
  if (platform.hand.pads.empty()) {
    constexpr const char* kNoPads = "its hand has no tactile pads";
    refuse({"grip_force", "touch_force", "touch_counts"}, kNoPads);
    std::vector<std::string> slipping{"slip_force_factor", "largest_grip_force", "slip_settle_time",
                                      "largest_slide"};
    touch::HoldSlipOptions slip;
    touch::HoldSlipOptions::knobs(slip, text::ListKnobs{kSlip, &slipping});
    refuse(slipping, kNoPads);
    // The launch files give it, 0 where nothing is asked for.
    if (node.parameter<double>("minimum_stability") > 0) refuse({"minimum_stability"}, kNoPads);
  }
}

ArmRobot::ArmRobot(graph::Node& node, const robot::Platform& platform, const GripperSource& gripper,
                   const ArmRobotOptions& options)
    : node_(node),
      gripper_(gripper),
      arm_(node),
      platform_(platform),
      held_(node, platform_),
      contact_force_(options.cycle.contact_force),
      touch_force_(options.cycle.touch_force),
      touch_counts_(options.touch_counts) {
  using graph::QoS;
  if (platform.hand_port == robot::HandPort::kGripper) {
    control::PadGripperOptions pads = options.gripper;
    pads.touch_force = options.cycle.touch_force;
    pads.stale_time = options.cycle.stale_time;
    drive_ = std::make_unique<GripperActions>(node);
    auto hand = std::make_unique<control::PadGripper>(*platform.hand.gripper, pads, *drive_);
    pad_gripper_ = hand.get();
    hand_ = std::move(hand);
    subscriptions_.push_back(node.subscribe<msgs::GripperState>(
        "/gripper/state", QoS::latest(),
        [this](const auto& message) { gripper_state_ = message.shared(); }));
  } else {
    hand_ = std::make_unique<HandActions>(node);
  }
  cycle_.emplace(options.cycle, arm_, *hand_);
  if (options.cycle.task.does(control::Primitive::kInspect)) {
    cycle_->inspect_by(held_looks_.emplace(node, held_));
  }
  if (options.view_after_lift && platform.X_FC) {
    node.log_info("what was lifted is not looked at: the camera goes along with the hand");
  } else if (options.view_after_lift) {
    cycle_->view_lifts_by(lift_views_.emplace(node, held_));
  }
  if (auto judge = control::GripJudge::of(platform)) cycle_->judge_grips(std::move(*judge));
  subscriptions_.push_back(node.subscribe<msgs::JointState>(
      "/joint_states", QoS::latest(), [this](const auto& message) { joints_ = message.shared(); }));
  subscriptions_.push_back(
      node.subscribe<msgs::Wrench>("/wrench", QoS::latest(), [this](const auto& message) {
        // What cannot be read leaves the older one in place, which soon is too old to move by.
        wrist_force_ = convert::from_message(message->wrench().force());
        wrist_torque_ = convert::from_message(message->wrench().torque());
        wrist_stamp_ = message->header().stamp();
      }));
  for (const robot::HandPad& pad : platform.hand.pads) {
    hand_pads_.emplace(pad.name, pad);
    subscriptions_.push_back(node.subscribe<msgs::TactileFrame>(
        "/tactile/" + pad.name, QoS::latest(),
        [this, name = pad.name](const auto& message) { pads_[name] = message.shared(); }));
  }
}

void ArmRobot::step() {
  const control::ArmPercepts now = percepts();
  cycle_->step(now);
  attempt_watch_->step(*cycle_, now);
  percept_watch_->step(*cycle_, now);
}

std::string ArmRobot::lacks(const msgs::Grasp& grasp) const {
  return convert::has_arm_motion(grasp) ? "" : "no motion of the arm";
}

std::string ArmRobot::waits_for() const {
  const bool known = gripper_.model() || !gripper_.problem().empty();
  return !has_gripper() || known ? "" : gripper_.missing();
}

// @throws std::runtime_error for a plan for another gripper.
void ArmRobot::check_gripper(const msgs::GraspPlan& plan) const {
  if (!has_gripper()) return;
  const std::string other = gripper_.differs_from(plan);
  if (!other.empty()) throw std::runtime_error(other);
}

void ArmRobot::prepare_push(const msgs::GraspPlan& plan) {
  check_gripper(plan);
  prepared_ = {convert::push_from_message(plan.push())};
  advice_ = {};
}

void ArmRobot::start(const std::string& problem) {
  if (has_gripper()) {
    const std::optional<robot::GripperModel> gripper = gripper_.model();
    if (!gripper) throw std::runtime_error(gripper_.missing());
    pad_gripper_->set_gripper(*gripper);
    platform_.set_gripper(*gripper);
  }
  attempt_watch_.emplace(platform_, contact_force_, touch_force_);
  percept_watch_.emplace(platform_, touch_force_, touch_counts_);
  cycle_->start(prepared_, problem, advice_);
}

std::string ArmRobot::prepare(const View& view, const Target& target, std::optional<int> first) {
  check_gripper(*view.plans.at(target.id));
  std::vector<control::ArmGrasp> grasps;
  const auto model = view.models.find(target.id);
  const bool knows_slip = model != view.models.end() && model->second->has_friction() &&
                          model->second->friction().has_high();
  for (const msgs::Grasp* grasp : target.grasps) {
    grasps.push_back(convert::arm_grasp_from_message(*grasp));
    grasps.back().knows_slip = knows_slip;
  }
  if (first && (*first < 0 || static_cast<std::size_t>(*first) >= grasps.size())) {
    throw std::runtime_error(
        fmt::format("grasp {} of object {} cannot be executed: of its grasps the first {} have a "
                    "motion of the arm, from 0",
                    *first, target.id, grasps.size()));
  }
  advice_ = first ? control::Advice{} : convert::advice_of(*view.plans.at(target.id));
  advice_.first = first;
  if (static_cast<std::size_t>(advice_.grasp) >= grasps.size()) {
    throw std::runtime_error("the plan would feel it with a grasp that has no motion of the arm");
  }
  const msgs::GraspPlan& plan = *view.plans.at(target.id);
  held_.hold(plan.header().stamp(), target.id);
  if (plan.has_probe() && convert::has_arm_motion(plan.probe())) {
    const robot::Preshape& preshape = platform_.hand.preshape(plan.probe().preshape());
    grasps.push_back(
        convert::probe_from_message(plan.probe(), platform_.hand.X_HP * preshape.X_PG));
  }
  prepared_ = std::move(grasps);
  return destination(*target.grasps[static_cast<std::size_t>(first.value_or(0))]);
}

std::shared_ptr<const touch::FeltPad> ArmRobot::felt_pad(const std::string& name,
                                                         const msgs::TactileFrame& frame) const {
  const auto said = gripper_.model();
  std::string wanted =
      fmt::format("{} {} {} {} {} {} {} {}", frame.rows(), frame.columns(), frame.intensity_size(),
                  frame.texel_width(), frame.texel_height(), frame.full_scale(),
                  frame.newton_per_count(), said ? said->name : "");
  Felt& felt = felt_[name];
  if (felt.made_for == wanted) return felt.pad;
  felt = {std::move(wanted), nullptr};
  robot::HandPad sent = hand_pads_.at(name);
  if (said) sent.model = said->pad;
  try {
    // The frames of a stage's gripper have the gripper's x from left to right on both its pads.
    felt.pad = std::make_shared<const touch::FeltPad>(
        convert::felt_pad(frame, sent, has_gripper() && name == "right"));
  } catch (const std::invalid_argument& error) {
    node_.report(graph::Health::kWarning,
                 fmt::format("nothing is foretold by pad {}: {}", name, error.what()));
  }
  return felt.pad;
}

control::ArmPercepts ArmRobot::percepts() const {
  control::ArmPercepts percepts;
  percepts.time = graph::seconds(node_.clock().now());
  if (joints_) {
    percepts.names.assign(joints_->name().begin(), joints_->name().end());
    percepts.positions.assign(joints_->position().begin(), joints_->position().end());
    percepts.joints_age = percepts.time - graph::seconds(joints_->header().stamp());
  }
  percepts.wrist_force = wrist_force_;
  percepts.wrist_torque = wrist_torque_;
  percepts.wrist_age = percepts.time - graph::seconds(wrist_stamp_);
  for (const auto& [name, frame] : pads_) {
    const contact::PadLayout& layout = *hand_pads_.at(name).layout;
    const auto& counts = frame->intensity();
    // A real pad may be another one than the robot's file says.
    const bool same = static_cast<std::size_t>(counts.size()) == layout.size();
    const double area = same ? robot::touched_area(counts, touch_counts_, layout)
                             : robot::touched_area(counts, touch_counts_,
                                                   frame->texel_width() * frame->texel_height());
    percepts.pads.push_back(
        {frame->sum(), area, percepts.time - graph::seconds(frame->header().stamp()), name});
    if (auto felt = felt_pad(name, *frame)) {
      percepts.frames.push_back({name, std::move(felt), convert::counts_of(*frame)});
    }
  }
  if (gripper_state_) {
    percepts.gripper = {gripper_state_->opening(), gripper_state_->blocked(),
                        gripper_state_->error_code(),
                        percepts.time - graph::seconds(gripper_state_->header().stamp())};
  }
  return percepts;
}

}  // namespace prehend::nodes
