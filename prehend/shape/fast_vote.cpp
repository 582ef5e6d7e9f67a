#include "prehend/shape/fast_vote.h"

#include <utility>

#include <Eigen/LU>

#include "prehend/shape/vote_kernel.h"

namespace prehend::shape {

FastVote::FastVote(const std::vector<Eigen::Vector3d>& points_C,
                   const geometry::PinholeCamera& camera, SeenMap map, const VoteOptions& options)
    : map_(std::move(map)), options_(options), count_(points_C.size()) {
  const double center_u = 0.5 * (map_.window.u0 + map_.window.u1);
  const double center_v = 0.5 * (map_.window.v0 + map_.window.v1);
  to_abc_ << camera.fx, 0, camera.cx - center_u,  //
      0, camera.fy, camera.cy - center_v,         //
      0, 0, 1;
  from_abc_ = to_abc_.inverse();
  focal_length_ = 0.5 * (camera.fx + camera.fy);
  depth_center_ = 0;
  for (const Eigen::Vector3d& p_C : points_C) depth_center_ += p_C.z();
  depth_center_ /= static_cast<double>(count_);
  // Single precision of the centre is what the kernel adds.
  depth_center_ = static_cast<float>(depth_center_);

  const std::size_t padded = count_ + kKernelPadding;
  for (std::vector<float>* values : {&a_, &b_, &c_}) values->assign(padded, 0.f);
  for (std::size_t i = 0; i < count_; ++i) {
    const Eigen::Vector3d abc = to_abc_ * points_C[i];
    a_[i] = static_cast<float>(abc.x());
    b_[i] = static_cast<float>(abc.y());
    c_[i] = static_cast<float>(abc.z() - depth_center_);
  }
}

std::vector<VoteTally> FastVote::tallies(const std::vector<geometry::Plane>& planes_C) const {
  std::vector<KernelPlane> planes;
  planes.reserve(planes_C.size());
  for (const geometry::Plane& plane : planes_C) {
    // motion = 2 (offset - n · p), p = from_abc (a, b, c + depth_center).
    const Eigen::Vector3d motion = -2 * from_abc_.transpose() * plane.normal;
    const Eigen::Vector3d change = to_abc_ * plane.normal;
    planes.push_back({static_cast<float>(2 * plane.offset + motion.z() * depth_center_),
                      static_cast<float>(motion.x()), static_cast<float>(motion.y()),
                      static_cast<float>(motion.z()), static_cast<float>(change.x()),
                      static_cast<float>(change.y()), static_cast<float>(change.z())});
  }
  KernelInput input;
  input.a = a_.data();
  input.b = b_.data();
  input.c = c_.data();
  input.count = count_;
  input.depth_center = static_cast<float>(depth_center_);
  input.map = map_.values.data();
  input.stride = map_.stride;
  input.last_u = static_cast<float>(map_.window.width() + 1);
  input.last_v = static_cast<float>(map_.window.height() + 1);
  input.center_u = static_cast<float>(0.5 * map_.window.width() + 1.5);
  input.center_v = static_cast<float>(0.5 * map_.window.height() + 1.5);
  input.inverse_focal_length = static_cast<float>(1 / focal_length_);
  input.depth_tolerance = static_cast<float>(options_.depth_tolerance);
  input.least_motion = static_cast<float>(options_.least_motion);

  std::vector<KernelSums> sums(planes.size());
  sum_votes(input, planes, sums);
  std::vector<VoteTally> tallies;
  tallies.reserve(sums.size());
  for (const KernelSums& sum : sums) {
    tallies.push_back({count_, sum.outside_points, sum.outside_pixels, sum.nearer_points,
                       sum.nearer, sum.outside_squared, sum.in_front, sum.coincident,
                       sum.contradicted, sum.hidden, sum.unseen});
  }
  return tallies;
}

}  // namespace prehend::shape
