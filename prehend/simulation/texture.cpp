#include "prehend/simulation/texture.h"

#include <algorithm>
#include <cmath>

namespace prehend::simulation {
namespace {

// Hash of a lattice point to 0..1 (mixing constants of MurmurHash3's finaliser).
double lattice_value(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
  std::uint32_t h = seed * 0x9E3779B9u;
  for (const std::int32_t coordinate : {x, y, z}) {
    h ^= static_cast<std::uint32_t>(coordinate) * 0xCC9E2D51u;
    h = (h << 15 | h >> 17) * 0x1B873593u + 0xE6546B64u;
  }
  h ^= h >> 16;
  h *= 0x85EBCA6Bu;
  h ^= h >> 13;
  h *= 0xC2B2AE35u;
  h ^= h >> 16;
  return h * (1.0 / 4294967296.0);
}

// Trilinear value noise, 0..1, features of size 1.
double value_noise(const Eigen::Vector3d& p, std::uint32_t seed) {
  const Eigen::Vector3d base = p.array().floor();
  const auto x = static_cast<std::int32_t>(base.x());
  const auto y = static_cast<std::int32_t>(base.y());
  const auto z = static_cast<std::int32_t>(base.z());
  Eigen::Vector3d f = p - base;
  f = f.cwiseProduct(f).cwiseProduct(Eigen::Vector3d::Constant(3) - 2 * f);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double weight =
        (i ? f.x() : 1 - f.x()) * (j ? f.y() : 1 - f.y()) * (k ? f.z() : 1 - f.z());
    sum += weight * lattice_value(x + i, y + j, z + k, seed);
  }
  return sum;
}

// Three octaves from `scale` down to a sixth of it, around 0, within -1..1.
double fine_noise(const Eigen::Vector3d& p, double scale, std::uint32_t seed) {
  const double sum = 0.40 * value_noise(p / scale, seed) +
                     0.35 * value_noise(p * (2.6 / scale), seed + 1) +
                     0.25 * value_noise(p * (6.1 / scale), seed + 2);
  return 2.6 * (sum - 0.5);
}

double smooth_step(double edge0, double edge1, double x) {
  const double t = std::clamp((x - edge0) / (edge1 - edge0), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Share of the second colour, 0..1.
double second_share(const Texture& texture, const Eigen::Vector3d& p, double height) {
  switch (texture.pattern) {
    case Texture::Pattern::kStripes: {
      const double phase = std::sin(p.z() / (1.6 * texture.scale) * 6.2831853);
      return smooth_step(-0.2, 0.2, phase);
    }
    case Texture::Pattern::kLabel: {
      const double edge = 0.002;
      return smooth_step(0.25 * height - edge, 0.25 * height + edge, p.z()) *
             smooth_step(-0.75 * height - edge, -0.75 * height + edge, -p.z());
    }
    case Texture::Pattern::kWood: {
      const Eigen::Vector3d grain(p.x() * 0.08, p.y(), p.z());
      return value_noise(grain / (0.5 * texture.scale), texture.seed + 5);
    }
    case Texture::Pattern::kNoise:
      break;
  }
  return smooth_step(0.35, 0.65, value_noise(p / (1.5 * texture.scale), texture.seed + 7));
}

}  // namespace

Eigen::Vector3d texture_color(const Texture& texture, const Eigen::Vector3d& p_B, double height) {
  const double share = second_share(texture, p_B, height);
  const Eigen::Vector3d base = (1 - share) * texture.color + share * texture.second_color;
  const double gain = 1 + texture.contrast * fine_noise(p_B, texture.scale, texture.seed);
  return (gain * base).cwiseMax(0.0).cwiseMin(1.0);
}

}  // namespace prehend::simulation
