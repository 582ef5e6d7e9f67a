#include "eval/platform/pick_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include <yaml-cpp/yaml.h>

#include "eval/platform/launched.h"
#include "msgs/convert/outcomes.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"
#include "prehend/recording/mcap_reader.h"

namespace prehend::eval {
namespace {

using Outcome = PickResult::Outcome;
using std::chrono::steady_clock;

constexpr auto kTimeout = std::chrono::seconds(240);
constexpr double kRaised = 0.05;     // m
constexpr double kPutDown = 0.01;    // m, over the table
constexpr double kDisturbed = 0.02;  // m
constexpr const char* kNames[] = {"picked", "no grasp", "failed", "false claim"};

struct Path {                                             // of a body
  double first_height = 0, highest = 0, last_height = 0;  // m
  Eigen::Vector2d first = Eigen::Vector2d::Zero(), last = Eigen::Vector2d::Zero();
  double moved() const { return (last - first).norm(); }
};

struct Recorded {
  std::map<std::string, Path> bodies;
  std::map<std::string, int> counts;  // of messages by topic
  std::optional<control::Phase> last_phase;
  std::optional<msgs::CycleResult> result;
  std::map<std::uint32_t, msgs::GraspPlan> plans;
};

Recorded read_recording(const std::filesystem::path& file) {
  Recorded recorded;
  recording::McapReader reader(file.string());
  auto cursor = reader.messages();
  while (const auto message = cursor.next()) {
    const std::string& topic = reader.channels().at(message->channel_id).topic;
    const std::string data(message->data);
    ++recorded.counts[topic];
    if (topic == "/ground_truth") {
      msgs::GroundTruth truth;
      if (!truth.ParseFromString(data)) continue;
      for (const auto& body : truth.bodies()) {
        const auto& p = body.x_wb().position();
        auto [found, is_new] = recorded.bodies.try_emplace(body.name());
        Path& path = found->second;
        path.last = {p.x(), p.y()};
        path.last_height = body.height();
        if (is_new) {
          path.first = path.last;
          path.first_height = path.highest = body.height();
        }
        path.highest = std::max(path.highest, body.height());
      }
    } else if (topic == "/cycle/state") {
      msgs::CycleState state;
      if (!state.ParseFromString(data)) continue;
      const control::Phase phase = convert::from_message(state.phase());
      // What settled before is no doing of the robot.
      if (!recorded.last_phase && phase == control::Phase::kApproach) {
        for (auto& [name, path] : recorded.bodies) {
          path.first = path.last;
          path.first_height = path.highest = path.last_height;
        }
      }
      if (phase != control::Phase::kFailed && phase != control::Phase::kRelease) {
        recorded.last_phase = phase;
      }
    } else if (topic == "/cycle/result") {
      msgs::CycleResult result;
      if (result.ParseFromString(data)) recorded.result = result;
    } else if (topic == "/plans") {
      msgs::GraspPlan plan;
      if (plan.ParseFromString(data)) recorded.plans[plan.id()] = plan;
    }
  }
  return recorded;
}

// The first stage of which nothing came.
std::string stage_of(const Recorded& recorded) {
  for (const char* topic : {"/objects", "/shapes", "/models", "/plans"}) {
    if (recorded.counts.count(topic) == 0) return topic + 1;
  }
  return recorded.last_phase ? control::to_string(*recorded.last_phase) : "plans";
}

void judge(const Recorded& recorded, int exit_code, PickResult* result) {
  for (const auto& [name, path] : recorded.bodies) {
    if (path.highest - path.first_height <= result->raised) continue;
    result->raised = path.highest - path.first_height;
    result->body = result->raised >= kRaised ? name : "";
  }
  bool put_down = false;
  for (const auto& [name, path] : recorded.bodies) {
    if (name == result->body) {
      result->carried = path.moved();
      put_down = path.last_height < kPutDown;
    } else {
      result->disturbed = std::max(result->disturbed, path.moved());
    }
  }
  result->stage = stage_of(recorded);
  if (!recorded.result) {
    result->reason = exit_code < 0 ? "it did not end" : "no result of the cycle";
    return;
  }
  const msgs::CycleResult& end = *recorded.result;
  result->attempts = static_cast<int>(end.attempts());
  const control::CycleOutcome outcome = convert::from_message(end.outcome());
  result->reason = outcome == control::CycleOutcome::kUngraspable
                       ? grasp::ungraspable_text(end.reason())
                       : end.reason();
  const auto plan = recorded.plans.find(end.object_id());
  if (plan != recorded.plans.end() &&
      static_cast<int>(end.grasp_index()) < plan->second.grasps_size()) {
    result->score = plan->second.grasps(static_cast<int>(end.grasp_index())).score();
  }
  if (outcome != control::CycleOutcome::kSucceeded) {
    if (end.attempts() == 0) result->outcome = Outcome::kNoGrasp;
    return;
  }
  const bool picked = !result->body.empty() && put_down && result->disturbed <= kDisturbed;
  result->outcome = picked ? Outcome::kPicked : Outcome::kFalseClaim;
  if (!picked) {
    result->reason = result->body.empty() ? "nothing was raised"
                     : !put_down          ? "it does not stand on the table"
                                          : "another body was moved";
  }
}

}  // namespace

std::string to_string(Outcome outcome) { return kNames[static_cast<std::size_t>(outcome)]; }

PickResult run_pick(const TableScene& scene, const std::string& platform,
                    const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::filesystem::path& programs) {
  PickResult result;
  result.scene = scene.name;
  result.platform = platform;
  result.bodies = static_cast<int>(scene.bodies.size());
  const std::filesystem::path file = std::filesystem::absolute(write_scene(scene, folder));
  const auto start = steady_clock::now();
  const int exit_code = run_demo(programs, file, platform, folder, arguments, kTimeout);
  result.seconds = std::chrono::duration<double>(steady_clock::now() - start).count();
  try {
    judge(read_recording(folder / "recording.mcap"), exit_code, &result);
  } catch (const std::exception& error) {
    result.stage = "launch";
    result.reason = error.what();
  }
  return result;
}

std::string to_text(const PickResult& r) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  const auto put = [&out](const char* key, const auto& value) {
    out << YAML::Key << key << YAML::Value << value;
  };
  put("scene", r.scene);
  put("platform", r.platform);
  put("bodies", r.bodies);
  put("outcome", static_cast<int>(r.outcome));
  put("body", r.body);
  put("raised", r.raised);
  put("carried", r.carried);
  put("disturbed", r.disturbed);
  put("attempts", r.attempts);
  put("score", r.score);
  put("seconds", r.seconds);
  put("stage", r.stage);
  put("reason", r.reason);
  out << YAML::EndMap;
  return out.c_str();
}

PickResult read_pick(const std::string& text) {
  try {
    const YAML::Node map = YAML::Load(text);
    PickResult r;
    r.scene = map["scene"].as<std::string>();
    r.platform = map["platform"].as<std::string>();
    r.bodies = map["bodies"].as<int>();
    r.outcome = static_cast<Outcome>(
        std::clamp<int>(map["outcome"].as<int>(), 0, static_cast<int>(std::size(kNames)) - 1));
    r.body = map["body"].as<std::string>();
    r.raised = map["raised"].as<double>();
    r.carried = map["carried"].as<double>();
    r.disturbed = map["disturbed"].as<double>();
    r.attempts = map["attempts"].as<int>();
    r.score = map["score"].as<double>();
    r.seconds = map["seconds"].as<double>();
    r.stage = map["stage"].as<std::string>();
    r.reason = map["reason"].as<std::string>();
    return r;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result: ") + error.what(),
                               "Run the case again");
  }
}

}  // namespace prehend::eval
