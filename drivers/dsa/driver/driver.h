#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/dsa/codec/frame.h"
#include "drivers/dsa/codec/packet.h"
#include "drivers/dsa/codec/structures.h"
#include "drivers/dsa/driver/lost_frames.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::dsa {

struct DriverOptions {
  bool run_length = true;  // a raw stream of six pads cannot exceed 11.7 frames/s at 115200 baud
  int frame_rate = 30;     // 1/s, asked for; the firmware streams as fast as it can
  std::optional<double> sensitivity;  // 0..1, of all matrices; nothing: as the device has it
  std::optional<int> threshold;       // counts 0..4095; nothing: as the device has it
  double reply_time = 1.0;            // s to wait for an answer (SDHLibrary)
  int tries = 4;                      // of a question (SDHLibrary)
  double start_up = 10.0;   // s of silence allowed at first: a controller needs 8 s after power-on
  double stale_time = 0.5;  // s without frame while streaming -> stale, and the stream begins anew
};

/// Where the controller's stream is. None of these states moves anything: the pads only feel.
///
/// | state         | power                         | frames                                       |
/// |---------------|-------------------------------|----------------------------------------------|
/// | kDisconnected | unknown                       | none                                         |
/// | kStopping     | unknown; it may be starting   | discarded; a stream left on is being stopped |
/// | kAsking       | on                            | discarded; configuration is read and set     |
/// | kStreaming    | on                            | handed on                                    |
/// | kStale        | unknown                       | none for stale_time; reported; begun anew    |
/// | kRefused      | on                            | none: an error was answered; begun anew      |
enum class DriverState { kDisconnected, kStopping, kAsking, kStreaming, kStale, kRefused };
const char* to_string(DriverState state);

struct Statistics {
  std::uint64_t frames = 0;      // handed on
  std::uint64_t bad_frames = 0;  // whole packets that held no valid frame
  std::uint64_t bad_checksums = 0;
  std::uint64_t lost_frames = 0;  // that never came, by the controller's time stamps
  std::uint64_t discarded = 0;    // bytes that belonged to no packet
  std::uint64_t unanswered = 0;   // questions that had to be repeated or were given up
  std::uint64_t restarts = 0;     // of the sequence, the first included
  double frame_rate = 0;          // 1/s, of the last second; 0: none
};

/// The controller as a state machine over bytes and time. It does no input or output itself: what
/// it sends goes to `send`, which returns "" or why it could not. Call update() every few ten
/// milliseconds. Not thread-safe. Same calls, same behaviour.
class Driver {
 public:
  using Send = std::function<std::string(Bytes)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  using OnFrame = std::function<void(const Frame&)>;
  /// @throws std::invalid_argument for options out of range.
  Driver(const DriverOptions& options, Send send, OnFrame on_frame, Note note);

  void connected(Time now);
  void disconnected(const std::string& why);
  void receive(Bytes bytes, Time now);
  void update(Time now);
  /// Ends the stream, so that the next client finds silence.
  void stop(Time now);

  DriverState state() const { return state_; }
  Statistics statistics() const;
  /// Why there are no frames, as it was noted; "" once a frame came, or before anything went wrong.
  const std::string& trouble() const { return trouble_; }
  const std::optional<ControllerInfo>& controller() const { return controller_; }
  /// One a matrix, in the order of the frame. Empty until known; kept over restarts.
  const std::vector<MatrixInfo>& matrices() const { return matrices_; }
  /// Index of a matrix' first texel in a frame.
  std::size_t offset(std::size_t matrix) const;

 private:
  struct Question {
    PacketId id{};
    std::vector<std::uint8_t> payload;
  };
  void begin(Time now);
  void ask(PacketId id, std::vector<std::uint8_t> payload, Time now);
  std::uint64_t damaged() const;
  void give_up(const std::string& words, Time now);
  void take_packet(const Packet& packet, Time now);
  void take_frame(const Packet& packet, Time now);
  void take_answer(const Packet& packet, Time now);
  void next_question(Time now);

  DriverOptions options_;
  Send send_;
  OnFrame on_frame_;
  Note note_;
  DriverState state_ = DriverState::kDisconnected;
  PacketDecoder decoder_;
  Frame frame_;
  std::optional<ControllerInfo> controller_;
  std::vector<MatrixInfo> matrices_, asked_matrices_;
  std::size_t matrix_count_ = 0;
  std::size_t texels_ = 0;
  int step_ = 0;  // of the sequence of questions
  std::optional<Question> question_;
  Time asked_{};
  int tries_ = 0;
  Time began_{};
  Time last_frame_{};
  Time last_byte_{};
  Time pause_until_{};
  std::vector<Time> arrivals_;  // of the last second
  LostFrames lost_frames_;
  std::uint64_t damaged_before_ = 0;  // the last good frame
  Statistics statistics_;
  std::string trouble_;
};

}  // namespace prehend::drivers::dsa
