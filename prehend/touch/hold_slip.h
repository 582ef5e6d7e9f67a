#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/text/knob.h"
#include "prehend/touch/hand_touch.h"
#include "prehend/touch/pattern_motion.h"

namespace prehend::touch {

struct HoldSlipOptions {
  double least_slide = 9e-4;  // m
  double significance = 3;
  double gain_deviation = 0.01;
  double stretch_deviation = 0.2;
  int reference_frames = 4;
  int confirming_frames = 1;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"least_slide", self.least_slide, "m", 1e-5, 0.1,
               "of what is held over the pads since the hold began, from which on it slips"});
    visit(Knob{"significance", self.significance, "", 0.1, 100,
               "standard deviations that the slide must exceed, too"});
    visit(Knob{"gain_deviation", self.gain_deviation, "", 0, 1,
               "of the texels' forces from frame to frame, relative, standard"});
    visit(Knob{"stretch_deviation", self.stretch_deviation, "", 0, 10,
               "of how far the pads' foam gives way sideways under a load, relative, standard"});
    visit(Knob{"reference_frames", self.reference_frames, "", 1, 100,
               "whose mean is what later frames are compared with"});
    visit(Knob{"confirming_frames", self.confirming_frames, "", 1, 100,
               "in a row that must say that it slips"});
  }

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What the frames of a hold say.
struct HoldSlipReading {
  bool determined = false;
  std::string reason;    // why not
  double slide = 0;      // m, of what is held over the pads since the hold began
  double deviation = 0;  // m, standard, of it
  double stretch = 0;    // m, how far the foam gives way sideways by the load: is no slide
  int pads = 0;          // that tell
  bool slips = false;
};

/// Tells whether what a hand holds slides over its pads, from their frames since the hold began.
///
/// Between the mean of the first frames and the present one the pattern of pressure moves by t
/// (PatternEquations, with weak priors so that what a pattern cannot show counts as at rest). Foam
/// gives way sideways before anything slides, by
///   e = |F - F0| / (sum over pads and touched texels of sigma0),
/// F - F0 the change of the load across the pads [N], as the wrist feels it, sigma0 the bristles'
/// stiffness of the pad's law (C. Canudas de Wit, H. Olsson, K. Astrom, P. Lischinsky, "A New Model
/// for Control of Systems with Friction", IEEE TAC 1995: before sliding friction is a spring).
/// Where no load is known, e is what friction can hold at most: sum mu_d Fn over the same. So
///   slide = max(0, |t| - e),   deviation^2 = deviation(t)^2 + (stretch_deviation e)^2,
/// t the mean of the pads' by 1 / deviation^2. What tilts between two pads moves their patterns
/// apart, what slides moves them alike: along the finger (y), and where two pads tell across it as
/// pads that face one another (x of the one is against the other's; of more the mean of |x|). By as
/// much as they disagree the deviation is larger. A direction whose variance is four times the
/// other's, and above 0.2 mm, does not count. It slips when the slide exceeds `least_slide` and
/// `significance` deviations in `confirming_frames` frames one after the other, or both twice over.
///
/// Where t is longer than part of a texel, the comparison goes on from that frame. An edge along
/// the rows that no foam blurs jumps from one row to the next, be it for a hair's breadth: a slide
/// that comes in one jump of more than 0.3 texels counts when it goes on.
///
/// Deviation(t) is that of the least squares with what they leave over, or `gain_deviation` of the
/// pattern's forces where that is more; a pad's common gain does not matter. Texels that are dead
/// (say nothing between touched ones), full or unreadable are left out. A face that covers a pad
/// shows no motion, nor does a straight edge along itself; a turn about the pad's normal is told
/// apart and is no slide. What rolls counts as sliding.
///
/// Never throws after it is made.
class HoldSlip {
 public:
  /// @throws std::invalid_argument for options out of range.
  explicit HoldSlip(const HoldSlipOptions& options = {});

  /// A hold begins: the reference is of the frames from `time` [s] on, which may be past (of the
  /// last few frames) or to come (when a force that was asked for is there).
  void begin(double time);

  /// The frames of `time` [s] of all pads, by name, one that does not grow changes nothing; and the
  /// load across the pads [N] in a frame that moves with the hand, unset: not known. A pad whose
  /// frame has another number of counts than its texels, or another pad than before, tells nothing
  /// until the next hold. @pre PadFrame::felt is not null
  const HoldSlipReading& update(double time, const std::vector<PadFrame>& frames,
                                const std::optional<Eigen::Vector3d>& load);

 private:
  struct Moment {
    double time = 0;
    std::map<std::string, PadFrame> frames;
    std::optional<Eigen::Vector3d> load;
  };
  struct Reference {
    std::shared_ptr<const FeltPad> pad;
    PatternMotion motion;
    FeltTexels felt;
    std::vector<bool> dead;
    double force = 0;  // N
    // The motion from the hold's beginning to `felt`, which is a later frame when it is long.
    Eigen::Vector2d moved = Eigen::Vector2d::Zero();     // m
    Eigen::Vector2d variance = Eigen::Vector2d::Zero();  // m^2
  };
  struct Stretch {
    double stiffness = 0, holds = 0;  // N/m, N
  };
  void make_reference();
  void add_stretch(const Reference& reference, const FeltTexels& now, Stretch* stretch) const;
  struct Shift {
    Eigen::Vector2d moved;     // m, of the pattern since the hold began, along P's x and y
    Eigen::Vector2d variance;  // m^2, of each
  };
  /// None: the pattern does not show it.
  std::optional<Shift> shift_of(const FeltTexels& now, Reference* reference) const;
  /// How far what is held has moved [m], and its variance [m^2].
  static double common_motion(const std::vector<Shift>& shifts, double* variance);
  /// Whether the slide is more than one jump of an edge from one row of texels to the next.
  bool goes_on(double slide, double distance);

  HoldSlipOptions options_;
  double begin_ = 0;  // s
  bool begun_ = false;
  std::deque<Moment> moments_;  // the last reference_frames
  std::map<std::string, Reference> references_;
  std::optional<Eigen::Vector3d> load_;  // of the reference
  int in_a_row_ = 0;
  double last_slide_ = 0, jump_ = 0, jumped_to_ = 0;  // m
  HoldSlipReading reading_;
};

}  // namespace prehend::touch
