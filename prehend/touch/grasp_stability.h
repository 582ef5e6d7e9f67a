#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/touch/hand_touch.h"

// Whether a lift will hold, by what the pads of the hand feel, and by that alone: nothing is known
// of the object's shape, weight or friction.
namespace prehend::touch {

/// What all pads of a hand feel at a time.
struct Grip {
  std::vector<PadContact> contacts;  // of those that touch (HandTouch::contacts)
  std::vector<PadFrame> frames;      // of all
};

/// When the question is asked.
enum class GripMoment {
  kClosed,  // the hand has closed, nothing has been lifted
  kLifting  // the first centimetre of the lift is gone: the weight pulls, what slides moves its
            // pattern over the pads
};
std::string to_string(GripMoment moment);  // "closed", as in the model's file

/// Share of what the frames show that is not where it was, 0 to 1: sum |b - a| / sum (a + b) over
/// the texels of the pads that both have. 0 where they show nothing.
double frame_change(const std::vector<PadFrame>& a, const std::vector<PadFrame>& b);

/// The names of grip_features(), in their order: the same for every hand.
const std::vector<std::string>& grip_feature_names(GripMoment moment);

/// With F_i, p_i, n_i of the pads that touch (PadContact), F their sum:
///   log_force, log_squeeze  of F + 0.1 N, and of (F - |sum F_i n_i|) / 2 + 0.05 N: what presses
///                           against one another
///   net                     |sum F_i n_i| / F
///   facing                  how far pads that are opposed look at one another: mean cosine of n_i
///                           and p_j - p_i, by F_i F_j max(0, -n_i n_j)
///   lever, width            m, of the same pairs: how far they are past one another, and apart
///   log_area, log_pressure  m^2, Pa: of the sum, of F over it
///   log_torque              sum F_i arm_i + 1e-4 N m: what friction holds about the normals
///   least_margin, margin, tip_margin   m, of PadContact; the least, and means by force
///   across, along           m, spread of force on the pads, means by force
///   pads                    that touch
/// and while lifting, of what touched when the hand had closed:
///   change                  frame_change()
///   log_kept, log_least_kept  force now over then, of all pads and of the one that lost most
///   shift, area_change      m, |log ratio|: of centres of pressure and areas, means by force
/// @param lifting what is felt then, of kLifting. @throws std::invalid_argument when no pad touched
/// `closed`.
Eigen::VectorXd grip_features(const Grip& closed);
Eigen::VectorXd grip_features(const Grip& closed, const Grip& lifting);

/// The same grip pressed `factor` times as hard: what each texel says is scaled, which foam that
/// gives way linearly does where the area stays.
Grip pressed_harder(Grip grip, double factor);

/// What was learned of grasps whose end is known (eval_grasp_stability --fit): for each moment a
/// logistic regression,
///   p = 1 / (1 + exp(-(bias + sum_k weight_k (x_k - mean_k) / deviation_k)))
/// of the features x. A file's features must be those of grip_feature_names().
class GraspStability {
 public:
  struct Weighed {
    Eigen::VectorXd mean, deviation, weight;  // of the features; deviation > 0
    double bias = 0;
  };

  /// @throws std::invalid_argument for other numbers of features than there are, or what is not
  /// finite.
  GraspStability(Weighed closed, Weighed lifting);
  /// config/touch/grasp_stability.yaml (text::tree_file()) is what ships.
  /// @throws geometry::InputError "file:line: what is wrong" with the mend.
  static GraspStability load(const std::filesystem::path& file);
  /// @param made_by the command and the figures, as the file's comment; lines are broken at '\n'.
  /// @throws geometry::InputError when it cannot be written.
  void save(const std::filesystem::path& file, const std::string& made_by) const;

  /// That the lift holds, 0 to 1; 0 where no pad touched. @param lifting null: not yet lifted.
  double probability(const Grip& closed, const Grip* lifting = nullptr) const;
  const Weighed& of(GripMoment moment) const {
    return moment == GripMoment::kClosed ? closed_ : lifting_;
  }

 private:
  Weighed closed_, lifting_;
};

}  // namespace prehend::touch
