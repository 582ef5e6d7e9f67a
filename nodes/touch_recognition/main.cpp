#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "msgs/convert/pad_touch.h"
#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/touch.pb.h"
#include "nodes/hand_pads/hand_pads.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/touch/touch_memory.h"

namespace {

using namespace prehend;

struct Settings {
  touch::RecogniseBy by = touch::RecogniseBy::kGrasp;
  std::string memory;
  std::vector<std::string> pads;  // empty: all
  double least_force = 1;         // N
  double stale_time = 0.5;        // s
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  const auto by = node.declare_parameter<std::string>(
      {.name = "by",
       .default_value = "grasp",
       .choices = {"grasp", "imprint"},
       .description = "grasp: things by how far the hand closes and what its pads feel; imprint: "
                      "faces by the pattern that they leave on a pad",
       .read_only = true});
  s.by = by == "imprint" ? touch::RecogniseBy::kImprint : touch::RecogniseBy::kGrasp;
  s.memory = node.declare_parameter<std::string>(
      {.name = "memory",
       .description = "file of what was taught: read at the start where it is there, written by "
                      "/touch_recognition/save; empty: none",
       .read_only = true});
  s.pads = node.declare_parameter<std::vector<std::string>>(
      {.name = "pads",
       .description = "pads that count; empty: all. By imprint those that touch the same face, "
                      "e.g. [left]: the other one has another face before it",
       .read_only = true});
  s.least_force = node.declare_parameter<double>({.name = "least_force",
                                                  .default_value = s.least_force,
                                                  .unit = "N",
                                                  .minimum = 0.0,
                                                  .maximum = 1000.0,
                                                  .description = "of a pad that counts as touching",
                                                  .read_only = true});
  s.stale_time = node.declare_parameter<double>(
      {.name = "stale_time",
       .default_value = s.stale_time,
       .unit = "s",
       .minimum = 0.01,
       .maximum = 60.0,
       .description = "age of the newest frame or posture from which on it is not the present one",
       .read_only = true});
  return s;
}

class TouchRecognition {
 public:
  TouchRecognition(graph::Node& node, const Settings& settings, const nodes::HandPads& hand)
      : node_(node),
        settings_(settings),
        hand_(hand),
        platform_(hand.platform()),
        memory_(settings.by),
        answers_(node.advertise<msgs::TouchAnswer>("/recognised", graph::QoS::latched(1))) {
    if (platform_.hand.pads.empty()) {
      throw geometry::InputError("The hand of " + platform_.name + " has no tactile pads",
                                 "Name a platform with pads, e.g. stage_pg70 or kr5_sdh");
    }
    for (const std::string& name : settings.pads) check_pad(name);
    if (!settings.memory.empty() && std::filesystem::exists(settings.memory)) {
      memory_ = touch::TouchMemory::load(settings.memory, settings.by);
      node.log_info("{} things are known from {}", memory_.things().size(), settings.memory);
    }
    listen();
    serve();
  }

 private:
  void check_pad(const std::string& name) const {
    std::vector<std::string> known;
    for (const robot::HandPad& pad : platform_.hand.pads) known.push_back(pad.name);
    if (std::ranges::find(known, name) != known.end()) return;
    throw geometry::InputError(
        fmt::format("'{}' is no pad of {}", name, platform_.name),
        fmt::format("The parameter pads may name {}", fmt::join(known, ", ")));
  }

  bool matters(const std::string& pad) const {
    return settings_.pads.empty() || std::ranges::find(settings_.pads, pad) != settings_.pads.end();
  }

  void listen() {
    for (const robot::HandPad& pad : platform_.hand.pads) {
      subscriptions_.push_back(node_.subscribe<msgs::TactileFrame>(
          "/tactile/" + pad.name, graph::QoS::queue(1),
          [this, name = pad.name](const auto& frame) { frames_[name] = *frame; }));
    }
    if (hand_.is_gripper()) {
      subscriptions_.push_back(
          node_.subscribe<msgs::GripperState>("/gripper/state", graph::QoS::queue(1),
                                              [this](const auto& state) { opening_ = *state; }));
    } else {
      subscriptions_.push_back(node_.subscribe<msgs::JointState>(
          "/joint_states", graph::QoS::queue(1), [this](const auto& state) { joints_ = *state; }));
    }
  }

  void serve() {
    services_.push_back(node_.serve<msgs::NamedThing, msgs::TouchMemory>(
        "/touch_recognition/teach", [this](const msgs::NamedThing& thing) {
          return change([&] {
            memory_.teach(thing.name(), present());
            node_.log_info("taught '{}': {} presses", thing.name(),
                           memory_.things().at(thing.name()).size());
          });
        }));
    services_.push_back(node_.serve<msgs::NamedThing, msgs::TouchMemory>(
        "/touch_recognition/forget", [this](const msgs::NamedThing& thing) {
          return change([&] {
            if (!memory_.forget(thing.name())) {
              throw std::invalid_argument("'" + thing.name() + "' is not known");
            }
          });
        }));
    services_.push_back(node_.serve<msgs::TouchMemoryFile, msgs::TouchMemory>(
        "/touch_recognition/save", [this](const msgs::TouchMemoryFile& file) {
          return change([&] { memory_.save(file_of(file)); });
        }));
    services_.push_back(node_.serve<msgs::TouchMemoryFile, msgs::TouchMemory>(
        "/touch_recognition/load", [this](const msgs::TouchMemoryFile& file) {
          return change([&] { memory_ = touch::TouchMemory::load(file_of(file), settings_.by); });
        }));
    services_.push_back(node_.serve<msgs::TouchQuestion, msgs::TouchAnswer>(
        "/touch_recognition/ask",
        [this](const msgs::TouchQuestion& question) { return ask(question); }));
  }

  // Does `work` and says what is known then, or why it could not be done.
  template <class Work>
  msgs::TouchMemory change(const Work& work) {
    msgs::TouchMemory answer;
    try {
      work();
      answer.set_success(true);
    } catch (const std::exception& error) {
      answer.set_reason(error.what());
    }
    for (const auto& [name, presses] : memory_.things()) {
      msgs::TouchMemory::Thing& thing = *answer.add_things();
      thing.set_name(name);
      thing.set_presses(static_cast<std::uint32_t>(presses.size()));
    }
    return answer;
  }

  std::string file_of(const msgs::TouchMemoryFile& file) const {
    if (!file.file().empty()) return file.file();
    if (!settings_.memory.empty()) return settings_.memory;
    throw std::invalid_argument("which file? Name one, or start with memory:=FILE");
  }

  msgs::TouchAnswer ask(const msgs::TouchQuestion& question) {
    msgs::TouchAnswer answer;
    answer.mutable_header()->set_stamp(node_.clock().now());
    try {
      if (!question.more()) asked_.clear();
      asked_.push_back(present());
      answer.set_presses(static_cast<std::uint32_t>(asked_.size()));
      const touch::Recognised found = memory_.ask(asked_);
      answer.set_success(true);
      answer.set_name(found.name);
      answer.set_reason(found.reason);
      for (const touch::Candidate& candidate : found.candidates) {
        msgs::TouchAnswer::Candidate& out = *answer.add_candidates();
        out.set_name(candidate.name);
        out.set_misfit(candidate.misfit);
      }
    } catch (const std::exception& error) {
      answer.set_reason(error.what());
    }
    answers_.publish(answer);
    return answer;
  }

  template <class Message>
  void check_age(const Message& message, const std::string& topic) const {
    const double age = graph::seconds(node_.clock().now() - message.header().stamp());
    if (age > settings_.stale_time) {
      throw std::runtime_error(fmt::format("the newest message of {} is {:.1f} s old", topic, age));
    }
  }

  // What the hand feels now.
  touch::RememberedPress present() const {
    std::vector<touch::FeltPad> pads;
    std::vector<touch::FeltFrame> frames;
    pads.reserve(platform_.hand.pads.size());
    for (const robot::HandPad& pad : platform_.hand.pads) {
      if (!matters(pad.name)) continue;
      const auto found = frames_.find(pad.name);
      if (found == frames_.end()) {
        throw std::runtime_error("nobody has published /tactile/" + pad.name + " yet");
      }
      check_age(found->second, "/tactile/" + pad.name);
      pads.push_back(hand_.felt(pad, found->second));
      std::vector<double> counts = convert::counts_of(found->second);
      double force = 0;  // N
      for (const double count : counts) force += count * pads.back().newton_per_count;
      if (force >= settings_.least_force) frames.push_back({&pads.back(), std::move(counts)});
    }
    return touch::remembered(posture(), frames);
  }

  Eigen::VectorXd posture() const {
    if (hand_.is_gripper()) {
      if (!opening_) throw std::runtime_error("nobody has published /gripper/state yet");
      check_age(*opening_, "/gripper/state");
      return Eigen::VectorXd::Constant(1, opening_->opening());
    }
    if (!joints_) throw std::runtime_error("nobody has published /joint_states yet");
    check_age(*joints_, "/joint_states");
    const std::vector<std::string> names = platform_.hand.actuated_names();
    Eigen::VectorXd positions(static_cast<Eigen::Index>(names.size()));
    for (std::size_t k = 0; k < names.size(); ++k) {
      positions[static_cast<Eigen::Index>(k)] = position_of("hand_" + names[k]);
    }
    return positions;
  }

  double position_of(const std::string& joint) const {
    for (int i = 0; i < std::min(joints_->name_size(), joints_->position_size()); ++i) {
      if (joints_->name(i) == joint) return joints_->position(i);
    }
    throw std::runtime_error("/joint_states says nothing of joint '" + joint + "'");
  }

  graph::Node& node_;
  Settings settings_;
  const nodes::HandPads& hand_;
  const robot::Platform& platform_;
  touch::TouchMemory memory_;
  std::map<std::string, msgs::TactileFrame> frames_;
  std::optional<msgs::GripperState> opening_;
  std::optional<msgs::JointState> joints_;
  std::vector<touch::RememberedPress> asked_;
  graph::Publisher<msgs::TouchAnswer> answers_;
  std::vector<graph::Service> services_;
  std::vector<graph::Subscription> subscriptions_;  // last: they end before the rest goes
};

void run(graph::Node& node) {
  const Settings settings = declare_settings(node);
  const nodes::HandPads hand(node);
  const TouchRecognition recognition(node, settings, hand);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"touch_recognition",
     "Recognises by touch what it was taught. Takes /tactile/PAD and /gripper/state (a hand's "
     "/joint_states); offers the services /touch_recognition/teach (what the hand holds now is one "
     "press of the named thing), /touch_recognition/ask, also published on /recognised, "
     "/touch_recognition/forget, /touch_recognition/save and /touch_recognition/load."},
    run);

}  // namespace
