#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "msgs/camera.pb.h"
#include "msgs/convert/camera_images.h"
#include "msgs/convert/images.h"
#include "msgs/convert/objects.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/segmentation_parameters/segmentation_parameters.h"
#include "nodes/segmentation_parameters/stage_clock.h"
#include "nodes/stage_fidelity/stage_fidelity.h"
#include "nodes/stereo_segmentation/stereo_parameters.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/perception/binning.h"
#include "prehend/perception/dark_background.h"
#include "prehend/perception/refinement.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"
#include "prehend/perception/table.h"

namespace {

using namespace prehend;

void declare_image_parameters(graph::Node& node) {
  node.declare_parameter<std::string>(
      {.name = "background",
       .default_value = "table",
       .choices = {"table", "dark"},
       .description = "what objects stand out from: a table that stereo sees, or a black cloth "
                      "(objects are what is bright, the table is put under their lowest points)"});
  node.declare_parameter<bool>({.name = "refine_masks",
                                .default_value = false,
                                .description = "move the masks' outlines to edges of the image by "
                                               "a graph cut"});
}

constexpr std::chrono::milliseconds kLookPatience(50);  // wall time, to see whether it is cancelled

class StereoSegmentation {
 public:
  explicit StereoSegmentation(graph::Node& node) : node_(node) {
    nodes::declare_stereo_parameters(node);
    declare_image_parameters(node);
    parameters_.emplace(node, false);
    fidelity_.emplace(node, fidelity::Stage::kSeeing,
                      std::vector<std::string>{"method", "eight_directions", "clustering",
                                               "binning", "narrow_search", "table.leaf_size"});
    const bool takes_depth = node.parameter<std::string>("input") == "depth";
    nodes::refuse_idle_stereo_parameters(node);
    publisher_ = node.advertise<msgs::ObjectHypotheses>("/objects", graph::QoS::latched());
    camera_ = node.subscribe<msgs::CameraInfo>("/camera/info", graph::QoS::queue(1),
                                               [this](const graph::Received<msgs::CameraInfo>& m) {
                                                 info_ = m.shared();
                                                 process_pending();
                                               });
    images_ = takes_depth ? take<msgs::DepthImage>("/camera/depth")
                          : take<msgs::StereoPair>("/camera/stereo");
    look_ = node.serve_action<msgs::LookGoal, msgs::LookFeedback, msgs::LookResult>(
        "/camera/look",
        [this](const msgs::LookGoal& goal, LookContext& context) { return look(goal, context); });
  }

 private:
  using LookContext = graph::ActionContext<msgs::LookFeedback>;

  // In a thread of its own: the picture comes to process().
  msgs::LookResult look(const msgs::LookGoal& goal, LookContext& context) {
    {
      const std::lock_guard lock(look_mutex_);
      look_since_ = goal.since();
      looked_.reset();
    }
    context.feedback({});
    std::unique_lock lock(look_mutex_);
    while (!looked_ && !context.cancelled()) look_done_.wait_for(lock, kLookPatience);
    look_since_.reset();
    msgs::LookResult result;
    if (looked_) return *std::exchange(looked_, std::nullopt);
    result.set_problem("it was cancelled before a picture came");
    return result;
  }

  // Whether the picture answers a look, and is no view of the table.
  template <class Images>
  bool answers_look(const Images& images) {
    {
      const std::lock_guard lock(look_mutex_);
      if (!look_since_ || images.header().stamp() < *look_since_) return false;
      look_since_.reset();
    }
    msgs::LookResult result;
    const std::string problem =
        node_.shield("look", [&] { result.set_depth(convert::pack_depth(depth_of(images))); });
    result.set_problem(problem);
    *result.mutable_camera() = taken_by_;
    result.set_stamp(images.header().stamp());
    const std::lock_guard lock(look_mutex_);
    looked_ = std::move(result);
    look_done_.notify_all();
    return true;
  }

  geometry::DepthImage depth_of(const msgs::StereoPair& pair) const {
    const geometry::StereoCamera camera = convert::from_message(taken_by_);
    const convert::StereoImages images = convert::from_message(pair);
    return perception::depth_from_disparity(
        perception::stereo_disparity(images.left, images.right, camera, seeing().stereo), camera);
  }
  static geometry::DepthImage depth_of(const msgs::DepthImage& message) {
    return convert::from_message(message).depth;
  }

  template <class Images>
  graph::Subscription take(const char* topic) {
    return node_.subscribe<Images>(topic, graph::QoS::latest(),
                                   [this](const graph::Received<Images>& m) {
                                     pending_ = [this, images = m.shared()] { process(*images); };
                                     process_pending();
                                   });
  }

  void process_pending() {
    if (!info_ || !pending_) return;
    const auto work = std::exchange(pending_, nullptr);
    work();
  }

  template <class Images>
  void process(const Images& images) {
    taken_by_ = *info_;
    if (images.has_x_wc()) *taken_by_.mutable_x_wc() = images.x_wc();
    if (answers_look(images)) return;
    const std::uint64_t generation = images.scene_generation();
    const bool seen = generation != 0 && generation == last_generation_;
    if (seen && node_.parameter<std::string>("process") == "once_per_scene") return;
    last_generation_ = generation;
    publish(images);
  }

  template <class Images>
  void publish(const Images& images) {
    msgs::ObjectHypotheses message;
    const std::string problem = node_.shield("picture", [&] { message = segment(images); });
    if (!problem.empty()) {
      message.Clear();
      *message.mutable_camera() = taken_by_;
      message.set_problem(problem);
    }
    *message.mutable_header() = images.header();
    message.mutable_header()->set_frame_id("world");
    *message.mutable_camera()->mutable_header() = images.header();
    if (message.problem().empty()) {
      node_.report(graph::Health::kOk,
                   fmt::format("{} objects on the table", message.objects_size()));
      node_.log_info("{} objects on the table", message.objects_size());
    } else {
      node_.report(graph::Health::kWarning, message.problem());
    }
    publisher_.publish(std::move(message));
  }

  // By the parameters' values now, or by the front.
  fidelity::SeeingOptions seeing() const {
    fidelity::SeeingOptions options{node_.parameter<int>("binning"), nodes::stereo_options(node_),
                                    parameters_->segmentation(), parameters_->table()};
    if (const auto& chosen = fidelity_->chosen()) {
      fidelity::apply_seeing_setting(chosen->setting, &options);
    }
    return options;
  }

  msgs::ObjectHypotheses segment(const msgs::StereoPair& pair) {
    nodes::StageClock clock;
    msgs::ObjectHypotheses times;
    const fidelity::SeeingOptions options = seeing();
    const geometry::StereoCamera camera =
        perception::binned(convert::from_message(taken_by_), options.binning);
    const convert::StereoImages images = convert::from_message(pair);
    const geometry::ColorImage left = perception::binned(images.left, options.binning);
    const perception::DisparityImage disparity = perception::stereo_disparity(
        left, perception::binned(images.right, options.binning), camera, options.stereo);
    clock.end_stage(times, "disparity");
    const geometry::PointCloud cloud_C = perception::cloud_from_disparity(disparity, camera, left);
    clock.end_stage(times, "cloud");
    return segment(cloud_C, left, camera, true, clock, std::move(times));
  }

  msgs::ObjectHypotheses segment(const msgs::DepthImage& message) {
    nodes::StageClock clock;
    msgs::ObjectHypotheses times;
    const int binning = seeing().binning;
    const geometry::StereoCamera camera =
        perception::binned(convert::from_message(taken_by_), binning);
    const convert::ColoredDepth image = convert::from_message(message);
    geometry::ColorImage color;
    if (!image.color.empty()) color = perception::binned(image.color, binning);
    const geometry::PointCloud cloud_C =
        perception::cloud_from_depth(perception::binned(image.depth, binning), camera.left, color);
    clock.end_stage(times, "cloud");
    if (image.color.empty() && (node_.parameter<std::string>("background") == "dark" ||
                                node_.parameter<bool>("refine_masks"))) {
      throw geometry::InputError(
          "The depth image has no colour, which background=dark and "
          "refine_masks look at",
          "Start the depth camera with colour, or leave them away");
    }
    return segment(cloud_C, color, camera, false, clock, std::move(times));
  }

  // `colors` are the cloud's pixels, or empty. `is_matched`: by a pair of images.
  msgs::ObjectHypotheses segment(const geometry::PointCloud& cloud_C,
                                 const geometry::ColorImage& colors,
                                 const geometry::StereoCamera& camera, bool is_matched,
                                 nodes::StageClock& clock, msgs::ObjectHypotheses times) {
    const std::optional<geometry::RigidTransform> X_WC = convert::camera_pose(taken_by_);
    std::optional<Eigen::Vector3d> up_C;
    if (X_WC) up_C = X_WC->linear().transpose() * Eigen::Vector3d::UnitZ();
    perception::SegmentedScene scene;
    if (node_.parameter<std::string>("background") == "dark") {
      const perception::SegmentationOptions options = parameters_->segmentation();
      perception::DarkBackgroundOptions dark;
      dark.max_distance = options.max_distance;
      dark.max_objects = options.max_objects;
      scene =
          perception::segment_on_dark_background(cloud_C, colors, camera.left, up_C, X_WC, dark);
    } else {
      const fidelity::SeeingOptions asked = seeing();
      const perception::Table table = perception::find_table(cloud_C, asked.table, up_C);
      clock.end_stage(times, "table");
      perception::SegmentationOptions options = asked.segmentation;
      if (is_matched) options.baseline = camera.baseline;
      scene = perception::segment_on_table(cloud_C, camera.left, table, X_WC, options);
    }
    if (node_.parameter<std::string>("world") == "table") {
      scene = perception::in_table_world(std::move(scene));
    }
    if (node_.parameter<bool>("refine_masks")) perception::refine_masks(scene, colors);
    clock.end_stage(times, "segmentation");

    msgs::ObjectHypotheses message = convert::to_message(scene);
    message.mutable_camera()->set_baseline(camera.baseline);
    message.mutable_times()->Swap(times.mutable_times());
    if (scene.objects.empty()) message.set_problem(perception::why_no_objects(scene));
    return message;
  }

  graph::Node& node_;
  std::optional<nodes::SegmentationParameters> parameters_;
  std::optional<nodes::StageFidelity> fidelity_;
  graph::Publisher<msgs::ObjectHypotheses> publisher_;
  std::shared_ptr<const msgs::CameraInfo> info_;
  msgs::CameraInfo taken_by_;      // what is known of the camera of the present picture
  std::function<void()> pending_;  // the newest images, not yet looked at
  std::uint64_t last_generation_ = 0;
  graph::Subscription camera_;
  graph::Subscription images_;
  std::mutex look_mutex_;
  std::condition_variable look_done_;
  std::optional<std::int64_t> look_since_;  // ns: a look waits for a picture from then on
  std::optional<msgs::LookResult> looked_;
  graph::ActionServer look_;
};

void run(graph::Node& node) {
  const StereoSegmentation segmentation(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"stereo_segmentation",
     "Finds the table and the objects on it in a rectified stereo pair or a depth image. Takes "
     "/camera/info and /camera/stereo or /camera/depth (input), publishes /objects (latched). Of "
     "several images that wait only the newest is looked at. When there is no table or no object, "
     "/objects says why in `problem`. Whoever asks for a look (action /camera/look) gets the next "
     "picture's depth instead."},
    run);

}  // namespace
