#include "prehend/control/holding.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "prehend/text/told_apart.h"

namespace prehend::control {
namespace {

constexpr double kShareOfWay = 0.8;  // of the way that fingers had left, that counts as all of it
constexpr double kLeastWay = 0.02;   // rad: fingers with less left cannot tell

}  // namespace

void HoldingOptions::validate() const { knobs(*this, text::CheckKnobs{"HoldingOptions."}); }

void ForceAverage::add(const Eigen::Vector3d& force) {
  if (!force.allFinite()) return;
  ++count_;
  const Eigen::Vector3d off = force - mean_;
  mean_ += off / count_;
  squares_ += off.dot(force - mean_);
}

double ForceAverage::deviation() const {
  return count_ < 2 ? 0 : std::sqrt(squares_ / (3.0 * (count_ - 1)));
}

Holding::Holding(const HoldingOptions& options) : options_(options) { options.validate(); }

void Holding::begin() { *this = Holding(options_); }

void Holding::feel_free(const std::optional<Eigen::Vector3d>& force) {
  if (force) free_.add(*force);
}

void Holding::grip(std::optional<double> closure, double way_left) {
  grip_closure_ = way_left >= kLeastWay ? closure : std::nullopt;
  largest_advance_ = std::min(options_.advance, kShareOfWay * way_left);
}

void Holding::weigh(const std::optional<Eigen::Vector3d>& force) {
  if (force) borne_.add(*force);
}

double Holding::weight_deviation() const {
  return free_.deviation() *
         std::sqrt(1.0 / std::max(1, free_.count()) + 1.0 / std::max(1, borne_.count()));
}

double Holding::noise() const {
  return std::max(options_.resolution, options_.significance * weight_deviation());
}

bool Holding::force_decides() const {
  return free_.count() > 0 && borne_.count() > 0 && noise() <= options_.deciding_force;
}

std::string Holding::closing_problem(std::optional<double> closure) const {
  if (!closure || !grip_closure_ || *closure - *grip_closure_ <= largest_advance_) return {};
  return fmt::format("the fingers closed by {:.2f} rad more", *closure - *grip_closure_);
}

Holding::Verdict Holding::held(std::optional<double> closure) {
  weight_.reset();
  if (const std::string gone = closing_problem(closure); !gone.empty()) return {false, gone};
  if (force_decides()) {
    const double felt = borne(), least = noise();
    if (!(felt > least)) {
      const auto [borne, noise] = text::told_apart(felt, least, 2);
      return {false, fmt::format("the wrist bears {} N, no more than its sensor's noise, {} N",
                                 borne, noise)};
    }
    weight_ = felt;
    return {true, fmt::format("the wrist bears {:.2f} N", felt)};
  }
  const std::string blind = free_.count() > 0 && borne_.count() > 0
                                ? fmt::format("the wrist's noise hides {:.2f} N", noise())
                                : std::string("nothing is known of the wrist's force");
  if (closure && grip_closure_) return {true, blind + ", the fingers stand as they gripped"};
  return {false, blind + ", nor of the fingers: it cannot be told whether anything is held"};
}

Holding::Verdict Holding::empty() const {
  if (!force_decides()) return {true, "the hand is open"};
  const double felt = borne(), least = std::max(noise(), options_.lost_share * weight_.value_or(0));
  if (felt <= least) return {true, "the hand is empty"};
  return {false, fmt::format("the wrist still bears {:.2f} N", felt)};
}

std::string Holding::lost(double time, const std::optional<Eigen::Vector3d>& force,
                          std::optional<double> closure, bool by_weight) {
  if (std::string gone = closing_problem(closure); !gone.empty()) return gone;
  // A weight near the noise may come and go.
  const double least = options_.lost_share * weight_.value_or(0);
  if (!by_weight || !force || !force->allFinite() || least < noise()) {
    filtered_.reset();
    light_since_.reset();
    return {};
  }
  const double felt = (*force - free_.mean()).norm();
  const double share = 1 - std::exp(-(time - last_time_) / (0.5 * options_.lost_time));
  filtered_ = filtered_ ? *filtered_ + share * (felt - *filtered_) : felt;
  last_time_ = time;
  if (*filtered_ >= least) {
    light_since_.reset();
    return {};
  }
  if (!light_since_) light_since_ = time;
  if (time - *light_since_ < options_.lost_time) return {};
  const auto [borne, lifted] = text::told_apart(*filtered_, *weight_, 2);
  return fmt::format("the wrist bears {} N of the {} N that were lifted", borne, lifted);
}

}  // namespace prehend::control
