#include <chrono>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "msgs/convert/objects.h"
#include "msgs/objects.pb.h"
#include "prehend/graph/node_program.h"
#include "prehend/planning/known_models.h"

namespace {

using namespace prehend;
using std::chrono::steady_clock;

constexpr std::size_t kMostObjects = 32;  // that wait for a late reader
constexpr std::size_t kMostViews = 4;     // of which the answers are kept

/// The known objects, read again when the folder has other files than before.
struct Shelf {
  std::string folder;
  double scale = 1;
  grasp::RecognitionOptions options;
  std::vector<std::string> files;
  std::unique_ptr<planning::KnownModels> models;

  /// Whether there are others now. @throws as planning::KnownModels.
  bool read() {
    std::vector<std::string> now = planning::known_model_files(folder);
    if (models && now == files) return false;
    models = std::make_unique<planning::KnownModels>(folder, scale, options);
    files = std::move(now);
    return true;
  }
};

Shelf declare_shelf(graph::Node& node) {
  grasp::RecognitionOptions options;
  const auto folder = node.declare_parameter<std::string>(
      {.name = "models",
       .description = "folder of the known objects' meshes (.ply, .obj, .stl), looked through anew "
                      "with each view",
       .read_only = true,
       .reads_file = true});
  const auto scale = node.declare_parameter<double>({.name = "scale",
                                                     .default_value = 1.0,
                                                     .minimum = 1e-6,
                                                     .maximum = 1e3,
                                                     .description = "metres per unit of the files",
                                                     .read_only = true});
  options.tolerance = node.declare_parameter<double>(
      {.name = "tolerance",
       .default_value = options.tolerance,
       .unit = "m",
       .minimum = 1e-5,
       .maximum = 0.1,
       .description = "that a seen point may be off the known surface",
       .read_only = true});
  options.least_explained = node.declare_parameter<double>(
      {.name = "least_explained",
       .default_value = options.least_explained,
       .minimum = 0.0,
       .maximum = 1.0,
       .description = "share of the seen points that the known surface has to explain",
       .read_only = true});
  options.most_violated = node.declare_parameter<double>(
      {.name = "most_violated",
       .default_value = options.most_violated,
       .minimum = 0.0,
       .maximum = 1.0,
       .description = "share of the known surface that may stand where the camera saw nothing",
       .read_only = true});
  options.size_margin = node.declare_parameter<double>(
      {.name = "size_margin",
       .default_value = options.size_margin,
       .unit = "m",
       .minimum = 0.0,
       .maximum = 1.0,
       .description =
           "by which the seen object may be larger or smaller than the known one, beyond "
           "three standard deviations of what its points tell",
       .read_only = true});
  Shelf shelf{folder, scale, options, {}, nullptr};
  shelf.read();
  return shelf;
}

class KnownObjects {
 public:
  explicit KnownObjects(graph::Node& node)
      : node_(node),
        shelf_(declare_shelf(node)),
        patience_(node.declare_parameter<double>({.name = "patience",
                                                  .default_value = 5.0,
                                                  .unit = "s",
                                                  .minimum = 0.0,
                                                  .description = "wall time that a predicted model "
                                                                 "waits for its view",
                                                  .read_only = true})),
        publisher_(node.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(kMostObjects))),
        predicted_(node.subscribe<msgs::ObjectModel>(
            "/predicted_models", graph::QoS::latched(kMostObjects),
            [this](const graph::Received<msgs::ObjectModel>& model) {
              waiting_.push_back({*model, steady_clock::now()});
              answer();
            })),
        views_(node.subscribe<msgs::ObjectHypotheses>(
            "/objects", graph::QoS::latched(),
            [this](const graph::Received<msgs::ObjectHypotheses>& view) {
              recognise(*view);
              answer();
            })),
        timer_(node.create_timer(0.25, [this] { answer(); })) {
    node.log_info("{} known objects", shelf_.models->size());
  }

 private:
  using Answers = std::map<std::uint32_t, planning::KnownModels::Found>;  // by the object's id
  struct Waiting {
    msgs::ObjectModel model;
    steady_clock::time_point since;
  };

  void recognise(const msgs::ObjectHypotheses& message) {
    Answers& answers = answers_[message.header().stamp()];
    while (answers_.size() > kMostViews) answers_.erase(answers_.begin());
    int known = 0;
    std::string problem;
    const std::string unread = node_.shield("known objects", [&] {
      if (shelf_.read()) node_.log_info("{} known objects now", shelf_.models->size());
    });
    if (!unread.empty()) problem = "; those known before stay: " + unread;
    const std::string damage = node_.shield("objects", [&] {
      const perception::SegmentedScene scene = convert::from_message(message);
      for (const perception::ObjectHypothesis& object : scene.objects) {
        const auto id = static_cast<std::uint32_t>(object.id);
        const std::string failure = node_.shield(fmt::format("object {}", id), [&] {
          const grasp::Recognition& best =
              answers.insert_or_assign(id, shelf_.models->recognise(scene, object))
                  .first->second.best;
          known += best.accepted ? 1 : 0;
          node_.log_info("object {} {} {}{}{}", id, best.accepted ? "is" : "is not", best.name,
                         best.accepted ? fmt::format(": {:.0f} % of its seen points are explained",
                                                     100 * best.explained)
                                       : ": ",
                         best.reason);
        });
        if (!failure.empty()) problem = fmt::format("; object {}: {}", id, failure);
      }
    });
    if (!damage.empty()) problem = "; objects are damaged: " + damage;
    node_.report(
        problem.empty() ? graph::Health::kOk : graph::Health::kWarning,
        fmt::format("{} of {} objects are known{}", known, message.objects_size(), problem));
  }

  // Publishes every model whose view was looked at, or has not come in time.
  void answer() {
    std::deque<Waiting> still;
    for (Waiting& waiting : waiting_) {
      const auto view = answers_.find(waiting.model.header().stamp());
      const double waited =
          std::chrono::duration<double>(steady_clock::now() - waiting.since).count();
      if (view == answers_.end() && waited < patience_) {
        still.push_back(std::move(waiting));
        continue;
      }
      if (view == answers_.end()) {
        node_.report(graph::Health::kWarning,
                     fmt::format("object {}: its view has not come, it stays as predicted",
                                 waiting.model.id()));
      } else if (const auto found = view->second.find(waiting.model.id());
                 found != view->second.end() && found->second.best.accepted) {
        node_.shield(fmt::format("object {}", waiting.model.id()),
                     [&] { put_in_place(found->second, &waiting.model); });
      }
      publisher_.publish(std::move(waiting.model));
    }
    waiting_ = std::move(still);
  }

  // What the view says stays; the solid is the known one.
  static void put_in_place(const planning::KnownModels::Found& found, msgs::ObjectModel* model) {
    msgs::ObjectModel known = convert::to_message(found.model_W);
    *known.mutable_header() = model->header();
    known.set_id(model->id());
    known.set_object_count(model->object_count());
    *known.mutable_table() = model->table();
    *known.mutable_times() = model->times();
    known.set_touches_image_border(model->touches_image_border());
    known.set_occluded_share(model->occluded_share());
    known.set_seen_deviation(found.best.residual);
    known.set_vote(1 - found.best.explained);
    known.set_confidence(found.best.explained);
    known.set_method("known");
    *known.mutable_known() = convert::to_message(found.best);
    *model = std::move(known);
  }

  graph::Node& node_;
  Shelf shelf_;
  double patience_;                          // s
  std::map<std::int64_t, Answers> answers_;  // by the view's stamp
  std::deque<Waiting> waiting_;
  graph::Publisher<msgs::ObjectModel> publisher_;
  graph::Subscription predicted_;
  graph::Subscription views_;
  graph::Node::Timer timer_;
};

void run(graph::Node& node) {
  const KnownObjects known_objects(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"known_objects",
     "Finds known objects in what the camera sees. Takes /objects and the models predicted of them "
     "(/predicted_models: remap the meshing's /models to it); publishes each on /models, as it is "
     "or, where it is one of the known objects, with that one's mesh at its pose and its name. A "
     "fit that the view speaks against is refused, with the reason in the log."},
    run);

}  // namespace
