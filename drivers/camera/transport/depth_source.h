#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/transport/frame_source.h"
#include "prehend/geometry/camera_model.h"

namespace prehend::drivers::camera {

/// Depth and colour of one instant.
struct DepthView {
  geometry::DepthImage depth;      // m, NaN where unknown
  geometry::ColorImage color;      // of the depth's size and view, or empty
  geometry::PinholeCamera camera;  // as the device says
  double unit = 1e-3;              // m per count of the device
  Time stamp{};                    // of the depth, by steady_now()

  /// It has its stamp alone.
  bool is_empty() const { return depth.empty(); }
};

struct OpenniOptions {
  /// URI of an OpenNI2 device, a recording `.oni`, or "": the only device that is plugged in.
  std::string uri = {};
  int width = 0;  // pixels of the depth image to ask for; 0: as it is
  int height = 0;
  double rate = 0;  // 1/s to ask for; 0: as it is
  bool color =
      true;  // also colour, registered: the device draws depth as its colour camera sees it
  bool loop = false;     // a recording begins anew at its end
  double exposure = -1;  // s of the colour camera; 0: by the device, -1: as it is
  double gain = -1;      // device's unit; 0: by the device, -1: as it is
};

/// A depth camera through OpenNI2. For one thread.
class DepthSource {
 public:
  virtual ~DepthSource() = default;
  /// Whether somebody wants the view of a stamp (by steady_now()).
  using IsWanted = std::function<bool(Time stamp)>;
  /// Waits for the next depth image, and the colour within half a frame of it; nothing when
  /// `patience` passed, or at a recording's end. Of one that is not wanted the stamp alone, as
  /// copying thirty images a second costs more than all else here. Without `is_wanted` all are.
  /// @throws SourceLost
  virtual std::optional<DepthView> next(Time patience, const IsWanted& is_wanted = {}) = 0;
  virtual bool is_at_end() const = 0;
  /// 1/s of the depth stream.
  virtual double rate() const = 0;
  virtual const std::string& name() const = 0;
  /// What it would not do of exposure and gain, in words; "" when it did.
  virtual const std::string& refused() const = 0;
  /// Depth and colour images that came without a partner.
  virtual std::uint64_t unpaired() const = 0;
};

/// @throws geometry::InputError naming the device, what is wrong, and the mend: none plugged in (or
/// several, with their URIs), no such one, no depth, no such mode, no registration.
std::unique_ptr<DepthSource> open_openni_source(const OpenniOptions& options);

/// What OpenNI2 lists: "URI (vendor name)". Recordings and devices that are opened by name are not
/// among them. @throws geometry::InputError when OpenNI2 has no drivers.
std::vector<std::string> openni_devices();

}  // namespace prehend::drivers::camera
