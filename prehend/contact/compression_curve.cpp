#include "prehend/contact/compression_curve.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace prehend::contact {
namespace {

void require_sample(bool condition, std::size_t sample, const char* rule) {
  if (!condition) {
    throw std::invalid_argument("CompressionCurve: sample " + std::to_string(sample) + " " + rule);
  }
}

}  // namespace

CompressionCurve::CompressionCurve(const std::vector<Sample>& samples) {
  if (samples.size() < 2) throw std::invalid_argument("CompressionCurve needs two samples or more");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    require_sample(std::isfinite(samples[i].depth) && std::isfinite(samples[i].force), i,
                   "must be finite");
    if (i == 0) continue;
    require_sample(samples[i].depth > samples[i - 1].depth, i,
                   "must be deeper than the one before");
    require_sample(samples[i].force >= samples[i - 1].force, i,
                   "must press as the one before or more");
  }
  require_sample(samples[0].depth == 0 && samples[0].force == 0, 0, "must be (0, 0)");
  require_sample(samples.back().force > 0, samples.size() - 1, "must press");

  const std::size_t n = samples.size();
  std::vector<double> secant(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    secant[i] =
        (samples[i + 1].force - samples[i].force) / (samples[i + 1].depth - samples[i].depth);
  }
  for (std::size_t i = 0; i < n; ++i) {
    double slope = i == 0 ? secant.front() : i + 1 == n ? secant.back() : 0.0;
    if (i > 0 && i + 1 < n && secant[i - 1] > 0 && secant[i] > 0) {
      // Weighted harmonic mean: monotone without a second pass.
      const double before = samples[i].depth - samples[i - 1].depth;
      const double after = samples[i + 1].depth - samples[i].depth;
      const double w1 = 2 * after + before, w2 = after + 2 * before;
      slope = (w1 + w2) / (w1 / secant[i - 1] + w2 / secant[i]);
    }
    knots_.push_back({samples[i].depth, samples[i].force, slope});
  }
}

std::size_t CompressionCurve::interval(double depth) const {
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, depth,
                                      [](double d, const Knot& knot) { return d < knot.depth; });
  return static_cast<std::size_t>(after - knots_.begin()) - 1;
}

double CompressionCurve::force(double depth) const {
  if (depth <= 0) return 0;
  const Knot& last = knots_.back();
  if (depth >= last.depth) return last.force + last.slope * (depth - last.depth);
  const std::size_t i = interval(depth);
  const Knot &a = knots_[i], &b = knots_[i + 1];
  const double width = b.depth - a.depth, t = (depth - a.depth) / width;
  const double s = 1 - t;
  return s * s * ((1 + 2 * t) * a.force + t * width * a.slope) +
         t * t * ((1 + 2 * s) * b.force - s * width * b.slope);
}

double CompressionCurve::stiffness(double depth) const {
  if (depth <= 0) return knots_.front().slope;
  const Knot& last = knots_.back();
  if (depth >= last.depth) return last.slope;
  const std::size_t i = interval(depth);
  const Knot &a = knots_[i], &b = knots_[i + 1];
  const double width = b.depth - a.depth, t = (depth - a.depth) / width;
  const double s = 1 - t;
  return 6 * s * t * (b.force - a.force) / width + s * (s - 2 * t) * a.slope +
         t * (t - 2 * s) * b.slope;
}

double CompressionCurve::mean_stiffness() const {
  return knots_.back().force / knots_.back().depth;
}

}  // namespace prehend::contact
