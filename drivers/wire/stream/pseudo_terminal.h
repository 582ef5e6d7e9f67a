#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers {

/// The device's end of an emulated serial line. The driver opens name() as any serial device.
/// Thread-safe.
class PseudoTerminal : public ByteStream {
 public:
  /// `link`: if not empty, a symbolic link of this name is kept to the line, whose own name changes
  /// (/dev/pts/N); something else of that name is not replaced.
  /// @throws geometry::InputError when there is no pseudo-terminal or the link cannot be made.
  explicit PseudoTerminal(std::string link = {});
  ~PseudoTerminal() override;
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  /// What the driver opens: the link, else /dev/pts/N.
  const std::string& name() const override { return link_.empty() ? first_name_ : link_; }
  /// As when the adapter is pulled out: who has the line open gets errors, the link is gone.
  void unplug();
  /// A new line under the same link.
  void plug();
  /// The rate [bit/s] that whoever has opened the line has set; 0: none that is known here.
  unsigned baud() const;
  bool plugged() const { return line_now() != nullptr; }

  /// Unplugged: nothing is read (kTimeout after the whole time), and what is written is lost.
  IoResult read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) override;
  IoResult write(Bytes bytes, std::chrono::nanoseconds timeout) override;

 private:
  struct Line;
  std::shared_ptr<const Line> line_now() const {
    const std::lock_guard lock(mutex_);
    return line_;
  }

  std::string link_, first_name_;
  mutable std::mutex mutex_;
  std::shared_ptr<const Line> line_;  // null: unplugged; closed when the last reader has left it
};

}  // namespace prehend::drivers
