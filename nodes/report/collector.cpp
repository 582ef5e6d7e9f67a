#include "nodes/report/collector.h"

#include <algorithm>
#include <cmath>

#include "msgs/convert/geometry.h"
#include "msgs/convert/outcomes.h"
#include "msgs/graph.pb.h"

namespace prehend::nodes {
namespace {

constexpr std::size_t kMostLogLines = 200;
constexpr std::size_t kMostBeliefs = 32;

double time_of(const msgs::Header& header) { return graph::seconds(header.stamp()); }

void keep_newest(const msgs::ObjectModel& model,
                 std::map<std::pair<std::int64_t, std::uint32_t>, msgs::ObjectModel>* models) {
  (*models)[{model.header().stamp(), model.id()}] = model;
  while (models->size() > kMostBeliefs) models->erase(models->begin());
}

}  // namespace

template <class Message, class Action>
void Collector::listen(const std::string& topic, const graph::QoS& qos, Action action) {
  subscriptions_.push_back(node_.subscribe<Message>(
      topic, qos, [this, action](const graph::Received<Message>& received) {
        {
          const std::lock_guard lock(mutex_);
          action(*received);
          last_news_ = std::chrono::steady_clock::now();
        }
        changed_.notify_all();
      }));
}

template <class Message, class Action>
void Collector::follow(const std::string& topic, Action action) {
  subscriptions_.push_back(node_.subscribe<Message>(
      topic, graph::QoS::queue(1000), [this, action](const graph::Received<Message>& received) {
        const std::lock_guard lock(mutex_);
        action(*received);
      }));
}

Collector::Collector(graph::Node& node, const std::vector<std::string>& pads, Moves moves)
    : node_(node) {
  using graph::QoS;
  Collected& c = collected_;
  listen<msgs::CameraInfo>("/camera/info", QoS::queue(1), [&c](const auto& m) { c.camera = m; });
  listen<msgs::StereoPair>("/camera/stereo", QoS::queue(2), [&c](const auto& m) {
    if (!c.stereo) c.stereo = m;  // the one that was segmented, before the gripper is in the way
  });
  listen<msgs::PointCloud>("/camera/cloud", QoS::queue(8),
                           [&c](const auto& m) { c.clouds.push_back(m); });
  listen<msgs::ObjectHypotheses>("/objects", QoS::queue(2), [this, &c](const auto& m) {
    c.objects = m;
    without_objects_since_.reset();
    if (m.objects().empty()) without_objects_since_ = std::chrono::steady_clock::now();
  });
  listen<msgs::CompletedShape>("/shapes", QoS::queue(64),
                               [&c](const auto& m) { c.shapes[m.id()] = m; });
  listen<msgs::ObjectModel>("/models", QoS::queue(64), [&c](const auto& m) {
    c.models[m.id()] = m;
    keep_newest(m, &c.believed);
  });
  listen<msgs::ObjectModel>("/predicted_models", QoS::queue(64),
                            [&c](const auto& m) { keep_newest(m, &c.predicted); });
  listen<msgs::Belief>("/belief", QoS::queue(64), [&c](const auto& m) {
    if (c.beliefs.size() < kMostBeliefs) c.beliefs.push_back(m);
  });
  listen<msgs::ObjectModel>("/held/model", QoS::queue(64), [&c](const auto& m) {
    if (c.held.size() < kMostBeliefs) c.held.push_back(m);
  });
  listen<msgs::PerceptSurprise>("/percepts/surprise", QoS::queue(64), [&c](const auto& m) {
    if (c.percept_surprises.size() < kMostBeliefs) c.percept_surprises.push_back(m);
  });
  listen<msgs::GraspPlan>("/plans", QoS::queue(64), [&c](const auto& m) { c.plans[m.id()] = m; });
  listen<msgs::Surprise>("/surprise", QoS::queue(64),
                         [&c](const auto& m) { c.surprises.push_back(m); });
  listen<msgs::CycleState>("/cycle/state", QoS::queue(64), [this](const auto& m) { on_phase(m); });
  listen<msgs::CycleResult>("/cycle/result", QoS::queue(2), [&c](const auto& m) { c.result = m; });
  listen<msgs::Task>("/cycle/task", QoS::latched(1), [&c](const auto& m) { c.task = m; });
  listen<msgs::TactileCells>("/tactile/cells", QoS::latched(1), [&c](const auto& m) {
    for (const msgs::PadCells& pad : m.pads()) c.cells[pad.name()] = pad;
  });
  for (const std::string& pad : pads) {
    follow<msgs::TactileFrame>("/tactile/" + pad, [&c, pad](const auto& m) {
      c.pads[pad] = m;
      c.pad_sums[pad].emplace_back(time_of(m.header()), m.sum());
    });
  }
  follow<msgs::Touch>("/touch", [&c](const auto& m) {
    for (const msgs::PadTouch& pad : m.pads()) c.touch[pad.pad()] = pad;
  });
  if (moves == Moves::kGripper) {
    follow<msgs::GripperState>("/gripper/state", [&c](const auto& m) {
      c.opening.emplace_back(time_of(m.header()), m.opening());
    });
  }
  follow<msgs::JointState>("/joint_states", [&c](const auto& m) {
    for (int i = 0; i < std::min(m.name_size(), m.position_size()); ++i) {
      c.joints[m.name(i)].emplace_back(time_of(m.header()), m.position(i));
    }
  });
  follow<msgs::Wrench>("/wrench", [&c](const auto& m) {
    c.wrench_z.emplace_back(time_of(m.header()), m.wrench().force().z());
  });
  follow<msgs::GroundTruth>("/ground_truth", [this](const auto& m) { on_ground_truth(m); });
  listen<msgs::TruthShapes>("/ground_truth/shapes", QoS::latched(1),
                            [&c](const auto& m) { c.true_shapes = m; });
  follow<msgs::graph::LogLine>("/log", [&c](const auto& m) {
    if (m.level() < msgs::graph::WARNING || c.log.size() >= kMostLogLines) return;
    c.log.push_back(m.node() + ": " + m.text());
  });
}

void Collector::on_phase(const msgs::CycleState& state) {
  auto& phases = collected_.phases;
  const control::Phase phase = convert::from_message(state.phase());
  if (phase == control::Phase::kSpawn) collected_.on_prediction = true;
  if (!phases.empty() && phases.back().second == phase) return;
  double felt = 0;  // N
  for (const auto& [pad, frame] : collected_.pads) felt += frame.sum();
  if (!phases.empty() && felt > 0) {
    collected_.snapshots.push_back({phases.back().second, collected_.pads, collected_.touch});
  }
  phases.emplace_back(time_of(state.header()), phase);
}

void Collector::on_ground_truth(const msgs::GroundTruth& truth) {
  const double time = time_of(truth.header());
  for (const auto& body : truth.bodies()) {
    BodyHistory& history = collected_.bodies[body.name()];
    const auto& p = body.x_wb().position();
    if (history.height.empty()) {
      history.start_x = p.x();
      history.start_y = p.y();
    }
    history.height.emplace_back(time, body.height());
    history.poses.emplace_back(time, convert::from_message(body.x_wb()));
    history.horizontal.emplace_back(time,
                                    std::hypot(p.x() - history.start_x, p.y() - history.start_y));
  }
}

bool Collector::wait_for_end(std::chrono::duration<double> timeout,
                             std::chrono::duration<double> patience) {
  using Clock = std::chrono::steady_clock;
  std::unique_lock lock(mutex_);
  last_news_ = Clock::now();
  while (node_.ok() && Clock::now() - last_news_ < timeout) {
    if (collected_.result) return true;
    // Once the robot moves, that nothing is left to be seen is the cycle's to say.
    const bool has_begun =
        std::any_of(collected_.phases.begin(), collected_.phases.end(),
                    [](const auto& phase) { return phase.second != control::Phase::kWaiting; });
    if (!has_begun && without_objects_since_ && Clock::now() - *without_objects_since_ > patience) {
      return true;
    }
    changed_.wait_for(lock, std::chrono::milliseconds(100));
  }
  return false;
}

Collected Collector::snapshot() const {
  const std::lock_guard lock(mutex_);
  return collected_;
}

}  // namespace prehend::nodes
