#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "msgs/actions.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/gripper.h"
#include "msgs/truth.pb.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/simulation/arm_commands.h"
#include "nodes/simulation/camera.h"
#include "nodes/simulation/motion_actions.h"
#include "nodes/simulation/reader_pace.h"
#include "nodes/simulation/robot_actions.h"
#include "nodes/simulation/robot_messages.h"
#include "nodes/simulation/robot_runner.h"
#include "nodes/simulation/sensor_messages.h"
#include "nodes/simulation/simulated_robot.h"
#include "nodes/touch_fidelity/touch_fidelity.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/clock_control.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/robot_files.h"
#include "prehend/simulation/robot_scene.h"
#include "prehend/simulation/scene.h"
#include "prehend/text/tree_file.h"

namespace {

using namespace prehend;

struct Settings {
  std::string scene, robot, robot_home;
  std::string stage;  // the platform, where neither they nor the scene name one
  bool show_robot = true;
  double speed = 1;
  bool paused = false;
  bool camera = true;
  bool depth = false;
  bool arm_is_emulated = false, hand_is_emulated = false;
  double camera_period = 0;
  int noise_seed = -1;
  simulation::RenderOptions render;
  fidelity::TouchRequest touch;
};

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.scene = node.declare_parameter<std::string>(
      {.name = "scene",
       .default_value = text::tree_file("config/scenes/demo.yaml"),
       .description = "scene file",
       .read_only = true,
       .reads_file = true});
  s.robot = node.declare_parameter<std::string>(
      {.name = "robot",
       .default_value = "",
       .description = "platform that stands in the scene: its name or file; empty: the scene's, "
                      "or stage_pg70",
       .read_only = true});
  const std::string platforms = nodes::declare_platforms(node);
  if (!s.robot.empty()) s.robot = robot::platform_file(platforms, s.robot).string();
  s.stage = (std::filesystem::path(platforms) / "stage_pg70.yaml").string();
  s.robot_home = node.declare_parameter<std::string>(
      {.name = "robot_home",
       .default_value = "",
       .description = "of the platform's homes, where the arm stands at first; empty: the scene's",
       .read_only = true});
  s.show_robot = node.declare_parameter<bool>(
      {.name = "show_robot",
       .default_value = true,
       .description = "the camera sees arm and hand; false: as if their links were masked",
       .read_only = true});
  s.paused =
      node.declare_parameter<bool>({.name = "paused",
                                    .default_value = false,
                                    .description = "begin with the clock paused, see prehend clock",
                                    .read_only = true});
  s.arm_is_emulated = node.declare_parameter<bool>(
      {.name = "arm_is_emulated",
       .default_value = false,
       .description =
           "an emulated controller moves the arm, as its driver says by wire: the driver "
           "minds the emergency stop, and not the simulated motors",
       .read_only = true});
  s.hand_is_emulated = node.declare_parameter<bool>({.name = "hand_is_emulated",
                                                     .default_value = false,
                                                     .description = "the same of hand or gripper",
                                                     .read_only = true});
  s.camera = node.declare_parameter<bool>(
      {.name = "camera",
       .default_value = true,
       .description = "publish /camera/info and a stereo pair at the start",
       .read_only = true});
  s.depth = node.declare_parameter<bool>(
      {.name = "depth",
       .default_value = false,
       .description = "the camera is a depth camera, too: /camera/depth, the left image and its "
                      "true depth",
       .read_only = true});
  if (s.depth && !s.camera) {
    throw geometry::InputError("Parameter depth is of the camera, and camera is false",
                               "Leave depth away");
  }
  s.camera_period = node.declare_parameter<double>(
      {.name = "camera_period",
       .default_value = 0.0,
       .unit = "s",
       .minimum = 0.0,
       .description = "simulated time between further stereo pairs, 0: on request only",
       .read_only = true});
  s.noise_seed =
      node.declare_parameter<int>({.name = "noise_seed",
                                   .default_value = -1,
                                   .minimum = -1,
                                   .description = "of the camera's noise, -1: that of the scene",
                                   .read_only = true});
  s.render.samples_per_side = node.declare_parameter<int>(
      {.name = "samples_per_side",
       .default_value = s.render.samples_per_side,
       .minimum = 1,
       .maximum = 4,
       .description = "rays of a pixel are its square; rendering time grows with them",
       .read_only = true});
  s.render.threads = node.declare_parameter<int>({.name = "render_threads",
                                                  .default_value = s.render.threads,
                                                  .minimum = 1,
                                                  .maximum = 64,
                                                  .description = "threads that render",
                                                  .read_only = true});
  s.touch = nodes::declare_touch_request(node, "", "the world");
  return s;
}

/// Who minds the emergency stop for which part of the robot.
class Emergencies {
 public:
  Emergencies(graph::Node& node, const Settings& settings)
      : minded_(node, true,
                settings.speed == 0 ? nodes::EmergencyStopListener::kSilenceOfNothingReal
                                    : nodes::EmergencyStopListener::kSilence),
        elsewhere_(node, false),
        settings_(settings) {}
  nodes::EmergencyStopListener& of_arm() {
    return settings_.arm_is_emulated ? elsewhere_ : minded_;
  }
  nodes::EmergencyStopListener& of_hand() {
    return settings_.hand_is_emulated ? elsewhere_ : minded_;
  }
  nodes::EmergencyStopListener& minded() { return minded_; }

 private:
  nodes::EmergencyStopListener minded_, elsewhere_;
  const Settings& settings_;
};

template <class Robot>
msgs::SpawnResponse spawn(Robot& robot, const msgs::SpawnRequest& request) {
  msgs::SpawnResponse response;
  try {
    const geometry::TriangleMesh mesh_W = convert::from_message(request.mesh());
    if (!(request.density() > 0)) throw std::invalid_argument("density must be positive");
    const double mass = request.density() * geometry::mass_properties(mesh_W).volume;
    if (!(mass > 0)) {
      throw std::invalid_argument("the mesh of '" + request.name() + "' encloses no volume");
    }
    robot.with_world(
        [&](auto& world) { world.add_object(request.name(), mesh_W, mass, request.is_static()); });
    response.set_success(true);
  } catch (const std::invalid_argument& error) {
    response.set_reason(error.what());
  } catch (const geometry::InputError& error) {
    response.set_reason(error.what());
  }
  return response;
}

robot::Positions arm_position(const simulation::World& world) {
  return simulation::stage_position(world);
}
robot::Positions arm_position(const simulation::RobotWorld& world) {
  return world.arm().position();
}

/// What the simulated world's node has, whatever robot stands in it.
template <class Robot>
class World {
 public:
  World(graph::Node& node, const Settings& settings, const simulation::Scene& scene,
        const robot::Platform& platform, Robot& robot, Emergencies& emergency)
      : robot_(robot),
        shows_robot_(settings.show_robot),
        shapes_(node.advertise<msgs::TruthShapes>("/ground_truth/shapes", graph::QoS::latched(1))) {
    if (settings.camera) {
      camera_ = std::make_unique<nodes::Camera>(
          node,
          [&robot, &platform, shows_always = settings.show_robot](bool shows_robot) {
            return robot.with_world([&](auto& world) {
              world.show_robot(shows_robot || shows_always);
              nodes::Camera::View view{world.visible_bodies(), world.time(),
                                       world.scene_generation(), std::nullopt};
              if (platform.X_FC) view.X_WC = platform.X_WC(arm_position(world));
              world.show_robot(shows_always);
              return view;
            });
          },
          scene, settings.render, settings.depth, platform.X_FC.has_value());
      camera_->request();
    }
    publish_shapes();
    spawn_ = node.serve<msgs::SpawnRequest, msgs::SpawnResponse>(
        "/simulation/spawn", [this, &robot, &emergency](const msgs::SpawnRequest& request) {
          // A large mesh takes long; the world stands still meanwhile.
          const nodes::EmergencyStopListener::Wait wait(emergency.minded());
          msgs::SpawnResponse response = spawn(robot, request);
          if (response.success()) publish_shapes();
          return response;
        });
    render_ = node.serve<msgs::RenderRequest, msgs::Acknowledge>(
        "/simulation/render", [this](const msgs::RenderRequest& request) {
          msgs::Acknowledge answer;
          answer.set_success(camera_ != nullptr);
          answer.set_reason(camera_ ? "the stereo pair follows" : "started with camera:=false");
          if (camera_) camera_->request(true, request.shows_robot());
          return answer;
        });
  }
  ~World() { robot_.stop(); }  // before the camera goes, which the robot's thread asks

  nodes::Camera* camera() { return camera_.get(); }

 private:
  void publish_shapes() {
    const std::vector<simulation::VisibleBody> bodies = robot_.with_world([this](auto& world) {
      world.show_robot(false);
      std::vector<simulation::VisibleBody> seen = world.visible_bodies();
      world.show_robot(shows_robot_);
      return seen;
    });
    msgs::TruthShapes message;
    message.mutable_header()->set_frame_id("world");
    for (const simulation::VisibleBody& body : bodies) {
      msgs::TruthShapes::Shape& shape = *message.add_shapes();
      shape.set_name(body.name);
      *shape.mutable_mesh() = convert::to_message(*body.mesh_B);
    }
    shapes_.publish(std::move(message));
  }

  Robot& robot_;
  bool shows_robot_;
  graph::Publisher<msgs::TruthShapes> shapes_;
  std::unique_ptr<nodes::Camera> camera_;
  graph::Service spawn_, render_;
};

/// Asks for the further pictures.
class PictureClock {
 public:
  explicit PictureClock(double period) : period_(graph::nanoseconds(period)), next_(period_) {}
  void set_camera(nodes::Camera* camera) { camera_ = camera; }
  void tell(std::int64_t stamp) {
    if (!camera_ || period_ <= 0 || stamp < next_) return;
    next_ += period_;
    camera_->request();
  }

 private:
  std::int64_t period_, next_;  // ns
  nodes::Camera* camera_ = nullptr;
};

void run_stage(graph::Node& node, const Settings& settings, simulation::Scene scene,
               const robot::Platform& platform, graph::ClockPacer& pacer) {
  using namespace prehend::nodes;
  const simulation::CarrierModel carrier = simulation::carrier_of(platform, scene.robot_home);
  if (scene.carrier != simulation::CarrierModel() && scene.carrier != carrier) {
    throw geometry::InputError(
        "The carrier of " + settings.scene + " is not that of platform " + platform.name,
        "Leave `carrier` out of the scene: what carries the gripper is the platform's (robot)");
  }
  scene.carrier = carrier;
  scene.robot.clear();
  const auto description =
      node.advertise<msgs::GripperDescription>("/gripper/model", graph::QoS::latched(1));
  description.publish(convert::describe_gripper(scene.gripper_file));
  SensorPublisher sensors(node, scene);
  PictureClock pictures(settings.camera_period);
  ReaderPace pace(node, pacer);
  SimulatedRobot robot(
      node, scene, platform, scene.robot_home, pacer,
      [&](const SensorReadings& readings) {
        sensors.publish_clock(readings.stamp, pacer.state());
        sensors.publish(readings);
        pictures.tell(readings.stamp);
        pace.slice_published();
      },
      [&](std::int64_t stamp) { sensors.publish_clock(stamp, pacer.state()); });
  robot.with_world([&](auto& world) { world.show_robot(settings.show_robot); });
  Emergencies emergency(node, settings);
  World world(node, settings, scene, platform, robot, emergency);
  pictures.set_camera(world.camera());
  const MotionActions motion(node, robot, emergency.of_hand());
  const ArmAction arm(node, robot, emergency.of_arm());
  const ArmCommands commands(node, robot, emergency.of_arm());
  node.log_info("robot {}", platform.name);
  robot.start();
  node.spin();
}

void run_arm(graph::Node& node, const Settings& settings, const simulation::Scene& scene,
             const robot::Platform& platform, graph::ClockPacer& pacer) {
  using namespace prehend::nodes;
  for (const simulation::SceneRemark& remark : simulation::check_for_robot(scene, platform)) {
    if (remark.replaced) {
      node.log_info("{}", remark.text);
    } else {
      node.log_warning("{}", remark.text);
    }
  }
  RobotPublisher sensors(node, platform.hand);
  PictureClock pictures(settings.camera_period);
  ReaderPace pace(node, pacer);
  RobotRunner robot(
      node, simulation::RobotWorld(platform, scene, scene.robot_home), pacer,
      SimulatedRobot::slice_of(scene),
      [&](const RobotReadings& readings) {
        sensors.publish_clock(readings.stamp, pacer.state());
        sensors.publish(readings);
        pictures.tell(readings.stamp);
        pace.slice_published();
      },
      [&](std::int64_t stamp) { sensors.publish_clock(stamp, pacer.state()); });
  robot.with_world([&](auto& world) { world.show_robot(settings.show_robot); });
  Emergencies emergency(node, settings);
  World world(node, settings, scene, platform, robot, emergency);
  pictures.set_camera(world.camera());
  const RobotActions actions(node, robot, emergency.of_arm(), emergency.of_hand());
  const ArmCommands commands(node, robot, emergency.of_arm());
  node.log_info("robot {}", platform.name);
  robot.start();
  node.spin();
}

void run(graph::Node& node) {
  using namespace prehend::nodes;
  Settings settings = declare_settings(node);
  graph::ClockPacer* running = nullptr;
  settings.speed = node.declare_parameter<double>(
      {.name = "speed",
       .default_value = 1.0,
       .unit = "s/s",
       .minimum = 0.0,
       .description = "simulated seconds per wall second, 0: as fast as the subscribers' "
                      "callbacks, without loss",
       .on_change = [&running](const double& value) {
         if (running) running->set_speed(value);
       }});
  simulation::Scene scene = simulation::read_scene(settings.scene, settings.robot);
  if (!settings.robot_home.empty()) scene.robot_home = settings.robot_home;
  if (settings.noise_seed >= 0) {
    scene.camera.seed = static_cast<std::uint32_t>(settings.noise_seed);
  }

  const robot::Platform platform =
      robot::read_platform(scene.robot.empty() ? settings.stage : scene.robot.string());
  for (const std::string& remark : platform.model.remarks) node.log_warning("{}", remark);
  const bool on_stage = platform.hand_port == robot::HandPort::kGripper;
  if (settings.touch.is_asked()) {
    node.log_info("steps chosen: {}",
                  fidelity::choose_touch(settings.touch, platform, &scene).text);
  }

  graph::ClockPacerOptions clock;
  clock.speed = settings.speed;
  clock.paused = settings.paused;
  clock.slice = SimulatedRobot::slice_of(scene);
  graph::ClockPacer pacer(clock);
  running = &pacer;
  const graph::ClockControl clock_control(node, pacer, [&node](double value) {
    node.set_parameter("speed", fmt::format("{}", value));
  });
  node.log_info("scene {}: {} objects", settings.scene, scene.objects.size());
  if (on_stage) {
    run_stage(node, settings, scene, platform, pacer);
  } else {
    run_arm(node, settings, scene, platform, pacer);
  }
}

const prehend::graph::RegisteredNodeProgram registered(
    {"simulation",
     "Stands in for the robot: table, objects, a platform (robot) and a stereo camera, from a "
     "scene "
     "file. Publishes /clock, /camera/info, /camera/stereo, /joint_states, /tactile/PAD, "
     "/tactile/cells, /wrench, /ground_truth and /ground_truth/shapes; takes the action "
     "/arm/follow, the topic "
     "/arm/command (set points of all its joints, one a cycle of whoever interpolates; braked 0.2 "
     "s "
     "after the last one while moving) and the services /arm/stop, "
     "/simulation/spawn, /simulation/render and /clock/control (pause, resume, step, speed). A "
     "hand that is moved by its joints has the action /hand/move, the topic /hand/command (stopped "
     "0.2 s after the last one while moving) and the service /hand/stop. A "
     "parallel gripper on a stage has /gripper/model and /gripper/state, /gripper/command (stopped "
     "0.2 s after the last one while moving), the action /gripper/move and the services "
     "/gripper/stop, /gripper/fast_stop and /gripper/acknowledge. /emergency_stop brakes arm, hand "
     "and gripper, which hold what they grip, and refuses motions until it is reset."},
    run);

}  // namespace
