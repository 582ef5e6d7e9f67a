#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <string>
#include <thread>

#include "msgs/actions.pb.h"
#include "msgs/safety.pb.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What every node that moves something has of the emergency stop: it listens to /emergency_stop,
/// stops what it moves when that says so, and refuses motions until it is reset.
///
/// Where no node emergency_stop was ever heard nothing is stopped and nothing refused. Once one was
/// heard, its silence for as long as the listener bears is a stop, too, which only a reset of the
/// node that is there then ends. A node that was started anew, and knows nothing of the stop
/// before, is asked to stop: a stop outlives whoever said it.
///
/// Messages are taken among the node's callbacks: one that waits delays the stop by as long. It
/// says so by a Wait, that its wait may not be taken for silence.
class EmergencyStopListener {
 public:
  /// The node repeats its word every 20 ms. Counted in looks of 20 ms, so that a process that was
  /// held up as a whole has not heard silence meanwhile.
  static constexpr std::chrono::milliseconds kSilence{300};
  /// Of who moves nothing real: a machine that computes for many is busy for longer than that, and
  /// what goes as fast as it can, or is moved by others, keeps no time that silence could harm.
  static constexpr std::chrono::milliseconds kSilenceOfNothingReal{3000};

  /// `is_minded` false: nothing is ever refused, as somebody else minds it, who moves this by wire.
  /// `silence` is a multiple of 20 ms.
  explicit EmergencyStopListener(graph::Node& node, bool is_minded = true,
                                 std::chrono::milliseconds silence = kSilence);
  ~EmergencyStopListener();
  EmergencyStopListener(const EmergencyStopListener&) = delete;
  EmergencyStopListener& operator=(const EmergencyStopListener&) = delete;

  /// Why motions are refused, in words that name who stopped; "": they are not. Any thread. Who
  /// begins a motion looks here while nobody else can stop it (under the lock that stops take), or
  /// looks again once it has begun.
  std::string refusal() const;

  /// Holds what on_stop() gave: destroying it ends that, and waits for a call that runs.
  class Action {
   public:
    Action() = default;
    ~Action() { end(); }
    Action(Action&& other) noexcept { *this = std::move(other); }
    Action& operator=(Action&& other) noexcept;

   private:
    friend class EmergencyStopListener;
    using Stop = std::function<void(const std::string& why)>;
    void end();

    EmergencyStopListener* listener_ = nullptr;
    std::list<Stop>::iterator place_;
  };
  /// `stop` is called with the words of refusal(), which is in force by then, whenever all motion
  /// is to stop: once for each stop, and again when somebody asks anew. It does not wait for what
  /// it stops. In the node's thread of callbacks, or one of the listener's own.
  [[nodiscard]] Action on_stop(Action::Stop stop);

  /// For drivers, several times a second: why the device stands still by itself or cannot be
  /// reached, so that everything else is to stop; "": it can move. A stop is asked for when that
  /// begins, and its reset is refused for as long as it goes on. One thread.
  void tell_device(const std::string& problem);

  /// As long as one lives, silence is not counted: a callback waits.
  class Wait {
   public:
    explicit Wait(EmergencyStopListener& listener) : listener_(listener) { ++listener_.waits_; }
    ~Wait() { --listener_.waits_; }
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;

   private:
    EmergencyStopListener& listener_;
  };

 private:
  void take(const msgs::EmergencyStop& message);
  void stop(const std::string& why);
  void ask(const std::string& reason, bool persists);
  void watch();
  void look();

  graph::Node& node_;
  const std::chrono::milliseconds silence_;
  graph::ServiceClient<msgs::EmergencyStopRequest, msgs::Acknowledge> ask_;

  mutable std::mutex mutex_;  // guards what follows
  std::string refusal_;       // "": motions are allowed
  bool heard_ = false;
  bool is_told_ = false;     // the node said what refusal_ says, and knows it
  std::uint64_t count_ = 0;  // of the node, as it said last
  int silent_looks_ = 0;
  std::chrono::steady_clock::time_point asked_{};

  std::mutex actions_mutex_;  // guards what follows, and is held while they are called
  std::list<Action::Stop> actions_;

  std::atomic<int> waits_ = 0;
  std::mutex end_mutex_;  // guards what follows
  std::condition_variable end_;
  bool ends_ = false;
  std::thread watch_;  // from the first message on
  graph::Subscription subscription_;
};

}  // namespace prehend::nodes
