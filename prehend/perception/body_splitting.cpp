#include "prehend/perception/body_splitting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

#include "prehend/perception/ledges.h"
#include "prehend/perception/masks.h"
#include "prehend/perception/organized_components.h"
#include "prehend/perception/splitting.h"
#include "prehend/perception/supports.h"

namespace prehend::perception {
namespace {

using Members = std::vector<int>;
using geometry::PointCloud;

constexpr std::size_t kLeastPartPoints = 50;
constexpr int kMaskClosing = 2;  // pixels

/// Two sides of a cut.
struct Halves {
  std::array<Members, 2> side;  // ascending
};

void check(const BodySplitOptions& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("BodySplitOptions: ") + what);
  };
  require(std::isfinite(o.least_gain) && o.least_gain >= 0, "least_gain must not be negative");
  require(std::isfinite(o.least_part_gain), "least_part_gain must be finite");
  require(o.least_share > 0 && o.least_share <= 0.5, "least_share must be in (0, 0.5]");
  require(std::isfinite(o.reach) && o.reach > 0, "reach must be positive");
}

/// Takes a cluster apart, once.
class BodySplitter {
 public:
  BodySplitter(const ClusterView& cluster, const BodyEvidence& evidence,
               const std::function<bool(const Members&)>& is_object,
               const BodySplitOptions& options)
      : cloud_(cluster.cloud_C),
        cluster_(cluster),
        evidence_(evidence),
        is_object_(is_object),
        options_(options),
        side_of_(cloud_.size(), 0) {}

  /// The cut that explains most; none when one body explains `members` as well.
  std::optional<Halves> best_cut(const Members& members, const std::vector<Members>& others) {
    std::optional<Halves> best;
    double best_gain = options_.least_gain;
    std::optional<double> whole;
    for (Halves& cut : places(members)) {
      if (!may_be_objects(cut, members.size()) || mean_bend(cut) <= 0) continue;
      if (!whole) whole = log_odds({members}, others).front();
      const std::vector<double> parts = log_odds({cut.side[0], cut.side[1]}, others);
      const double share =
          static_cast<double>(cut.side[0].size()) / static_cast<double>(members.size());
      const double gain = share * parts[0] + (1 - share) * parts[1] - *whole;
      if (gain <= best_gain || std::min(parts[0], parts[1]) < *whole + options_.least_part_gain) {
        continue;
      }
      best_gain = gain;
      best = std::move(cut);
    }
    return best;
  }

 private:
  /// Where bodies may meet. Creases of several sizes: noise hides the fine ones, fillets the
  /// coarse.
  std::vector<Halves> places(const Members& members) const {
    std::vector<Halves> cuts;
    for (const double crease : {0.3, 0.45, 0.65}) {
      for (const double patch : {0.008, 0.014}) {
        SplitOptions splitting;
        splitting.patch = patch;
        splitting.min_crease = crease;
        splitting.min_share = 0.06;
        splitting.min_color_difference = 0;
        add_cuts(split_touching(cloud_, cluster_.camera, members, splitting), cuts);
      }
    }
    LedgeOptions ledges;
    ledges.least_color_difference = ledges.least_hue_difference = 0;
    std::vector<Members> parts;
    for (LedgePart& part : split_at_ledges(cloud_, cluster_.table_C, members, ledges)) {
      parts.push_back(std::move(part.members));
    }
    add_cuts(parts, cuts);
    return cuts;
  }

  /// Each of the parts against the others.
  void add_cuts(const std::vector<Members>& parts, std::vector<Halves>& cuts) const {
    if (parts.size() < 2) return;
    for (std::size_t k = 0; k < (parts.size() == 2 ? 1 : parts.size()); ++k) {
      Halves cut;
      for (std::size_t j = 0; j < parts.size(); ++j) {
        Members& side = cut.side[j == k ? 0 : 1];
        side.insert(side.end(), parts[j].begin(), parts[j].end());
      }
      give_back_crumbs(cut);
      const auto is_same = [&](const Halves& other) { return other.side == cut.side; };
      if (std::none_of(cuts.begin(), cuts.end(), is_same)) cuts.push_back(std::move(cut));
    }
  }

  /// What is apart from the rest of its side, and small, is the other side's.
  void give_back_crumbs(Halves& cut) const {
    constexpr double kGap = 0.02;        // m
    constexpr std::size_t kSmaller = 5;  // times than what is larger and stays
    for (const int from : {0, 1}) {
      Members& side = cut.side[from];
      std::sort(side.begin(), side.end());
      if (side.size() < kLeastPartPoints) return;
      Members kept;
      for (const Members& component : organized_components(cloud_, side, kGap, 4, 1)) {
        const bool stays = kept.empty() || component.size() * kSmaller >= kept.size();
        Members& to = stays ? kept : cut.side[1 - from];
        to.insert(to.end(), component.begin(), component.end());
      }
      side = std::move(kept);
    }
    for (Members& side : cut.side) std::sort(side.begin(), side.end());
  }

  bool may_be_objects(const Halves& cut, std::size_t count) const {
    const std::size_t least =
        std::max(kLeastPartPoints,
                 static_cast<std::size_t>(options_.least_share * static_cast<double>(count)));
    return std::all_of(cut.side.begin(), cut.side.end(), [&](const Members& side) {
      return side.size() >= least && is_object_(side);
    });
  }

  /// Mean over the border of how much the sides lean towards each other [rad, of small angles];
  /// > 0: a valley. 0 where they do not meet.
  double mean_bend(const Halves& cut) {
    constexpr std::size_t kSamples = 60;
    for (const int k : {0, 1}) {
      for (const int i : cut.side[k]) side_of_[i] = static_cast<char>(k + 1);
    }
    Members border;
    double depth = 0;
    for (const int i : cut.side[0]) {
      depth += static_cast<double>(cloud_.points[i].z()) / static_cast<double>(cut.side[0].size());
      if (!near(i, 2)[1].empty()) border.push_back(i);
    }
    const int reach = std::clamp(
        static_cast<int>(std::lround(options_.reach * cluster_.camera.fx / depth)), 3, 20);
    double sum = 0;
    int count = 0;
    for (std::size_t k = 0; k < border.size();
         k += std::max<std::size_t>(1, border.size() / kSamples)) {
      const std::optional<double> bend = bend_at(near(border[k], reach));
      if (!bend) continue;
      sum += *bend;
      ++count;
    }
    for (const Members& side : cut.side) {
      for (const int i : side) side_of_[i] = 0;
    }
    return count > 0 ? sum / count : 0;
  }

  /// Pixels of either side within `reach` columns and rows.
  std::array<Members, 2> near(int pixel, int reach) const {
    std::array<Members, 2> found;
    const int u = pixel % cloud_.width, v = pixel / cloud_.width;
    for (int y = std::max(v - reach, 0); y <= std::min(v + reach, cloud_.height - 1); ++y) {
      for (int x = std::max(u - reach, 0); x <= std::min(u + reach, cloud_.width - 1); ++x) {
        const int j = y * cloud_.width + x;
        if (side_of_[j] != 0) found[side_of_[j] - 1].push_back(j);
      }
    }
    return found;
  }

  struct Patch {
    Eigen::Vector3d center;
    Eigen::Vector3d normal;  // unit, towards the camera
  };

  std::optional<double> bend_at(const std::array<Members, 2>& sides) const {
    constexpr std::size_t kLeast = 8;
    if (std::min(sides[0].size(), sides[1].size()) < kLeast) return std::nullopt;
    const Patch a = patch_of(sides[0]), b = patch_of(sides[1]);
    return (b.center - a.center).normalized().dot(a.normal - b.normal);
  }

  /// The plane through the points, without those at another depth than most.
  Patch patch_of(const Members& points) const {
    constexpr double kSameSurface = 0.02;  // m
    std::vector<float> depths;
    for (const int i : points) depths.push_back(cloud_.points[i].z());
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    const auto is_near = [&](const Eigen::Vector3d& p) {
      return std::abs(p.z() - static_cast<double>(*middle)) < kSameSurface;
    };
    Patch patch{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    double count = 0;
    for (const int i : points) {
      const Eigen::Vector3d p = cloud_.points[i].cast<double>();
      if (!is_near(p)) continue;
      patch.center += p;
      count += 1;
    }
    patch.center /= count;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const int i : points) {
      const Eigen::Vector3d p = cloud_.points[i].cast<double>();
      if (is_near(p)) scatter += (p - patch.center) * (p - patch.center).transpose();
    }
    patch.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    if (patch.normal.dot(patch.center) > 0) patch.normal = -patch.normal;
    return patch;
  }

  /// Of each of `parts`, seen among each other and `others`. The world is the camera's frame.
  std::vector<double> log_odds(std::vector<Members> parts,
                               const std::vector<Members>& others) const {
    const std::size_t count = parts.size();
    parts.insert(parts.end(), others.begin(), others.end());
    ObjectImages images = draw_objects(cloud_, cluster_.camera, parts, kMaskClosing);
    SegmentedScene scene;
    scene.camera = cluster_.camera;
    scene.X_WC = geometry::RigidTransform::Identity();
    scene.depth = std::move(images.depth);
    scene.table_W = cluster_.table_C;
    std::vector<const PointCloud*> clouds;
    scene.objects.resize(parts.size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
      scene.objects[k].id = static_cast<int>(k);
      scene.objects[k].cloud_W = geometry::select(cloud_, parts[k]);
      scene.objects[k].mask = std::move(images.masks[k]);
      clouds.push_back(&scene.objects[k].cloud_W);
    }
    find_occlusions(scene);
    const std::vector<double> supports = support_heights(clouds, scene.table_W);
    std::vector<double> result;
    for (std::size_t k = 0; k < count; ++k) {
      if (supports[k] > 0) {
        scene.objects[k].support_W = scene.table_W;
        scene.objects[k].support_W->offset += supports[k];
      }
      result.push_back(evidence_(scene, scene.objects[k]));
    }
    return result;
  }

  const PointCloud& cloud_;
  const ClusterView& cluster_;
  const BodyEvidence& evidence_;
  const std::function<bool(const Members&)>& is_object_;
  const BodySplitOptions& options_;
  std::vector<char> side_of_;  // of each pixel: 1, 2; 0: neither
};

}  // namespace

std::vector<std::vector<int>> split_into_bodies(
    const ClusterView& cluster, const std::vector<int>& members, const BodyEvidence& evidence,
    const std::function<bool(const std::vector<int>&)>& is_object,
    const BodySplitOptions& options) {
  check(options);
  if (!cluster.cloud_C.organized()) {
    throw std::invalid_argument("split_into_bodies: the cloud is not organized");
  }
  if (!evidence || !is_object) {
    throw std::invalid_argument("split_into_bodies: without evidence nothing can be judged");
  }
  BodySplitter splitter(cluster, evidence, is_object, options);
  std::vector<Members> done, open{members};
  while (!open.empty()) {
    Members part = std::move(open.back());
    open.pop_back();
    std::vector<Members> others = cluster.others;
    others.insert(others.end(), open.begin(), open.end());
    others.insert(others.end(), done.begin(), done.end());
    if (std::optional<Halves> cut = splitter.best_cut(part, others)) {
      for (Members& side : cut->side) open.push_back(std::move(side));
    } else {
      std::sort(part.begin(), part.end());
      done.push_back(std::move(part));
    }
  }
  std::sort(done.begin(), done.end(), [](const Members& a, const Members& b) {
    return a.size() != b.size() ? a.size() > b.size() : a < b;
  });
  return done;
}

}  // namespace prehend::perception
