#include "prehend/touch/hold_slip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "prehend/geometry/symmetric_solve.h"

namespace prehend::touch {
namespace {

constexpr double kPriorShift = 2;       // texels' distances, standard
constexpr double kPriorTurn = 0.1;      // rad
constexpr double kPriorGain = 1;        // relative
constexpr double kLeastInformed = 0.5;  // of the prior's deviation: more is not determined
constexpr double kLeastTouch = 0.3;     // N: a pad that feels less holds nothing
constexpr double kLongStep = 0.4;       // texels' distances: registration is from there on
constexpr double kJump = 0.3;           // texels' distances
constexpr double kGoesOn = 0.25;        // of the jump; a low pass of 10 ms goes on by 0.14
constexpr double kPoorer = 4;           // times the variance: that direction does not count
constexpr double kPoor = 2e-4;          // m, and such a deviation
constexpr double kBeyondDoubt = 2;      // times what is enough: one frame will do
constexpr double kStillHeld = 0.1;      // of the reference's force: with less it has left the pad

double sum_of(const FeltTexels& felt) {
  double sum = 0;
  for (const double force : felt.force) sum += force;
  return sum;
}

// Free texels with touched ones at both sides, along the rows or the columns.
std::vector<bool> dead_texels(const contact::PadLayout& layout, const FeltTexels& felt) {
  std::vector<bool> dead(layout.size(), false);
  const int rows = layout.rows(), columns = layout.columns();
  if (static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) != layout.size()) {
    return dead;
  }
  const auto touched = [&](int row, int column) {
    return row >= 0 && row < rows && column >= 0 && column < columns &&
           felt.force[static_cast<std::size_t>(row * columns + column)] > 0;
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (touched(row, column)) continue;
      dead[static_cast<std::size_t>(row * columns + column)] =
          (touched(row - 1, column) && touched(row + 1, column)) ||
          (touched(row, column - 1) && touched(row, column + 1));
    }
  }
  return dead;
}

}  // namespace

void HoldSlipOptions::validate() const { knobs(*this, text::CheckKnobs{"HoldSlipOptions."}); }

HoldSlip::HoldSlip(const HoldSlipOptions& options) : options_(options) { options.validate(); }

void HoldSlip::begin(double time) {
  begin_ = time;
  begun_ = true;
  references_.clear();
  load_.reset();
  in_a_row_ = 0;
  last_slide_ = jump_ = jumped_to_ = 0;
  reading_ = {};
  reading_.reason = "the hold has just begun";
}

void HoldSlip::make_reference() {
  int loads = 0;
  Eigen::Vector3d load = Eigen::Vector3d::Zero();
  for (const Moment& moment : moments_) {
    if (!moment.load || !moment.load->allFinite()) continue;
    load += *moment.load;
    ++loads;
  }
  if (loads > 0) load_ = load / loads;
  for (const auto& [name, last] : moments_.back().frames) {
    std::vector<double> mean(last.counts.size(), 0.0);
    bool same = last.felt->layout.is_flat() && last.counts.size() == last.felt->layout.size();
    for (const Moment& moment : moments_) {
      const auto found = moment.frames.find(name);
      same = same && found != moment.frames.end() && found->second.felt == last.felt &&
             found->second.counts.size() == mean.size();
      if (!same) break;
      // What is no count makes the mean none: unreadable.
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += found->second.counts[i];
    }
    if (!same) continue;
    for (double& count : mean) count /= static_cast<double>(moments_.size());
    Reference reference{
        last.felt, PatternMotion(last.felt->layout), felt_texels(*last.felt, mean), {}, 0};
    reference.force = sum_of(reference.felt);
    if (reference.force < kLeastTouch) continue;
    reference.dead = dead_texels(last.felt->layout, reference.felt);
    references_.emplace(name, std::move(reference));
  }
}

void HoldSlip::add_stretch(const Reference& reference, const FeltTexels& now,
                           Stretch* stretch) const {
  const contact::TexelLaw& law = reference.pad->law;
  for (std::size_t i = 0; i < now.force.size(); ++i) {
    if (now.force[i] <= 0 || reference.felt.force[i] <= 0) continue;
    stretch->stiffness += reference.pad->layout.scale[i] * law.bristle_stiffness;
    stretch->holds += law.dynamic_friction * now.force[i];
  }
}

std::optional<HoldSlip::Shift> HoldSlip::shift_of(const FeltTexels& now,
                                                  Reference* reference) const {
  const PatternEquations equations =
      reference->motion.between(reference->felt, now, reference->dead);
  const double least_noise = options_.gain_deviation * std::sqrt(equations.mean_square);
  if (equations.rows.size() <= 4 || !(least_noise > 0)) return std::nullopt;
  const Eigen::Vector4d prior(kPriorShift, kPriorShift, kPriorTurn, kPriorGain);
  double noise = least_noise;
  Eigen::Matrix4d A;
  Eigen::Vector4d x;
  for (int pass = 0; pass < 2; ++pass) {  // the noise is known when the motion is
    A = equations.A;
    A.diagonal() += noise * noise * prior.cwiseAbs2().cwiseInverse();
    x = geometry::symmetric_solve<4>(A, equations.right);
    noise = std::max(least_noise, equations.left_over(x));
  }
  const double distance = reference->motion.distance();
  const Eigen::Vector2d step = distance * x.head<2>();
  const Eigen::Vector2d moved = reference->moved + step;
  const auto deviation_along = [&](const Eigen::Vector2d& direction) {
    const Eigen::Vector4d u(direction.x(), direction.y(), 0, 0);
    return noise * std::sqrt(std::max(0.0, u.dot(geometry::symmetric_solve<4>(A, u))));
  };
  const Eigen::Vector2d own = distance * Eigen::Vector2d(deviation_along(Eigen::Vector2d::UnitX()),
                                                         deviation_along(Eigen::Vector2d::UnitY()));
  if (!(own.minCoeff() < kLeastInformed * kPriorShift * distance) || !moved.allFinite()) {
    return std::nullopt;
  }
  const Eigen::Vector2d variance = reference->variance + own.cwiseAbs2();
  if (step.norm() > kLongStep * distance) {
    reference->felt = now;
    reference->moved = moved;
    reference->variance = variance;
  }
  return Shift{moved, variance};
}

double HoldSlip::common_motion(const std::vector<Shift>& shifts, double* variance) {
  const bool face = shifts.size() == 2;
  Eigen::Vector2d weights = Eigen::Vector2d::Zero(), mean = weights, squares = weights;
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    const double x = shifts[k].moved.x();
    const Eigen::Vector2d moved(face ? (k == 0 ? x : -x) : std::abs(x), shifts[k].moved.y());
    const Eigen::Vector2d weight = shifts[k].variance.cwiseInverse();
    weights += weight;
    mean += weight.cwiseProduct(moved);
    squares += weight.cwiseProduct(moved.cwiseAbs2());
  }
  mean = mean.cwiseQuotient(weights);
  // Of the mean, by how far the pads disagree, too.
  const Eigen::Vector2d of_one = (squares.cwiseQuotient(weights) - mean.cwiseAbs2()).cwiseMax(0);
  const double others = std::max(1.0, static_cast<double>(shifts.size()) - 1);
  Eigen::Vector2d spread = weights.cwiseInverse() + of_one / others;
  // What the pattern hardly shows, as along an edge, would only add its error.
  const int poorer = weights.x() < weights.y() ? 0 : 1;
  const bool poor =
      weights[poorer] * kPoorer < weights[1 - poorer] && 1 / weights[poorer] > kPoor * kPoor;
  if (poor) mean[poorer] = spread[poorer] = 0;
  *variance = spread.sum();
  return mean.norm();
}

bool HoldSlip::goes_on(double slide, double distance) {
  if (slide - last_slide_ > kJump * distance) {
    const bool again = jump_ > 0;
    jump_ = std::max(jump_, slide - last_slide_);
    if (!again) jumped_to_ = slide;
  }
  last_slide_ = slide;
  return jump_ == 0 || slide - jumped_to_ > kGoesOn * jump_;
}

const HoldSlipReading& HoldSlip::update(double time, const std::vector<PadFrame>& frames,
                                        const std::optional<Eigen::Vector3d>& load) {
  if (!moments_.empty() && !(time > moments_.back().time)) return reading_;
  Moment moment{time, {}, load};
  for (const PadFrame& frame : frames) moment.frames.emplace(frame.pad, frame);
  moments_.push_back(std::move(moment));
  if (static_cast<int>(moments_.size()) > options_.reference_frames) moments_.pop_front();
  if (!begun_) return reading_;
  reading_ = {};
  if (references_.empty()) {
    reading_.reason = "the hold has just begun";
    if (static_cast<int>(moments_.size()) < options_.reference_frames ||
        moments_.front().time < begin_) {
      return reading_;
    }
    make_reference();
    reading_.reason = "no flat pad touches";
    return reading_;
  }
  std::vector<Shift> shifts;
  Stretch stretch;
  std::size_t left = 0;
  double distance = 0;  // m, between texels
  for (auto& [name, reference] : references_) {
    distance = reference.motion.distance();
    const auto found = moments_.back().frames.find(name);
    if (found == moments_.back().frames.end() || found->second.felt != reference.pad ||
        found->second.counts.size() != reference.felt.force.size()) {
      continue;
    }
    const FeltTexels now = felt_texels(*reference.pad, found->second.counts);
    add_stretch(reference, now, &stretch);
    const bool readable =
        std::find(now.state.begin(), now.state.end(), Texel::kUnreadable) == now.state.end();
    if (readable && sum_of(now) < kStillHeld * reference.force) {
      ++left;
    } else if (const auto shift = shift_of(now, &reference)) {
      shifts.push_back(*shift);
    }
  }
  if (shifts.empty()) {
    in_a_row_ = 0;
    reading_.reason =
        left > 0 ? "it has left the pads" : "the patterns are too even to show whether they move";
    return reading_;
  }
  const bool known = load_ && load && load->allFinite();
  reading_.stretch = known ? (*load - *load_).norm() : stretch.holds;
  reading_.stretch /= std::max(1e-9, stretch.stiffness);
  double variance = 0;
  const double moved = common_motion(shifts, &variance);
  reading_.determined = true;
  reading_.pads = static_cast<int>(shifts.size());
  reading_.slide = std::max(0.0, moved - reading_.stretch);
  reading_.deviation =
      std::hypot(std::sqrt(variance), options_.stretch_deviation * reading_.stretch);
  const double least = std::max(options_.least_slide, options_.significance * reading_.deviation);
  const bool slides_now = goes_on(reading_.slide, distance) && reading_.slide > least;
  in_a_row_ = slides_now ? in_a_row_ + 1 : 0;
  reading_.slips = in_a_row_ >= options_.confirming_frames ||
                   (slides_now && reading_.slide > kBeyondDoubt * least);
  return reading_;
}

}  // namespace prehend::touch
