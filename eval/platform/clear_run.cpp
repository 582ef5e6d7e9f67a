#include "eval/platform/clear_run.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include <yaml-cpp/yaml.h>

#include "eval/platform/launched.h"
#include "eval/text_files.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/outcomes.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/truth.pb.h"
#include "prehend/control/task.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

constexpr const char* kTask = "clear_table";
constexpr auto kLongest = std::chrono::seconds(900);  // wall time of a launch
constexpr double kMoved = 0.02;                       // m
constexpr const char* kOpening = "; opening";         // what ArmCycle says after a failure's words

using Places = std::map<std::string, Eigen::Vector3d>;  // of bodies [m]

// Follows a recording, in its order.
class ClearWatch {
 public:
  explicit ClearWatch(ClearResult* result) : result_(result) {}

  void take(const msgs::TruthShapes& truth) {
    for (const auto& shape : truth.shapes()) {
      middles_B_[shape.name()] =
          geometry::mass_properties(convert::from_message(shape.mesh())).center_of_mass;
    }
  }
  // Where its middle is: the foot of a bottle that lies tells little of where it lies.
  void take(const msgs::GroundTruth& truth) {
    for (const auto& body : truth.bodies()) {
      const auto middle = middles_B_.find(body.name());
      now_[body.name()] = convert::from_message(body.x_wb()) *
                          (middle == middles_B_.end() ? Eigen::Vector3d::Zero() : middle->second);
    }
  }
  void take(const msgs::ObjectHypotheses& objects) {
    if (!looked_) result_->found = objects.objects_size();
    looked_ = true;
  }
  void take(const msgs::CycleState& state) {
    const control::Phase phase = convert::from_message(state.phase());
    const bool begins = phase != last_;
    if (begins && (phase == control::Phase::kApproach || phase == control::Phase::kPush)) {
      end_attempt();
      if (!first_stamp_) first_stamp_ = state.header().stamp();
    }
    // What a push moves is what it is for.
    if (begins && phase == control::Phase::kApproach) before_ = now_;
    if (begins && phase != control::Phase::kRelease) pushes_ = phase == control::Phase::kPush;
    last_ = phase;
    last_stamp_ = state.header().stamp();
    const std::string& detail = state.detail();
    const std::size_t at = detail.rfind(kOpening);
    // A push is no attempt, and no failed one.
    if (phase != control::Phase::kRelease || at == std::string::npos || pushes_) return;
    const std::string words = detail.substr(0, at);
    ++result_->said[words];
    ++result_->failures[cause_of(words)];
  }
  void take(const msgs::CycleResult& end) {
    result_->ended = true;
    result_->attempts = static_cast<int>(end.attempts());
    result_->pushes = static_cast<int>(end.pushes());
    result_->reason = end.reason();
    last_stamp_ = end.header().stamp();
  }

  void finish(const control::Task& task) {
    end_attempt();
    if (first_stamp_) result_->simulated = 1e-9 * static_cast<double>(last_stamp_ - *first_stamp_);
    result_->bodies = static_cast<int>(now_.size());
    for (const auto& [name, p_W] : now_) {
      if (task.is_placed(p_W.head<2>())) {
        ++result_->cleared;
      } else {
        result_->left.push_back(name);
      }
    }
  }

 private:
  // What moved most was what it was about.
  void end_attempt() {
    std::vector<double> moved;
    for (const auto& [name, p_W] : before_) moved.push_back((now_[name] - p_W).norm());
    std::sort(moved.begin(), moved.end());
    if (!moved.empty()) moved.pop_back();
    result_->neighbours += static_cast<int>(
        std::count_if(moved.begin(), moved.end(), [](double m) { return m > kMoved; }));
    before_.clear();
  }

  ClearResult* result_;
  Places now_, before_;
  Places middles_B_;  // of the bodies' own frames
  bool looked_ = false, pushes_ = false;
  std::optional<control::Phase> last_;
  std::optional<std::int64_t> first_stamp_;  // ns
  std::int64_t last_stamp_ = 0;
};

template <class Message>
void give(const std::string& data, ClearWatch& watch) {
  Message message;
  if (message.ParseFromString(data)) watch.take(message);
}

void judge(const std::filesystem::path& recording, ClearResult* result) {
  ClearWatch watch(result);
  recording::McapReader reader(recording.string());
  auto cursor = reader.messages();
  while (const auto message = cursor.next()) {
    const std::string& topic = reader.channels().at(message->channel_id).topic;
    const std::string data(message->data);
    if (topic == "/ground_truth/shapes") give<msgs::TruthShapes>(data, watch);
    if (topic == "/ground_truth") give<msgs::GroundTruth>(data, watch);
    if (topic == "/objects") give<msgs::ObjectHypotheses>(data, watch);
    if (topic == "/cycle/state") give<msgs::CycleState>(data, watch);
    if (topic == "/cycle/result") give<msgs::CycleResult>(data, watch);
  }
  watch.finish(control::read_task(control::task_file(text::tree_file("config/tasks"), kTask)));
}

}  // namespace

std::string cause_of(const std::string& words) {
  static constexpr std::pair<const char*, const char*> kCauses[] = {{"closed on nothing", "shape"},
                                                                    {"touched something", "shape"},
                                                                    {"lost while", "slip"},
                                                                    {"nothing is held", "slip"},
                                                                    {"did not leave", "slip"},
                                                                    {"foretell", "touch"},
                                                                    {"hit something", "motion"},
                                                                    {"took too long", "motion"},
                                                                    {"cannot follow", "motion"},
                                                                    {"limit", "motion"},
                                                                    {"path", "motion"}};
  for (const auto& [part, cause] : kCauses) {
    if (words.find(part) != std::string::npos) return cause;
  }
  return "other";
}

int ClearResult::graspable_cleared() const {
  if (bodies == 0) return 0;
  return static_cast<int>(
      std::count_if(graspable.begin(), graspable.end(), [this](const std::string& name) {
        return std::find(left.begin(), left.end(), name) == left.end();
      }));
}

ClearResult run_clear(const std::filesystem::path& file, const std::string& platform,
                      const std::vector<std::string>& arguments,
                      const std::filesystem::path& folder, const std::filesystem::path& programs) {
  ClearResult result;
  result.scene = file.stem().string();
  result.platform = platform;
  std::vector<std::string> words{std::string("task:=") + kTask};
  words.insert(words.end(), arguments.begin(), arguments.end());
  make_folder(folder);
  const auto start = std::chrono::steady_clock::now();
  const int exit_code = run_demo(programs, file, platform, folder, words, kLongest);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  try {
    judge(folder / "recording.mcap", &result);
    if (!result.ended) result.reason = exit_code < 0 ? "it did not end" : "no result of the cycle";
  } catch (const std::exception& error) {
    result.reason = error.what();
  }
  return result;
}

std::string to_text(const ClearResult& r) {
  YAML::Node map;
  map["scene"] = r.scene;
  map["platform"] = r.platform;
  map["kind"] = r.kind;
  map["bodies"] = r.bodies;
  map["cleared"] = r.cleared;
  map["graspable"] = r.graspable;
  map["found"] = r.found;
  map["attempts"] = r.attempts;
  map["pushes"] = r.pushes;
  map["neighbours"] = r.neighbours;
  map["simulated"] = r.simulated;
  map["seconds"] = r.seconds;
  map["ended"] = r.ended;
  map["reason"] = r.reason;
  map["left"] = r.left;
  map["failures"] = r.failures;
  map["said"] = r.said;
  YAML::Emitter out;
  out << map;
  return out.c_str();
}

ClearResult read_clear(const std::string& text) {
  try {
    const YAML::Node map = YAML::Load(text);
    ClearResult r;
    r.scene = map["scene"].as<std::string>();
    r.platform = map["platform"].as<std::string>();
    r.kind = map["kind"].as<std::string>();
    r.bodies = map["bodies"].as<int>();
    r.cleared = map["cleared"].as<int>();
    r.graspable = map["graspable"].as<std::vector<std::string>>();
    r.found = map["found"].as<int>();
    r.attempts = map["attempts"].as<int>();
    r.pushes = map["pushes"].as<int>();
    r.neighbours = map["neighbours"].as<int>();
    r.simulated = map["simulated"].as<double>();
    r.seconds = map["seconds"].as<double>();
    r.ended = map["ended"].as<bool>();
    r.reason = map["reason"].as<std::string>();
    r.left = map["left"].as<std::vector<std::string>>();
    r.failures = map["failures"].as<std::map<std::string, int>>();
    r.said = map["said"].as<std::map<std::string, int>>();
    return r;
  } catch (const YAML::Exception& error) {
    throw geometry::InputError(std::string("The text is no result: ") + error.what(),
                               "Run the case again");
  }
}

}  // namespace prehend::eval
