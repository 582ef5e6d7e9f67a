#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/felt_pad.h"
#include "prehend/touch/pattern_motion.h"

namespace prehend::touch {

/// What a texel's contact does. kUnknown: it is touched, and frames do not tell.
enum class TexelSlip : unsigned char { kFree, kSticks, kSlips, kUnknown };

struct SlipOptions {
  double window = 0.1;       // s, > 0, over which frames are compared
  double least_slip = 3e-4;  // m, > 0, in that time, below it a texel sticks
  /// m, > 0: where the motion's standard deviation is larger it is not determined.
  double largest_deviation = 3e-4;
  double gain_deviation = 0.02;  // of the forces from frame to frame, relative
};

/// How the pattern on a pad moved over the window.
struct SlipReading {
  bool determined = false;
  std::string reason;                                // why not
  double duration = 0;                               // s, between the compared frames
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();   // m, along P's x and y, at `center`
  double turn = 0;                                   // rad about P's z
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // m
  double deviation = 0;                              // m, standard, of the shift
  std::vector<TexelSlip> texels;
  int slipping = 0;
};

/// Tells slip from frames alone, for pads that feel no tangential force: the pattern of pressure
/// moves over the pad as the object does. The motion between two frames is by least squares of
/// PatternEquations. A pattern without gradients, as a face that covers the pad,
/// shows no motion: not determined. What rolls on the pad moves its pattern too and counts as slip.
/// Sharp edges between texels jump from one to the next: motions below the texels' distance are
/// seen where the foam blurs edges or the surface is rounded.
class SlipWatch {
 public:
  /// @throws std::invalid_argument naming the option that is not positive and finite.
  explicit SlipWatch(FeltPad pad, const SlipOptions& options = {});

  const FeltPad& pad() const { return pad_; }

  /// The frame of `time` [s]; what came in the window before is compared with it. A time that does
  /// not grow begins anew. @throws std::invalid_argument for another number of counts than texels.
  SlipReading update(double time, const std::vector<double>& counts);

 private:
  struct Frame {
    double time;
    FeltTexels felt;
  };
  void compare(const Frame& then, const Frame& now, SlipReading* reading) const;

  FeltPad pad_;
  SlipOptions options_;
  PatternMotion motion_;
  std::deque<Frame> frames_;
};

}  // namespace prehend::touch
