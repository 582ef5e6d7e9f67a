#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "drivers/wire/time/time.h"
#include "prehend/geometry/image.h"

namespace prehend::drivers::camera {

/// A source has no more to give: unplugged, silent, its stream cut. The words say which; another
/// one may be opened.
class SourceLost : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Frame {
  geometry::ColorImage image;
  /// When it was taken, by the clock of steady_now(): as the device says where it does, else when
  /// it arrived; of a file, when it is due.
  Time stamp{};
  bool is_stamped_by_device = false;
};

/// Where frames come from: a device, a file, a stream. For one thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Waits for the next frame; of a file until it is due. Nothing when `patience` passed, or at a
  /// file's end. @throws SourceLost
  virtual std::optional<Frame> next(Time patience) = 0;
  virtual bool is_at_end() const { return false; }
  /// Begins anew with the first frame due at `start`; false where there is no beginning.
  virtual bool rewind(Time /*start*/) { return false; }
  /// 1/s, 0: it does not say.
  virtual double rate() const = 0;
  /// "/dev/video0: 640 x 480, 30/s", for the log.
  virtual const std::string& name() const = 0;
  /// Exposure time [s] and gain [the device's unit]; 0: by the device itself. Returns what it would
  /// not do, in words; "" when it did.
  virtual std::string set_exposure(double seconds) = 0;
  virtual std::string set_gain(double gain) = 0;
};

}  // namespace prehend::drivers::camera
