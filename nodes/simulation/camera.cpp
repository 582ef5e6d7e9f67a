#include "nodes/simulation/camera.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "msgs/convert/camera_images.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/images.h"

namespace prehend::nodes {
namespace {

/// Pictures take all processors for half a second and more; the world goes on at its pace
/// meanwhile. Linux has a nice value for each thread, which those that it starts inherit.
void yield_to_physics() {
  constexpr int kYield = 10;
  const auto self = static_cast<id_t>(::gettid());
  ::setpriority(PRIO_PROCESS, self, ::getpriority(PRIO_PROCESS, self) + kYield);
}

}  // namespace

Camera::Camera(graph::Node& node, std::function<View(bool)> view, const simulation::Scene& scene,
               const simulation::RenderOptions& options, bool depth, bool carried)
    : node_(node),
      view_(std::move(view)),
      scene_(scene),
      options_(options),
      info_(node.advertise<msgs::CameraInfo>("/camera/info", graph::QoS::latched())),
      stereo_(node.advertise<msgs::StereoPair>("/camera/stereo", graph::QoS::latched())) {
  if (depth) {
    depth_ = node.advertise<msgs::DepthImage>("/camera/depth", graph::QoS::latched());
  }
  std::optional<geometry::RigidTransform> X_WC;
  if (!carried) X_WC = scene.camera.X_WC();
  msgs::CameraInfo info = convert::to_message(scene.camera.camera, X_WC);
  info.mutable_header()->set_frame_id("camera");
  info_.publish(info);
  thread_ = std::thread([this] { run(); });
}

Camera::~Camera() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Camera::request(bool anew, bool shows_robot) {
  {
    const std::lock_guard lock(mutex_);
    requested_ = true;
    shows_robot_ = shows_robot_ || shows_robot;
    looks_ += anew ? 1 : 0;
  }
  wake_.notify_all();
}

void Camera::run() {
  yield_to_physics();
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return requested_ || ends_; });
    if (ends_) return;
    requested_ = false;
    const std::uint64_t looks = looks_;
    const bool shows_robot = std::exchange(shows_robot_, false);
    lock.unlock();
    node_.shield("picture", [this, looks, shows_robot] { render(looks, shows_robot); });
    lock.lock();
  }
}

void Camera::render(std::uint64_t looks, bool shows_robot) {
  const View view = view_(shows_robot);
  scene_.camera.carried = view.X_WC;
  const auto start = std::chrono::steady_clock::now();
  simulation::StereoImages images =
      simulation::render_stereo(scene_, view.bodies, frame_++, options_);
  const std::chrono::duration<double> duration = std::chrono::steady_clock::now() - start;
  msgs::DepthImage depth;
  if (depth_) {
    constexpr double kUnit = 1e-4;  // m
    depth = convert::to_message(convert::ColoredDepth{std::move(images.depth), images.left}, kUnit);
  }
  msgs::StereoPair message =
      convert::to_message(convert::StereoImages{std::move(images.left), std::move(images.right)});
  message.mutable_header()->set_stamp(std::llround(view.time * 1e9));
  message.mutable_header()->set_frame_id("camera");
  message.set_scene_generation(view.generation + looks);
  if (view.X_WC) *message.mutable_x_wc() = convert::to_message(*view.X_WC);
  if (depth_) {
    *depth.mutable_header() = message.header();
    depth.set_scene_generation(message.scene_generation());
    if (view.X_WC) *depth.mutable_x_wc() = message.x_wc();
    depth_->publish(std::move(depth));
  }
  stereo_.publish(std::move(message));
  node_.log_info("stereo pair of {:.2f} s simulated time, rendered in {:.2f} s", view.time,
                 duration.count());
}

}  // namespace prehend::nodes
