#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "drivers/dsa/codec/frame.h"
#include "drivers/dsa/codec/packet.h"
#include "drivers/dsa/codec/structures.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::dsa {

struct MatrixShape {
  int cells_x = 6;
  int cells_y = 14;
  double texel_pitch = 3.4;  // mm
};

/// From "6x14" (columns x rows), "6x14@3.4" (and the texel pitch in mm).
/// @throws std::invalid_argument with what is wrong.
MatrixShape matrix_shape_from(const std::string& text);

struct ControllerOptions {
  std::vector<MatrixShape> matrices{{}, {}};
  int firmware = 300;      // below 268 it has no thresholds; up to 288 (but 269) no single frames
  double frame_rate = 30;  // 1/s, at most; the line sets a bound of its own
  double baud = 115200;    // of the line, 10 bits a byte; 0: as fast as it is read
  double start_up = 0;     // s after power-on until commands are accepted; 8 in the real device
  bool answers_errors = true;  // to unknown or damaged packets; not known of the real device
};

/// A DSACON32-m over texels that somebody sets. Like the driver it does no input or output: bytes
/// go to `send` at the moment when a line of its speed would have carried them. Faults: dead
/// texels, reboot(), silence. Call update() every few milliseconds.
class Controller {
 public:
  using Send = std::function<void(Bytes)>;
  /// @throws std::invalid_argument for impossible matrices.
  Controller(const ControllerOptions& options, Send send);

  void receive(Bytes bytes, Time now);
  void update(Time now);

  /// What the pads feel: all matrices, as in a frame. @throws std::invalid_argument for another
  /// count; values above 4095 are cut.
  void set_texels(const std::vector<std::uint16_t>& counts);
  std::size_t texels() const { return texels_.size(); }
  /// Shows 0 from now on.
  void kill_texel(std::size_t index) { dead_.insert(index); }
  /// Power off and on: forgets the stream, prints its start-up text.
  void reboot(Time now);
  void set_silent(bool silent) { silent_ = silent; }

  bool is_streaming() const { return streams_; }
  std::uint64_t frames() const { return frames_; }  // put on the line

 private:
  struct Output {
    Time due{};
    std::vector<std::uint8_t> bytes;
  };
  void take(const Packet& packet, Time now);
  void start_or_stop(const Packet& packet, Time now);
  void adjust(const Packet& packet, bool is_sensitivity, Time now);
  void answer(PacketId id, const Payload& payload, Time now);
  void answer_status(PacketId id, Status status, Time now);
  void put(std::vector<std::uint8_t> bytes, Time now);
  void put_frame(Time now);
  Payload matrix_info(std::size_t index) const;

  ControllerOptions options_;
  Send send_;
  PacketDecoder decoder_{4096};
  std::uint64_t bad_checksums_ = 0;
  std::vector<std::uint16_t> texels_;
  std::set<std::size_t> dead_;
  std::vector<float> sensitivities_;
  std::vector<std::uint16_t> thresholds_;
  std::deque<Output> outputs_;
  Time line_free_{};
  Time next_frame_{};
  Time power_on_{};
  bool is_powered_ = false;
  int greetings_ = 0;
  bool streams_ = false;
  bool run_length_ = false;
  bool silent_ = false;
  std::uint64_t frames_ = 0;
};

}  // namespace prehend::drivers::dsa
