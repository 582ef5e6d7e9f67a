#pragma once

#include <chrono>
#include <string>

namespace prehend::bench {

/// The side channel of a pair of workers (a stream socket pair): they introduce themselves with
/// lines, then the receiver acknowledges messages with single bytes. The sender's closing its end
/// ends the receiver. Not measured: what is measured goes over the transport of the row.
class Channel {
 public:
  /// Takes the descriptor over.
  explicit Channel(int descriptor) : descriptor_(descriptor) {}
  ~Channel();
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;

  /// Throws BenchError when the other side is gone.
  void write_line(const std::string& line);
  /// Throws BenchError when none comes within `timeout` or the other side is gone.
  std::string read_line(std::chrono::milliseconds timeout);

  /// One byte to the other side, from any thread. Does nothing when that is gone.
  void acknowledge();
  /// Waits for at least one acknowledgement and returns how many came. 0: `timeout`, or
  /// interrupted. Throws BenchError when the other side is gone.
  std::size_t wait_for_acknowledgement(std::chrono::milliseconds timeout);

  /// Returns when the other side has closed its end, or interrupted.
  void wait_for_end();

 private:
  int descriptor_;
};

/// Both ends of a new channel, as close-on-exec descriptors.
struct ChannelEnds {
  int sender = -1;
  int receiver = -1;
};
ChannelEnds make_channel();
/// For the process that has given both ends away.
void close_ends(const ChannelEnds& ends);

}  // namespace prehend::bench
