#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "prehend/text/nearest_match.h"
#include "tools/jog/platform_link.h"
#include "tools/jog/runs.h"

namespace prehend::tools {
namespace {

using namespace std::chrono_literals;

constexpr auto kFeeling = 300ms;  // until pads and joints tell of the end

void list(const FoundPlatform& found, const robot::Platform& platform) {
  std::printf("hand %s of %s (%s)\n", platform.hand.name.c_str(), platform.name.c_str(),
              found.said_by.c_str());
  for (const robot::Preshape& preshape : platform.hand.preshapes) {
    std::printf("  %-16s %s\n", preshape.name.c_str(),
                hand_text(platform.hand, preshape.open).c_str());
  }
}

// That it is a motion of this hand, and that what is given beside it applies.
void check(const JogChoices& choices, const robot::HandModel& hand) {
  std::vector<std::string> known{"open", "close", "list"};
  for (const robot::Preshape& preshape : hand.preshapes) known.push_back(preshape.name);
  if (std::find(known.begin(), known.end(), choices.what) == known.end()) {
    throw std::invalid_argument(fmt::format("hand {} has no '{}'{}", hand.name, choices.what,
                                            text::nearest_match_hint(choices.what, known)));
  }
  if (choices.what == "close") return;
  if (choices.force > 0) throw std::invalid_argument("--force is of close; leave it out");
  if (!choices.preshape.empty()) {
    throw std::invalid_argument("--preshape is of close; leave it out");
  }
}

RobotLink::HandGoal goal_of(const PlatformLink& robot, const RobotLink::Joints& joints,
                            const JogChoices& choices) {
  if (choices.what == "close") {
    return close_goal(*robot.link, joints, choices.preshape, choices.speed, choices.force);
  }
  return open_goal(*robot.link, joints, choices.what == "open" ? "" : choices.what, choices.speed);
}

}  // namespace

int run_hand(const JogChoices& choices) {
  if (choices.what == "list") {
    graph::Introspection graph(choices.registry);
    const FoundPlatform found = find_platform(graph, choices.platform);
    const robot::Platform platform = robot::read_platform(found.file);
    check(choices, platform.hand);
    list(found, platform);
    return 0;
  }
  notice_interrupts();
  const PlatformLink robot = link_platform("hand", choices);
  RobotLink& link = *robot.link;
  check(choices, robot.platform.hand);
  if (!choices.preshape.empty()) preshape_of(robot.platform.hand, choices.preshape);
  std::printf("hand %s of %s (%s)\n", robot.platform.hand.name.c_str(), robot.platform.name.c_str(),
              robot.found.said_by.c_str());
  // The arm is of no concern here: it may be another program's.
  RobotLink::Joints joints = link.wait_for_joints(choices.patience, RobotLink::Needed::kHand);
  if (const std::string why = link.forbidden(); !why.empty()) throw std::runtime_error(why);
  if (!link.hand_is_served(choices.patience)) {
    throw std::runtime_error(fmt::format(
        "nobody serves {}. Start the hand's driver or the simulation (`prehend node list`)",
        link.hand_action()));
  }
  link.move_hand(goal_of(robot, joints, choices));
  std::optional<RobotLink::HandEnd> end;
  bool cancelled = false;
  while (!(end = link.hand_end())) {
    if (interrupted() && !cancelled) {
      link.cancel_hand();
      cancelled = true;
    }
    std::this_thread::sleep_for(10ms);
  }
  std::this_thread::sleep_for(kFeeling);
  joints = link.joints();
  const bool closes = choices.what == "close";
  const bool done = !cancelled && (end->reached || (closes && end->blocked));
  std::string words = cancelled      ? "interrupted: it was stopped"
                      : end->blocked ? (closes ? "closed until it pressed" : "blocked on the way")
                      : end->reached ? (closes ? "closed, and touched nothing" : "done")
                                     : "not done";
  if (!done && !end->reason.empty() && !cancelled) words += ": " + end->reason;
  const std::string felt = felt_text(link);
  std::printf("%s\nat %s\n%s", words.c_str(), hand_text(link, joints).c_str(),
              felt.empty() ? "" : (felt + "\n").c_str());
  if (done) return 0;
  std::fflush(stdout);
  throw std::runtime_error(words);
}

}  // namespace prehend::tools
