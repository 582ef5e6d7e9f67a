#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/control/jog_session.h"
#include "tools/jog/panel.h"
#include "tools/jog/platform_link.h"
#include "tools/jog/runs.h"
#include "tools/jog/terminal.h"

namespace prehend::tools {
namespace {

using control::JogCommands;
using control::JogRow;
using control::JogSession;
using std::chrono::steady_clock;

constexpr double kHandRamp = 0.1;  // s, from rest to a joint's greatest speed
constexpr int kStepsPerPicture = 4;
constexpr double kEndTime = 3;       // s, for the arm to stop when the tool ends
constexpr double kHandMoved = 0.02;  // rad or m: the hand's shapes are placed anew
constexpr std::size_t kKeptMessages = 20;
constexpr const char* kNobody = "nobody takes /arm/command or serves /arm/follow: no arm is moved";

struct HandRows {
  std::vector<JogRow> rows;
  std::vector<double> accelerations;
};

HandRows hand_rows(const robot::Platform& platform) {
  HandRows hand;
  if (platform.hand_port == robot::HandPort::kGripper) {
    const robot::GripperModel& gripper = *platform.hand.gripper;
    hand.rows.push_back({"opening", true, false, 0, gripper.max_opening, gripper.max_speed});
    hand.accelerations.push_back(gripper.max_acceleration);
    return hand;
  }
  for (const int index : platform.hand.actuated) {
    const robot::Joint& joint = platform.hand.model.joints[static_cast<std::size_t>(index)];
    hand.rows.push_back({"hand_" + joint.name, true, joint.kind == robot::Joint::Kind::kRevolute,
                         joint.lower, joint.upper, joint.max_velocity});
    hand.accelerations.push_back(joint.max_velocity / kHandRamp);
  }
  return hand;
}

control::JogOptions jog_options(const JogChoices& choices) {
  control::JogOptions options;
  options.hold_time = choices.hold;
  return options;
}

JogSession session_of(const robot::Platform& platform, const JogChoices& choices) {
  const control::JogOptions options = jog_options(choices);
  control::ArmJog arm(platform.arm_chain(), platform.acceleration,
                      platform.X_FG(preshape_of(platform.hand, choices.preshape)), options);
  arm.set_speed(choices.speed);
  HandRows hand = hand_rows(platform);
  return JogSession(std::move(arm), std::move(hand.rows), hand.accelerations, options);
}

/// The tool while it runs.
class Jogging {
 public:
  Jogging(const PlatformLink& robot, const JogChoices& choices)
      : robot_(robot),
        choices_(choices),
        link_(*robot.link),
        session_(session_of(robot.platform, choices)) {
    title_ = fmt::format("{} ({})", robot.platform.name, robot.found.said_by);
    if (!link_.arm_takes_set_points()) {
      say(link_.arm_takes_runs() ? "nobody takes /arm/command: the arm moves by /arm/follow, a "
                                   "second at a time, while a key is held"
                                 : kNobody);
    }
  }

  void run(Terminal& terminal) {
    for (int count = 0; !quits_; ++count) {
      take_keys(terminal);
      if (!terminal.is_there() || interrupted()) session_.key(control::JogKey::kQuit, now());
      const bool seen = terminal.width() >= kPanelWidth && terminal.height() >= kPanelHeight;
      step(seen ? "" : "the terminal is too small to show the robot");
      if (count % kStepsPerPicture == 0) show(terminal);
    }
    // Controlled: its set points slow down.
    const double end = now() + kEndTime;
    while (session_.is_moving() && now() < end) {
      take_keys(terminal);
      step("");
    }
    link_.cancel_hand();
  }

  /// What is said when the screen has gone.
  const std::string& last_words() const { return last_words_; }

 private:
  double now() const {
    return std::chrono::duration<double>(steady_clock::now().time_since_epoch()).count();
  }
  // Until the next step is due; a key that stops is not kept waiting.
  void take_keys(Terminal& terminal) {
    due_ = std::max(due_ + session_.arm().options().period, now());
    bool stops = false;
    do {
      for (const control::JogKey key : terminal.keys(due_ - now())) {
        const bool is_emergency = key == control::JogKey::kEmergency;
        if (!quits_ || is_emergency) session_.key(key, now());
        stops = stops || key == control::JogKey::kStop || is_emergency;
      }
    } while (!stops && terminal.is_there() && now() < due_);
  }
  void say(const std::string& line) {
    messages_.push_back(line);
    if (messages_.size() > kKeptMessages) messages_.pop_front();
  }

  // Where the hand stands changes what may touch.
  void place_hand(const RobotLink::Joints& joints) {
    if (session_.is_moving() && session_.arm().space()) return;
    const Eigen::VectorXd hand = link_.hand_positions(joints);
    if (session_.arm().space() && (hand - placed_).cwiseAbs().maxCoeff() < kHandMoved) return;
    placed_ = hand;
    session_.arm().set_space(space_of(robot_, joints, choices_));
  }

  void step(const std::string& unseen) {
    const RobotLink::Joints joints = link_.joints();
    place_hand(joints);
    control::JogPercepts percepts;
    percepts.time = now();
    percepts.arm = joints.arm;
    percepts.arm_age = joints.arm_age;
    percepts.hand = joints.hand;
    percepts.hand_age = joints.hand_age;
    if (!link_.arm_takes_set_points()) {
      percepts.arm_takes_runs = link_.arm_takes_runs();
      if (!percepts.arm_takes_runs) percepts.arm_forbidden = kNobody;
    }
    percepts.arm_runs = link_.arm_runs();
    percepts.forbidden = link_.forbidden();
    if (percepts.forbidden.empty()) percepts.forbidden = unseen;
    execute(session_.step(percepts), joints);
    for (const std::string& line : link_.news()) say(line);
    if (const auto end = link_.hand_end()) {
      say(std::string("hand: ") +
          (end->reached   ? "there"
           : end->blocked ? "presses"
                          : "stopped") +
          (end->reason.empty() ? "" : " (" + end->reason + ")"));
    }
  }

  void execute(const JogCommands& commands, const RobotLink::Joints& joints) {
    if (commands.emergency) {
      last_words_ = link_.emergency_stop("key of prehend jog");
      say(last_words_);
      link_.end_run();
      link_.cancel_hand();
      return;
    }
    if (commands.quit) quits_ = true;
    if (commands.end_hand_motion) link_.cancel_hand();
    if (commands.stop_arm) link_.stop_arm();
    if (commands.end_run) link_.end_run();
    if (!commands.run.empty()) {
      link_.run_arm(commands.run, session_.arm().options().period);
    }
    if (commands.stop_hand) link_.stop_hand();
    if (commands.arm) link_.command_arm(*commands.arm);
    if (commands.hand) link_.command_hand(commands.hand->first, commands.hand->second);
    if (!commands.open_hand && !commands.close_hand) return;
    try {
      if (!link_.hand_is_served(0)) {
        throw std::runtime_error(fmt::format("nobody serves {}", link_.hand_action()));
      }
      link_.move_hand(commands.open_hand
                          ? open_goal(link_, joints, choices_.preshape, session_.speed())
                          : close_goal(link_, joints, choices_.preshape, session_.speed(), 0));
      say(commands.open_hand ? "the hand opens" : "the hand closes until it presses");
    } catch (const std::exception& error) {
      say(error.what());
    }
  }

  void show(Terminal& terminal) {
    const RobotLink::Joints joints = link_.joints();
    const double stale = session_.arm().options().stale_time;
    PanelState state;
    state.title = title_;
    state.session = &session_;
    const auto add = [&](const auto& positions, const auto& velocities, std::size_t count,
                         double age) {
      for (std::size_t i = 0; i < count; ++i) {
        const bool told = age < stale && i < static_cast<std::size_t>(positions.size()) &&
                          i < static_cast<std::size_t>(velocities.size());
        const auto k = static_cast<Eigen::Index>(i);
        const double nothing = std::numeric_limits<double>::quiet_NaN();
        state.position.push_back(told ? positions.data()[k] : nothing);
        state.velocity.push_back(told ? velocities.data()[k] : nothing);
      }
    };
    const auto arm = static_cast<std::size_t>(session_.arm().chain().size());
    add(joints.arm, joints.arm_velocity, arm, joints.arm_age);
    add(joints.hand, joints.hand_velocity, session_.rows().size() - arm, joints.hand_age);
    state.knows_pose = joints.arm_age < stale;
    if (state.knows_pose) state.X_BG = session_.arm().X_BG(joints.arm);
    state.X_WB = robot_.platform.X_WB;
    state.alarm = link_.forbidden();
    if (state.alarm.empty() && !state.knows_pose) {
      state.alarm = joints.arm.size() == 0
                        ? std::string("/joint_states has not come")
                        : fmt::format("/joint_states is silent for {:.1f} s", joints.arm_age);
    }
    state.felt = felt_text(link_);
    state.messages.assign(messages_.begin(), messages_.end());
    terminal.show(panel_lines(state, terminal.width(), terminal.height()));
  }

  const PlatformLink& robot_;
  const JogChoices& choices_;
  RobotLink& link_;
  JogSession session_;
  std::string title_, last_words_;
  Eigen::VectorXd placed_;
  std::deque<std::string> messages_;
  double due_ = 0;
  bool quits_ = false;
};

}  // namespace

int run_jog(const JogChoices& choices) {
  std::string last_words;
  {
    // A terminal that cannot is said before anything joins the graph.
    Terminal::check();
    notice_interrupts();
    const PlatformLink robot = link_platform("jog", choices);
    preshape_of(robot.platform.hand, choices.preshape);
    robot.link->wait_for_joints(choices.patience, RobotLink::Needed::kArm);
    Jogging jogging(robot, choices);
    Terminal terminal;
    jogging.run(terminal);
    last_words = jogging.last_words();
  }
  if (!last_words.empty()) std::printf("%s\n", last_words.c_str());
  return 0;
}

}  // namespace prehend::tools
