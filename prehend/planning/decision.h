#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/grasp.h"
#include "prehend/surface/object_model.h"
#include "prehend/text/knob.h"

// What is to be done with an object next: to grasp it, to feel it first, to look at it from another
// side, or to leave it; by what each is worth.
namespace prehend::planning {

/// From 1: a message with 0 does not say.
enum class Act {
  kGrasp = 1,  // and lift it
  kTouch,      // close gently, let go, and plan again by where the hand stopped
  kLook,       // from where its shape can be told
  kGiveUp,
  kProbe,  // a fingertip goes to where most is to be learnt; plan again by where it was stopped
};
/// "grasp", "touch", "look", "give up", "probe".
const char* to_string(Act act);

/// What acts cost and bring. Value and costs are of one unit, seconds: what is worth a minute is
/// what one would work for a minute to get.
struct DecisionOptions {
  double value = 120;   // s, > 0, of an object that is lifted
  double attempt = 20;  // s, > 0, of an attempt that succeeds
  double failure = 30;  // s, >= 0, of one that fails, beyond that: what is felled or moved
  /// s, > 0, of feeling it first, with a hand or one fingertip, and the new look and plan after it.
  double touch = 15;
  /// s, > 0, of a look with the camera that the arm carries, with the new plan after it.
  double look = 12;
  int attempts = 3;  // >= 1, with one object
  int touches = 1;   // >= 0, of one object
  int looks = 1;     // the same, from elsewhere than it was seen from
  /// Of success where a grasp holds in none of its disturbed trials, and in all: in between it is
  /// in proportion. Measured: docs/planning.md, "Decide".
  double success_of_none = 0.835;
  double success_of_all = 0.965;
  double stop_deviation_angle = 0.05;     // rad, > 0, standard, of where a motor stops on a shape
  double stop_deviation_length = 0.0015;  // m, > 0, the same of a jaw
  double stop_deviation_probe = 0.004;    // m, > 0, the same of a hand that goes straight
  /// m, > 0, the same of what a look shows of a surface, all of it together: the error of where the
  /// camera is said to be, and of its depth that many pixels share.
  double look_deviation = 0.002;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"value", self.value, "s", 0.001, 1e6, "that a lifted object is worth"});
    visit(Knob{"attempt_cost", self.attempt, "s", 0.001, 1e6, "of an attempt that succeeds"});
    visit(Knob{"failure_cost", self.failure, "s", 0, 1e6, "of one that fails, beyond that"});
    visit(Knob{"touch_cost", self.touch, "s", 0.001, 1e6,
               "of feeling an object before it is lifted, with the new look and plan"});
    visit(Knob{"touches", self.touches, "", 0, 10, "of one object, before it is lifted"});
    visit(Knob{"success_of_none", self.success_of_none, "", 0, 1,
               "probability that a grasp succeeds that holds in no disturbed trial"});
    visit(Knob{"success_of_all", self.success_of_all, "", 0, 1,
               "probability that a grasp succeeds that holds in every disturbed trial"});
  }
  /// The others, of robots that carry a camera.
  template <class Self, class Visit>
  static void look_knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"look_cost", self.look, "s", 0.001, 1e6,
               "of a look from elsewhere with the camera that the arm carries, with the new plan"});
    visit(
        Knob{"looks", self.looks, "", 0, 10, "at one object from elsewhere, before it is lifted"});
  }
  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What is known of one grasp: of each shape that the object may have.
struct GraspChances {
  std::vector<double> held;  // share of its disturbed trials, NaN: none
  /// rad or m, where the motors stop; empty: they meet nothing. No shapes: it is not known.
  std::vector<Eigen::VectorXd> stops;
};
GraspChances chances_of(const grasp::Grasp& grasp);

/// What a look from elsewhere would tell.
struct LookChances {
  /// m, of each two shapes, by which what the look shows of the row's is off the column's surface;
  /// empty: there is no such look.
  Eigen::MatrixXd apart;
  std::string from;                                 // "the left", in words
  std::string problem = "no camera can get there";  // where there is none
};

/// One act and what it is worth.
struct Choice {
  Act act = Act::kGiveUp;
  int grasp = -1;      // of the list, of kGrasp and kTouch
  double success = 0;  // that it is lifted: by that attempt; after a touch or look by the best then
  double worth = 0;    // s, expected, with all that follows
  std::string text;    // "grasp 0 now: lifted with 0.93, worth 84 s"
};

/// Probability of success of a grasp that holds in this share of its disturbed trials.
double success_of(double held, const DecisionOptions& options);
/// The same over shapes of these weights, of all 1. A shape without a trial counts as the others
/// do.
double success_of(const GraspChances& grasp, const std::vector<double>& weights,
                  const DecisionOptions& options);

/// What is worth most, best first; never empty. The first grasp is the one to be tried next; the
/// others are there for after it, and to feel the object with.
///
/// The worth of grasping is P value - attempt - (1 - P) failure, and after a failure, which speaks
/// against the shapes on which the grasp would have held, what is worth most then, as long as there
/// are attempts. That of touching is minus its cost and the expectation, over where the hand may
/// stop, of what is worth most when the shapes are weighed by that (preposterior analysis: H.
/// Raiffa and R. Schlaifer, "Applied Statistical Decision Theory", 1961, chapter 4); stops scatter
/// normally about those of each shape, taken at three points (Gauss-Hermite). That of a look is
/// the same over what it may show. Giving up is worth 0. Where there is no look, one that tells the
/// shape is told with why there is none, but not chosen: it is the last.
///
/// @param jaws the motors slide: DecisionOptions::stop_deviation_length is theirs.
/// @param probe m, of each shape, after which way a probe of one fingertip is stopped by it; empty:
/// there is none. It is weighed as a touch.
/// @throws std::invalid_argument for options out of range, weights that are not positive numbers of
/// sum 1, or grasps, a probe or a look of other shapes.
std::vector<Choice> decide(const std::vector<GraspChances>& grasps,
                           const std::vector<double>& weights, bool jaws,
                           const DecisionOptions& options, const std::vector<double>& probe = {},
                           const LookChances& look = {});

/// The same of planned grasps of an object, as many of the first as were assessed; empty: the first
/// was not. @throws as decide(), and as grasp::shape_weights().
std::vector<Choice> decide_on(const surface::ObjectModel& object,
                              const std::vector<const grasp::Grasp*>& grasps, bool jaws,
                              const DecisionOptions& options, const std::vector<double>& probe = {},
                              const LookChances& look = {});

}  // namespace prehend::planning
