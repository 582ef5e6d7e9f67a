#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/camera/driver/delivery_rate.h"
#include "drivers/camera/transport/frame_pairing.h"
#include "drivers/camera/transport/frame_source.h"

namespace prehend::drivers::camera {

/// What the sources give.
enum class CameraKind {
  kMono,        // one source, one image
  kTwo,         // two sources, one image each: pairs by FramePairing
  kSideBySide,  // one source whose images are the left one beside the right one
};

struct CameraOptions {
  CameraKind kind = CameraKind::kMono;
  double most_rate = 0;       // 1/s of views handed on, at most; 0: each
  double pair_tolerance = 0;  // s between the two of a pair, 0: half a frame of the first source
  bool loop = false;          // files begin anew at their end
  double exposure = -1;       // s; 0: by the device, -1: as it is
  double gain = -1;           // device's unit; 0: by the device, -1: as it is
  double stale_time = 1;      // s without a view that are told
  double retry = 0.5;         // s between tries to open a source
  double grace = 2;           // s at first in which one that cannot be opened is not told
};

/// What was seen at one instant.
struct CameraView {
  geometry::ColorImage left;                  // or of the one camera
  std::optional<geometry::ColorImage> right;  // of pairs
  Time stamp{};                               // of the left image, by steady_now()
  bool is_stamped_by_device = false;
};

struct CameraStatistics {
  std::uint64_t views = 0;                  // handed on, or left out for most_rate
  std::array<std::uint64_t, 2> frames{};    // that came, by source
  std::array<std::uint64_t, 2> unpaired{};  // dropped without a partner
  std::uint64_t lost = 0;                   // sources that went away
  std::uint64_t connections = 0;            // sources that were opened
};

/// Splits an image into its left and right half. @throws std::invalid_argument for an odd width.
CameraView split_side_by_side(const Frame& frame);

/// A camera of one or two sources: a thread each opens it, takes frames, and opens it again when it
/// is gone (hot unplug and replug). A camera moves nothing, so there is nothing to stop; when a
/// source of a pair is gone no views come, and what waited for it is dropped.
///
/// Trouble is a state: what is wrong for as long as it lasts, "" when views come.
class CameraDevice {
 public:
  /// Opens source 0 (left) or 1 (right); a file's first frame is due at `start`.
  /// @throws std::runtime_error (geometry::InputError among them) when it cannot.
  using Open = std::function<std::unique_ptr<FrameSource>(std::size_t source, Time start)>;
  using OnView = std::function<void(CameraView view)>;
  using Note = std::function<void(bool is_problem, const std::string& words)>;

  /// `on_view` and `note` are called by the threads, one at a time each.
  /// @throws std::invalid_argument for options that cannot be.
  CameraDevice(const CameraOptions& options, Open open, OnView on_view, Note note);
  /// Waits for the sources to return, which is at most their silence.
  ~CameraDevice();

  /// Acts on the next frames of all sources; -1: leaves it as it is.
  void set_exposure(double seconds);
  void set_gain(double gain);

  CameraStatistics statistics() const;
  /// What is wrong; "" while views come.
  std::string trouble() const;
  /// What is not as asked for, though views come: a control that a device does not have.
  std::string remark() const;
  /// All sources are files that are over.
  bool is_at_end() const;

 private:
  struct Side {
    std::string trouble, remark;  // of the source, as told
    bool is_open = false;
    bool is_at_end = false;
    double rate = 0;
    std::uint64_t round = 0;  // how often its file began anew
  };

  void run(std::size_t index);
  void take(std::size_t index, Frame frame);
  void deliver(CameraView view);
  void set_controls(std::size_t index, FrameSource& source, std::uint64_t& known);
  void lose(std::size_t index, const std::string& words);
  void begin_anew_at_end(std::size_t index, FrameSource& source, std::uint64_t& round);
  void say(bool is_problem, const std::string& words);

  CameraOptions options_;
  Open open_;
  OnView on_view_;
  Note note_;
  Time begun_{};

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  std::vector<Side> sides_;
  std::optional<FramePairing<Frame>> pairing_;
  CameraStatistics statistics_;
  std::optional<Time> last_view_;  // when it came
  Time start_{};                   // of files
  double exposure_, gain_;
  std::uint64_t controls_ = 1;  // counts changes of exposure and gain

  std::mutex note_mutex_, view_mutex_;
  DeliveryRate delivery_;  // guarded by view_mutex_
  std::atomic<bool> ends_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace prehend::drivers::camera
