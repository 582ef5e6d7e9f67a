#include "prehend/surface/fast_poisson.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/surface/empty_space.h"
#include "prehend/surface/envelope.h"
#include "prehend/surface/marching_cubes.h"
#include "prehend/surface/object_frame.h"
#include "prehend/surface/point_order.h"
#include "prehend/surface/screening.h"
#include "prehend/surface/spectral.h"
#include "prehend/surface/splat.h"

namespace prehend::surface {
namespace {

constexpr int kMostSpectralNodes = 80;  // along an axis of the grid of the Fourier transform
constexpr int kLeastMargin = 4;         // nodes between the points and the grid's border
constexpr float kEnoughPoints = 1.5f;   // that a density is estimated from
constexpr double kNodesPerRootPoint = 4;
// Of a plane of points, splatted and gathered by the quadratic B-spline, over their density: the
// square of the spline at its nodes, averaged over the plane's place and direction.
constexpr float kPlaneFactor = 0.55f;
constexpr float kCutSlope = 0.5f;       // of the field at a cut, about that of u at a surface
constexpr double kClosedBalance = 0.1;  // mean normal of a surface that is nearly closed
constexpr float kHullMargin = 1.5f;     // nodes

void check(const FastPoissonOptions& o) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("FastPoissonOptions." + what);
  };
  require(o.resolution >= 32 && o.resolution <= 256 && o.resolution % 16 == 0,
          "resolution must be a multiple of 16 in [32, 256]");
  require(o.least_spacing >= 0 && std::isfinite(o.least_spacing), "least_spacing must be >= 0");
  require(o.scale >= 1.1 && o.scale <= 3, "scale must be in [1.1, 3]");
  require(o.point_weight >= 0 && o.point_weight <= 1e4, "point_weight must be in [0, 10000]");
  require(o.screening_iterations >= 0 && o.screening_iterations <= 100,
          "screening_iterations must be in [0, 100]");
  require(o.spread > 0 && o.spread <= 4, "spread must be in (0, 4]");
}

/// The grid: node (i, j, k) is at origin_F + spacing (i, j, k) in the cloud's frame F.
struct Lattice {
  geometry::RigidTransform X_WF;
  Eigen::Vector3d origin_F;
  double spacing;  // m
  Eigen::Vector3i size;
  int levels;  // grids of 1, 2, 4, ... times the spacing

  Eigen::Vector3d to_world(const Eigen::Vector3d& p_nodes) const {
    return X_WF * (origin_F + spacing * p_nodes);
  }
};

Lattice lattice_of(const std::vector<Eigen::Vector3f>& points_W,
                   const std::optional<geometry::Plane>& table, const FastPoissonOptions& options) {
  Lattice lattice;
  lattice.X_WF = object_frame(points_W, table);
  const geometry::RigidTransform X_FW = lattice.X_WF.inverse(Eigen::Isometry);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : points_W) box.extend(Eigen::Vector3d(X_FW * p.cast<double>()));
  const double extent = box.sizes().maxCoeff();
  // Few points need no fine grid, and could not be spread over its nodes.
  const int enough = 16 * static_cast<int>(kNodesPerRootPoint / 16 * std::sqrt(points_W.size()));
  double most = options.resolution;
  if (options.least_spacing > 0) {
    most = std::min(most, 16 * std::floor(options.scale * extent / options.least_spacing / 16));
  }
  const int resolution = std::max(32, std::min(enough, static_cast<int>(most)));
  lattice.spacing =
      std::max(options.scale / resolution, 1.0 / (resolution - 2 * kLeastMargin)) * extent;
  // Sizes that halve well, for the coarser grids and for the Fourier transform.
  const double margin = resolution - extent / lattice.spacing;
  lattice.levels = 1;
  while (0.5 * margin + 0.5 >= 1.5 * (1 << lattice.levels)) ++lattice.levels;
  const int unit = 1 << (lattice.levels - 1);
  for (int axis = 0; axis < 3; ++axis) {
    const double nodes = box.sizes()[axis] / lattice.spacing + margin;
    lattice.size[axis] = unit * static_cast<int>(std::ceil(nodes / unit - 1e-9));
  }
  lattice.origin_F = box.center() - 0.5 * lattice.spacing *
                                        (lattice.size.cast<double>() - Eigen::Vector3d::Ones());
  return lattice;
}

Eigen::Vector3i size_at(const Lattice& lattice, int level) {
  return lattice.size.unaryExpr([level](int n) { return n >> level; });
}

/// The points of one cell whose normals have the same greatest component, as one.
struct Sample {
  Eigen::Vector3f position;  // mean [nodes]
  Eigen::Vector3f normal;    // mean, in F
  float points = 0;          // how many
  float area = 0;            // that they stand for [spacing^2]
};

/// 0..5: the axis and sign of the greatest component.
int direction_class(const Eigen::Vector3f& v) {
  int axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return 2 * axis + (v[axis] < 0 ? 1 : 0);
}

/// Samples in the order in which their first points come in `order`.
std::vector<Sample> samples_in(const Lattice& lattice, const geometry::PointCloud& cloud,
                               const std::vector<int>& order) {
  const Eigen::Matrix3f R_FW = lattice.X_WF.linear().transpose().cast<float>();
  const geometry::RigidTransform X_FW = lattice.X_WF.inverse(Eigen::Isometry);
  const Eigen::Matrix3d to_nodes = X_FW.linear() / lattice.spacing;
  const Eigen::Vector3d shift = (X_FW.translation() - lattice.origin_F) / lattice.spacing;
  std::vector<Sample> samples;
  samples.reserve(order.size());
  // Open addressing over cell and class; -1 is free.
  const std::size_t slots = std::bit_ceil(2 * order.size());
  std::vector<std::pair<std::uint32_t, int>> table(slots, {0, -1});
  for (const int i : order) {
    const Eigen::Vector3f p = (to_nodes * cloud.points[i].cast<double>() + shift).cast<float>();
    const Eigen::Vector3f n = R_FW * cloud.normals[i];
    const Eigen::Vector3i cell = p.cast<int>();
    const auto key = static_cast<std::uint32_t>(
        ((cell.z() * lattice.size.y() + cell.y()) * lattice.size.x() + cell.x()) * 6 +
        direction_class(n));
    std::size_t slot = (key * 2654435769u) & (slots - 1);
    while (table[slot].second >= 0 && table[slot].first != key) slot = (slot + 1) & (slots - 1);
    if (table[slot].second < 0) {
      table[slot] = {key, static_cast<int>(samples.size())};
      samples.push_back({Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()});
    }
    Sample& sample = samples[table[slot].second];
    sample.position += p;
    sample.normal += n;
    ++sample.points;
  }
  for (Sample& sample : samples) {
    sample.position /= sample.points;
    sample.normal /= sample.points;
  }
  return samples;
}

/// Points per spacing^2 at each position, from the finest grid of twice the spacing or more on
/// which enough points are near.
class Density {
 public:
  Density(const Lattice& lattice, const std::vector<Sample>& samples)
      : lattice_(lattice), samples_(samples) {}

  float at(const Eigen::Vector3f& p) {
    float density = 0;
    for (int level = 1; level < std::max(2, lattice_.levels); ++level) {
      // A vertex may be nearer to the border than any point.
      const Eigen::Vector3f last = size_at(lattice_, level).cast<float>().array() - 2.01f;
      const float sum = gather(grid(level), at_level(p, level).cwiseMax(1.f).cwiseMin(last));
      density = sum / (kPlaneFactor * static_cast<float>(1 << 2 * level));
      if (sum >= kEnoughPoints) break;
    }
    return density;
  }

 private:
  /// The points splatted at a level, made when it is first asked for.
  const ScalarGrid& grid(int level) {
    while (static_cast<int>(grids_.size()) < level) {
      const int next = static_cast<int>(grids_.size()) + 1;
      grids_.emplace_back(size_at(lattice_, next));
      grids_.back().fill(0);
      for (const Sample& sample : samples_) {
        splat(grids_.back(), at_level(sample.position, next), sample.points);
      }
    }
    return grids_[level - 1];
  }

  const Lattice& lattice_;
  const std::vector<Sample>& samples_;
  std::vector<ScalarGrid> grids_;
};

/// L u of all samples, which is div V with V = -Σ area normal δ, on the grid of level `finest`.
ScalarGrid divergence_of(const Lattice& lattice, const std::vector<Sample>& samples, double spread,
                         int finest) {
  std::vector<ScalarGrid> grids(lattice.levels);
  const auto grid_at = [&](int level) -> ScalarGrid& {
    if (grids[level].count() == 0) {
      grids[level] = ScalarGrid(size_at(lattice, level));
      grids[level].fill(0);
    }
    return grids[level];
  };
  const auto add = [&](const Sample& sample, int level, float share) {
    // A cell has 8^level and a side 2^level times the size; L counts in sides of `finest`.
    const float scale = std::ldexp(share * sample.area, 2 * finest - 4 * level);
    splat_divergence(grid_at(level), at_level(sample.position, level), -scale * sample.normal);
  };
  for (const Sample& sample : samples) {
    const double wanted = std::log2(spread * std::sqrt(sample.area / sample.points));
    const double level = std::clamp<double>(wanted, finest, lattice.levels - 1);
    const int lower = std::min(static_cast<int>(level), lattice.levels - 1);
    const auto share = static_cast<float>(level - lower);
    if (share < 1) add(sample, lower, 1 - share);
    if (share > 0) add(sample, lower + 1, share);
  }
  for (int level = lattice.levels - 1; level > finest; --level) {
    if (grids[level].count() > 0) add_upsampled(grids[level], grid_at(level - 1));
  }
  return std::move(grid_at(finest));
}

/// u + gradient · x, for the mean gradient that the periodic solution cannot have.
void add_linear(ScalarGrid& grid, const Eigen::Vector3f& gradient) {
  if (gradient.isZero(0)) return;
  for (int z = 0; z < grid.size().z(); ++z) {
    for (int y = 0; y < grid.size().y(); ++y) {
      float* row = &grid.at(0, y, z);
      const float start = gradient.y() * y + gradient.z() * z;
      for (int x = 0; x < grid.size().x(); ++x) row[x] += start + gradient.x() * x;
    }
  }
}

/// True when the normals point all ways, as those of a closed surface do, but towards its inside:
/// the volume by the divergence theorem, Σ area normal · p / 3, is negative.
bool is_inside_out(const std::vector<Sample>& samples) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0;
  for (const Sample& sample : samples) {
    center += static_cast<double>(sample.area) * sample.position.cast<double>();
    sum += static_cast<double>(sample.area) * sample.normal.cast<double>();
    area += sample.area;
  }
  center /= area;
  double volume = 0;
  for (const Sample& sample : samples) {
    volume +=
        sample.area * sample.normal.cast<double>().dot(sample.position.cast<double>() - center);
  }
  return volume < 0 && sum.norm() < kClosedBalance * area;
}

/// u on the finest grid. It is solved on one of at most kMostSpectralNodes and interpolated: what
/// is finer, the screening adds.
ScalarGrid solution(const Lattice& lattice, const std::vector<Sample>& samples, double spread,
                    const Eigen::Vector3f& mean_gradient) {
  int level = 0;
  while (lattice.size.maxCoeff() >> level > kMostSpectralNodes && level + 1 < lattice.levels) {
    ++level;
  }
  ScalarGrid field = divergence_of(lattice, samples, spread, level);
  solve_poisson(field);
  add_linear(field, std::ldexp(1.f, level) * mean_gradient);
  for (; level > 0; --level) {
    ScalarGrid finer(size_at(lattice, level - 1));
    finer.fill(0);
    add_upsampled(field, finer);
    field = std::move(finer);
  }
  return field;
}

/// The value below which half of the area lies, to a millionth of the values' range.
float median_level(const ScalarGrid& field, const std::vector<Sample>& samples) {
  std::vector<float> values;
  values.reserve(samples.size());
  double half = 0;
  for (const Sample& sample : samples) {
    values.push_back(interpolated(field, sample.position));
    half += 0.5 * sample.area;
  }
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  // A histogram finds a thousandth of the range, and another one a thousandth of that.
  constexpr int kBins = 1024;
  double low = *least;
  double width = (static_cast<double>(*most) - low) / kBins;
  double below = 0;
  for (int pass = 0; pass < 2 && width > 0; ++pass) {
    std::array<double, kBins> area{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double bin = (values[i] - low) / width;
      if (bin >= 0 && bin < kBins + 1e-9) {
        area[std::min(static_cast<int>(bin), kBins - 1)] += samples[i].area;
      }
    }
    int bin = 0;
    while (bin + 1 < kBins && below + area[bin] < half) below += area[bin++];
    low += bin * width;
    width /= kBins;
  }
  return static_cast<float>(low + 0.5 * width * kBins);
}

/// Lowers the field so that nothing under the table, z = `height` [nodes], is above `level`.
void cut_at_table(ScalarGrid& field, float height, float level) {
  for (int z = 0; z < field.size().z(); ++z) {
    const float limit = level + kCutSlope * (static_cast<float>(z) - height);
    if (limit > level + 8 * kCutSlope) return;
    for (std::ptrdiff_t i = z * field.slab(); i < (z + 1) * field.slab(); ++i) {
      field.data()[i] = std::min(field.data()[i], limit);
    }
  }
}

/// Lowers the field so that nothing under `plane`, in nodes, is above `level`.
void cut_at_plane(ScalarGrid& field, const geometry::Plane& plane, float level) {
  for (int z = 0; z < field.size().z(); ++z) {
    for (int y = 0; y < field.size().y(); ++y) {
      for (int x = 0; x < field.size().x(); ++x) {
        const auto height = static_cast<float>(plane.signed_distance(Eigen::Vector3d(x, y, z)));
        float& value = field.at(x, y, z);
        value = std::min(value, level + kCutSlope * height);
      }
    }
  }
}

}  // namespace

PoissonSurface fast_poisson(const geometry::PointCloud& cloud,
                            const std::optional<geometry::Plane>& table,
                            const FastPoissonOptions& options, const EmptySpace& empty,
                            std::span<const geometry::Plane> bounds) {
  check(options);
  const std::vector<int> order = canonical_order(cloud.points, cloud.normals);
  std::vector<Eigen::Vector3f> ordered;
  ordered.reserve(order.size());
  for (const int i : order) ordered.push_back(cloud.points[i]);
  const Lattice lattice = lattice_of(ordered, table, options);
  std::vector<Sample> samples = samples_in(lattice, cloud, order);
  Density density(lattice, samples);
  Eigen::Vector3f mean_gradient = Eigen::Vector3f::Zero();
  for (Sample& sample : samples) {
    sample.area = sample.points / density.at(sample.position);
    mean_gradient -= sample.area * sample.normal;
  }
  mean_gradient /= static_cast<float>(lattice.size.cast<double>().prod());

  ScalarGrid field = solution(lattice, samples, options.spread, mean_gradient);
  const float level = median_level(field, samples);
  std::vector<ScreenedPoint> screened;
  screened.reserve(samples.size());
  for (const Sample& sample : samples) {
    screened.push_back(
        {sample.position, static_cast<float>(options.point_weight) * std::min(sample.area, 1.f)});
  }
  if (options.point_weight > 0) {
    screen(field, screened, level, {.iterations = options.screening_iterations, .reach = 1});
  }
  if (table) {
    const double height = table->offset - table->normal.dot(lattice.to_world({0, 0, 0}));
    cut_at_table(field, static_cast<float>(height / lattice.spacing), level);
  }
  for (const geometry::Plane& bound : bounds) {
    const Eigen::Vector3d normal_F = lattice.X_WF.linear().transpose() * bound.normal;
    const double height = bound.signed_distance(lattice.to_world({0, 0, 0}));
    cut_at_plane(field, {normal_F, -height / lattice.spacing}, level);
  }
  if (!empty.seen.empty() || empty.swept) {
    Eigen::Affine3d X_W_nodes = lattice.X_WF * Eigen::Translation3d(lattice.origin_F);
    X_W_nodes.scale(lattice.spacing);
    cut_at_empty_space(field, empty, X_W_nodes, level, kCutSlope);
  }

  PoissonSurface surface;
  surface.mesh = marching_cubes(field, level);
  const auto at_border = [&](const Eigen::Vector3d& p) {
    return (p.array() < 1).any() || (p.array() > lattice.size.cast<double>().array() - 2).any();
  };
  const auto& vertices = surface.mesh.vertices;
  surface.inside_out = is_inside_out(samples);
  surface.is_open = std::any_of(vertices.begin(), vertices.end(), at_border);
  if (surface.is_open && options.close_by_hull) {
    std::vector<Eigen::Vector3f> positions;
    for (const Sample& sample : samples) positions.push_back(sample.position);
    surface.is_open = !cut_at_hull(field, positions, kHullMargin, level, kCutSlope);
    surface.closed_by_hull = !surface.is_open;
    if (surface.closed_by_hull) surface.mesh = marching_cubes(field, level);
  }
  if (options.vertex_density) {
    const double per_square_metre = 1 / (lattice.spacing * lattice.spacing);
    for (const Eigen::Vector3d& vertex : surface.mesh.vertices) {
      surface.density.push_back(
          static_cast<float>(density.at(vertex.cast<float>()) * per_square_metre));
    }
  }
  for (Eigen::Vector3d& vertex : surface.mesh.vertices) vertex = lattice.to_world(vertex);
  return surface;
}

geometry::TriangleMesh trimmed(const PoissonSurface& surface, double least_density) {
  const std::vector<Eigen::Vector3d>& vertices = surface.mesh.vertices;
  if (surface.density.size() != vertices.size()) {
    throw std::invalid_argument("trimmed: the surface was made without vertex_density");
  }
  geometry::TriangleMesh part;
  std::vector<int> renumbered(vertices.size(), -1);
  const auto is_dense = [&](int i) { return surface.density[i] >= least_density; };
  std::vector<bool> used(vertices.size(), false);
  for (const Eigen::Vector3i& t : surface.mesh.triangles) {
    if (!is_dense(t.x()) || !is_dense(t.y()) || !is_dense(t.z())) continue;
    for (const int i : t) used[i] = true;
    part.triangles.push_back(t);
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!used[i]) continue;
    renumbered[i] = static_cast<int>(part.vertices.size());
    part.vertices.push_back(vertices[i]);
  }
  for (Eigen::Vector3i& t : part.triangles) {
    t = {renumbered[t.x()], renumbered[t.y()], renumbered[t.z()]};
  }
  return part;
}

}  // namespace prehend::surface
