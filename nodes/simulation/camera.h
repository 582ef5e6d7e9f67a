#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "msgs/camera.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/simulation/stereo_renderer.h"

namespace prehend::nodes {

/// The simulated stereo camera: publishes /camera/info and, whenever asked to, /camera/stereo (both
/// latched); where it is a depth camera, too, /camera/depth: the left image and its true depth.
/// Where it is carried, each picture says where it was taken, and /camera/info does not. A
/// thread of its own renders, so that a picture holds up neither physics nor commands.
class Camera {
 public:
  struct View {
    std::vector<simulation::VisibleBody> bodies;
    double time = 0;  // s
    std::uint64_t generation = 0;
    std::optional<geometry::RigidTransform> X_WC;  // of a camera that is carried
  };

  /// `view` tells what there is to see, with the robot if asked to, and where a camera that is
  /// carried is; it is called by the camera's thread.
  Camera(graph::Node& node, std::function<View(bool shows_robot)> view,
         const simulation::Scene& scene, const simulation::RenderOptions& options, bool depth,
         bool carried);
  ~Camera();

  /// Asks for a picture of the world as it is when the thread comes to it. Requests merge.
  /// @param anew counts as a change of the scene, so that it is looked at though nothing was added
  /// @param shows_robot although other pictures may not
  void request(bool anew = false, bool shows_robot = false);

 private:
  void run();
  void render(std::uint64_t looks, bool shows_robot);

  graph::Node& node_;
  std::function<View(bool)> view_;
  simulation::Scene scene_;
  simulation::RenderOptions options_;
  graph::Publisher<msgs::CameraInfo> info_;
  graph::Publisher<msgs::StereoPair> stereo_;
  std::optional<graph::Publisher<msgs::DepthImage>> depth_;
  std::uint32_t frame_ = 0;

  std::mutex mutex_;
  std::condition_variable wake_;
  bool requested_ = false, shows_robot_ = false;
  std::uint64_t looks_ = 0;  // pictures asked for anew
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::nodes
