#include "prehend/contact/foam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "prehend/contact/compression_curve.h"
#include "prehend/contact/foam_texel.h"
#include "prehend/contact/texel.h"

namespace prehend::contact {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kAtRest = 1e-13;  // m, no stretch at all

// A spring over one step: e+ = keep e + follow (d+ - d), cut to +-limit.
struct FoamSpring {
  double stiffness = 0;  // N/m
  double keep = 1, follow = 1;
  double limit = kInfinity;  // m

  double stretch(double before, double change) const {
    return std::clamp(keep * before + follow * change, -limit, limit);
  }
  bool gives(double before, double change) const {
    return std::abs(keep * before + follow * change) < limit;
  }
  // Of the stretch over the change, from none to this one. Where a slider begins to slip within the
  // step a tangent there would know nothing of the spring before it, and Newton's method would
  // throw off what is light; elsewhere it is the tangent.
  double secant(double before, double change) const {
    if (limit == kInfinity || std::abs(change) < 1e-15) return follow;
    return (stretch(before, change) - stretch(before, 0)) / change;
  }
};

struct FoamSprings {
  std::array<FoamSpring, FoamMemory::kMostTerms> spring;
  std::size_t count = 0;

  FoamSprings(const TexelLaw& law, double h) {
    const double stiffness = memory_stiffness(law);
    for (const FoamMemory::Creep& term : law.memory.creep) {
      const double x = h / term.time;
      spring[count++] = {term.share * stiffness, std::exp(-x), x > 0 ? -std::expm1(-x) / x : 1.0,
                         kInfinity};
    }
    for (const FoamMemory::Hysteresis& term : law.memory.hysteresis) {
      spring[count++] = {term.share * stiffness, 1, 1, term.depth};
    }
  }
};

struct StaticForce {
  double force = 0, slope = 0;  // N, N/m
};

// Of the law without damper, its linear spring continued beyond the face.
StaticForce elastic(const TexelLaw& law, double depth) {
  const NormalResponse normal = normal_response(law, depth, 0);
  return {normal.force, normal.stiffness};
}

// Of law and springs once texel `i` is compressed to `depth`.
StaticForce at_depth(const TexelLaw& law, const FoamSprings& springs, const double* foam,
                     std::size_t texels, std::size_t i, double depth) {
  StaticForce at = elastic(law, depth);
  const double change = depth - foam[i];
  for (std::size_t k = 0; k < springs.count; ++k) {
    const FoamSpring& spring = springs.spring[k];
    const double before = foam[(k + 1) * texels + i];
    at.force += spring.stiffness * spring.stretch(before, change);
    if (spring.gives(before, change)) at.slope += spring.stiffness * spring.follow;
  }
  return at;
}

// Where texel `i` comes back to with nothing on it, not less than `least` [m]. The static force
// nowhere falls with the depth: Newton's steps, halved where they leave what holds the root.
double free_depth(const TexelLaw& law, const FoamSprings& springs, const double* foam,
                  std::size_t texels, std::size_t i, double least) {
  double low = std::max(0.0, least), high = std::max(low, foam[i]);
  for (std::size_t k = 0; k < springs.count; ++k) {
    const FoamSpring& spring = springs.spring[k];
    high = std::max(high, foam[i] - spring.keep * foam[(k + 1) * texels + i] / spring.follow);
  }
  double depth = std::clamp(foam[i], low, high);
  for (int round = 0; round < 60 && high > low; ++round) {
    const StaticForce at = at_depth(law, springs, foam, texels, i, depth);
    (at.force > 0 ? high : low) = depth;
    double next = at.slope > 0 ? depth - at.force / at.slope : 0.5 * (low + high);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double moved = std::abs(next - depth);
    depth = next;
    if (moved < 1e-15) break;
  }
  return depth;
}

// Ends the step of texel `i`, whose body stands at `depth`.
void advance_texel(const TexelLaw& law, const FoamSprings& springs, double* foam,
                   std::size_t texels, std::size_t i, double depth) {
  bool rests = foam[i] == 0;
  for (std::size_t k = 1; rests && k <= springs.count; ++k) rests = foam[k * texels + i] == 0;
  if (rests && depth <= 0) return;
  const bool pressed = at_depth(law, springs, foam, texels, i, depth).force > 0;
  const double to = pressed ? depth : free_depth(law, springs, foam, texels, i, depth);
  const double change = to - foam[i];
  double most = to;
  for (std::size_t k = 0; k < springs.count; ++k) {
    double& stretch = foam[(k + 1) * texels + i];
    stretch = springs.spring[k].stretch(stretch, change);
    most = std::max(most, std::abs(stretch));
  }
  foam[i] = to;
  if (most > kAtRest) return;
  for (std::size_t k = 0; k <= springs.count; ++k) foam[k * texels + i] = 0;
}

void require_foam(const PadLayout& pad, const TexelLaw& law, const PadState& state) {
  const auto size = static_cast<std::size_t>(1 + law.memory.terms()) * pad.padded_size();
  if (state.foam.size() == size) return;
  throw std::invalid_argument(
      "PadState::foam must be made for the law, with its creep and hysteresis");
}

}  // namespace

FoamMemory FoamMemory::realistic() {
  FoamMemory memory;
  memory.creep = {{0.06, 10}};
  memory.hysteresis = {{0.06, 1e-4}, {0.06, 4e-4}};
  return memory;
}

double memory_stiffness(const TexelLaw& law) {
  return law.normal_law == NormalLaw::kTabulated ? law.curve->mean_stiffness() : law.stiffness;
}

void linearise_foam(const PadLayout& pad, const TexelLaw& law, double h, const double* rate,
                    const PadState& state, double* offset, double* slope) {
  require_foam(pad, law, state);
  const FoamSprings springs(law, h * state.foam_due), now(law, 0);
  const std::size_t texels = pad.padded_size();
  const double* foam = state.foam.data();
  for (std::size_t i = 0; i < texels; ++i) {
    const double depth = state.depth[i];
    const double to = depth + h * rate[i];
    StaticForce end = elastic(law, to);
    for (std::size_t k = 0; k < springs.count; ++k) {
      const FoamSpring& spring = springs.spring[k];
      const double before = foam[(k + 1) * texels + i], change = to - foam[i];
      end.force += spring.stiffness * spring.stretch(before, change);
      end.slope += spring.stiffness * spring.secant(before, change);
    }
    const bool presses = depth > 0 && at_depth(law, now, foam, texels, i, depth).force > 0;
    slope[i] = h * end.slope + (presses ? law.damping : 0.0);
    offset[i] = end.force - h * end.slope * rate[i];
  }
}

void advance_foam(const PadLayout& pad, const TexelLaw& law, double h, const double* rate,
                  PadState& state) {
  require_foam(pad, law, state);
  const FoamSprings springs(law, h * state.foam_due);
  for (std::size_t i = 0; i < pad.padded_size(); ++i) {
    const double depth = rate ? state.depth[i] + h * rate[i] : PadState::kFar;
    advance_texel(law, springs, state.foam.data(), pad.padded_size(), i, depth);
  }
  state.foam_due = 1;
}

double foam_step_error(const PadLayout& pad, const TexelLaw& law, double h, const PadState& start,
                       const PadState& next) {
  if (start.foam.empty()) return 0;
  const FoamSprings springs(law, h);
  const double stiffness = memory_stiffness(law);
  const std::size_t texels = pad.padded_size();
  double worst = 0;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    const double change = next.foam[i] - start.foam[i];
    double off = 0;
    for (std::size_t k = 0; k < springs.count; ++k) {
      const std::size_t at = (k + 1) * texels + i;
      off += springs.spring[k].stiffness / stiffness *
             std::abs(springs.spring[k].stretch(start.foam[at], change) - next.foam[at]);
    }
    worst = std::max(worst, off);
  }
  return worst;
}

double foam_difference(const PadLayout& pad, const TexelLaw& law, const PadState& a,
                       const PadState& b) {
  if (a.foam.empty()) return 0;
  const FoamSprings springs(law, 0);
  const double stiffness = memory_stiffness(law);
  double worst = 0;
  for (std::size_t i = 0; i < pad.size(); ++i) {
    double off = 0;
    for (std::size_t k = 0; k < springs.count; ++k) {
      const std::size_t at = (k + 1) * pad.padded_size() + i;
      off += springs.spring[k].stiffness / stiffness * std::abs(a.foam[at] - b.foam[at]);
    }
    worst = std::max(worst, off);
  }
  return worst;
}

FoamTexel::FoamTexel(const TexelLaw& law)
    : law_(law), foam_(static_cast<std::size_t>(1 + law.memory.terms()), 0.0) {
  validate(law);
}

double FoamTexel::press(double h, double depth) {
  const FoamSprings springs(law_, h), now(law_, 0);
  const bool presses = depth_ > 0 && at_depth(law_, now, foam_.data(), 1, 0, depth_).force > 0;
  double force = at_depth(law_, springs, foam_.data(), 1, 0, depth).force;
  if (presses) force += law_.damping * (depth - depth_) / h;
  advance_texel(law_, springs, foam_.data(), 1, 0, depth);
  depth_ = depth;
  return std::max(0.0, force);
}

double foam_energy(const PadLayout& pad, const TexelLaw& law, const PadState& state,
                   std::size_t i) {
  if (state.foam.empty()) return 0;
  const FoamSprings springs(law, 0);
  double sum = 0;
  for (std::size_t k = 0; k < springs.count; ++k) {
    const double stretch = state.foam[(k + 1) * pad.padded_size() + i];
    sum += 0.5 * springs.spring[k].stiffness * stretch * stretch;
  }
  return sum;
}

}  // namespace prehend::contact
