#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/barrett/codec/gcl/line.h"
#include "drivers/barrett/codec/gcl/real_time.h"
#include "drivers/barrett/codec/gearing.h"
#include "drivers/barrett/emulator/clutch_hand.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett::gcl {

struct HandOptions {
  HandPlant* plant = nullptr;  // that it moves; outlives the hand
  Gearing gearing = {.counts_per_turn = 360};
  Firmware firmware = Firmware::k4_3;
  unsigned baud = kBaud;        // as stored: after power-on and RESET
  bool is_initialised = false;  // at power-on, as if HI had been done
  bool prints_abort = true;     // Ctrl-C in RealTime mode or idle says ERR 16384; not confirmed
  int velocity_factor = 1;      // of LCV's unit: 1 (BHAPI), or 16 (MAN43)
  double most_command = 127;    // motor command at which its motors give their most
  double strain_range = 100;    // counts of SG from its rest at a motor's most
  double boot_time = 1;         // s from power-on to the banner; not published
  double room = 25;             // degree Celsius
  double hot = 65;              // degree Celsius, OTEMP; its default is not published
  std::function<unsigned()> host_baud = {};  // as set_host_baud, asked for at each look
};

/// A BH8-262's controller over a plant, as far as Barrett's manuals and software show it. Like
/// Driver it does no input or output: bytes go to `send` when a line of its rate would have carried
/// them. Call update() every few milliseconds.
class Hand {
 public:
  using Send = std::function<void(Bytes)>;
  /// @throws std::invalid_argument without a plant.
  Hand(const HandOptions& options, Send send);

  void receive(Bytes bytes, Time now);
  void update(Time now);
  /// The rate at which the host sends and reads; another one than the hand's makes garbage of
  /// either. 0: the hand's own, whatever it is (a line that has none).
  void set_host_baud(unsigned baud) { host_baud_ = baud; }

  // Faults.
  /// Power off and on: as RESET, which ends in the banner.
  void reboot(Time now);
  /// Nothing that it says arrives; it goes on moving.
  void set_mute(bool mute) { is_mute_ = mute; }
  /// Its answers have no prompt, or come so many seconds late.
  void set_prompts(bool on) { has_prompts_ = on; }
  void set_delay(double seconds) { delay_ = seconds; }
  /// Of what comes next: a byte of an echo gets lost, a feedback block has a wrong byte (that at
  /// `place`) or misses its last.
  void lose_echo(int count = 1) { lost_echoes_ = count; }
  void garble_blocks(int count, std::size_t place = 2) {
    garbled_blocks_ = count;
    garbled_place_ = place;
  }
  void shorten_blocks(int count) { short_blocks_ = count; }
  /// Commands and blocks are answered by this ERR; 0: none.
  void set_refusal(int code) { refusal_ = code; }
  /// Neither carries out nor answers this command.
  void set_deaf_to(std::optional<std::string> command) { deaf_to_ = std::move(command); }
  /// Ctrl-C is answered, but the motors go on, whatever blocks say.
  void set_running_on(bool on) { runs_on_ = on; }
  void set_temperature(double celsius) { temperature_ = celsius; }
  /// SG of fingers is 255: there are no gauges.
  void set_gauges(bool on) { has_gauges_ = on; }

  // What is seen of it.
  const HandPlant::Motion& motion() const { return motion_; }
  bool is_moving() const;
  bool is_looping() const { return state_ == State::kInLoop; }
  bool is_initialised() const;
  unsigned baud() const { return baud_; }
  int property(std::size_t motor, const std::string& name) const;
  std::uint64_t moves() const { return moves_; }    // HI, LOOP and moves that were carried out
  std::uint64_t aborts() const { return aborts_; }  // Ctrl-C
  std::uint64_t blocks() const { return blocks_; }  // control blocks that were answered

 private:
  enum class State { kBooting, kIdle, kRunning, kInLoop };
  /// What a motor does.
  struct Motor {
    enum class Task { kOff, kHold, kVelocity, kPosition, kInitialise } task = Task::kOff;
    std::map<std::string, int> active, stored;
    double zero = 0;                             // rad of the plant, that is P = 0
    double reference = 0, velocity = 0;          // counts, counts/s
    double target = 0;                           // counts
    double share = 1;                            // of its most torque
    double standing_at = 0, standing_since = 0;  // counts; s, plant
    int told = 0;                                // counts that LFDP counts from
    bool must_arrive = false;                    // or ERR 16
  };
  struct Output {
    Time due{};
    std::vector<std::uint8_t> bytes;
  };
  using Words = std::vector<std::string>;

  // hand.cpp: the line
  void put(std::string_view text, Time now, double delay = 0);
  void put(std::vector<std::uint8_t> bytes, Time now, double delay = 0);
  void take(char c, Time now);
  void abort(Time now);
  void answer(int error, const Words& lines, Time now);
  void take_block(Time now);
  void end_loop(int error, Time now);
  Feedback feedback();

  // hand_commands.cpp
  void power_on();
  void carry_out(const Request& request, Time now);
  int move(const Request& request, const std::array<bool, kAxes>& motors);
  int get_or_set(const Request& request, Words& lines);
  int get_or_set_global(const Request& request, Words& lines);
  int copy_properties(const std::string& command, const std::array<bool, kAxes>& motors);
  int begin_loop(const std::array<bool, kAxes>& motors);
  std::array<bool, kAxes> motors_of(const Request& request) const;
  int value_of(std::size_t motor, const std::string& name);

  // hand_motors.cpp
  double position(std::size_t motor) const;  // counts
  int strain(std::size_t motor) const;
  void begin_move(std::size_t motor, double target, bool must_arrive);
  void control(const Controls& controls);
  void switch_off(std::size_t motor);
  void hold_or_off(std::size_t motor);
  void advance_motor(std::size_t motor, double seconds);
  void look_at_motor(std::size_t motor);
  void watch_run(Time now);
  void command_plant();

  HandOptions options_;
  Send send_;
  std::array<Motor, kAxes> motors_;
  std::map<std::string, int> globals_, stored_globals_;
  State state_ = State::kBooting;
  Layout layout_;
  std::string line_;                 // that is being typed
  std::vector<std::uint8_t> block_;  // that is being sent by the host
  std::deque<Output> outputs_;
  Time line_free_{}, boots_until_{}, last_update_{};
  bool is_updated_ = false;
  int run_error_ = 0;
  bool spread_waits_ = false;  // of HI, until the fingers are open
  HandPlant::Motion motion_;
  unsigned baud_ = kBaud, host_baud_ = 0;
  std::optional<unsigned> next_baud_;
  double temperature_ = 25;
  bool is_mute_ = false, has_prompts_ = true, has_gauges_ = true, runs_on_ = false;
  double delay_ = 0;
  int lost_echoes_ = 0, garbled_blocks_ = 0, short_blocks_ = 0, refusal_ = 0;
  std::size_t garbled_place_ = 2;
  std::optional<std::string> deaf_to_;
  std::uint64_t moves_ = 0, aborts_ = 0, blocks_ = 0;
};

}  // namespace prehend::drivers::barrett::gcl
