#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "msgs/belief.pb.h"
#include "msgs/convert/belief.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/load.h"
#include "msgs/convert/objects.h"
#include "msgs/objects.pb.h"
#include "nodes/belief/act_forecasts.h"
#include "nodes/belief/lift_view_server.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/task_source/task_source.h"
#include "prehend/belief/attempt_memory.h"
#include "prehend/belief/probe.h"
#include "prehend/control/task.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;
using std::chrono::steady_clock;

constexpr std::size_t kMostObjects = 32;  // that wait for a late reader
constexpr std::size_t kMostViews = 4;     // that are kept

const std::map<std::string, belief::EvidenceUse> kUses{
    {"none", belief::EvidenceUse::kNone},
    {"contacts", belief::EvidenceUse::kContacts},
    {"empty_space", belief::EvidenceUse::kEmptySpace},
    {"looks", belief::EvidenceUse::kLooks}};

geometry::Plane support_of(const msgs::CompletedShape& shape) {
  return convert::from_message(shape.has_standing_on() ? shape.standing_on() : shape.table());
}

class BeliefNode {
 public:
  explicit BeliefNode(graph::Node& node)
      : node_(node),
        memory_(declare_memory()),
        patience_(node.declare_parameter<double>({.name = "patience",
                                                  .default_value = 5.0,
                                                  .unit = "s",
                                                  .minimum = 0.0,
                                                  .description = "wall time that a predicted model "
                                                                 "waits for its shape",
                                                  .read_only = true})),
        forecasts_(node, platform_),
        lift_views_(node, platform_, forecasts_),
        models_(node.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(kMostObjects))),
        beliefs_(node.advertise<msgs::Belief>("/belief", graph::QoS::latched(kMostObjects))),
        shapes_(node.subscribe<msgs::CompletedShape>(
            "/shapes", graph::QoS::latched(kMostObjects),
            [this](const graph::Received<msgs::CompletedShape>& shape) {
              view_of(shape->header().stamp()).shapes[shape->id()] = shape.shared();
              answer();
            })),
        predicted_(node.subscribe<msgs::ObjectModel>(
            "/predicted_models", graph::QoS::latched(kMostObjects),
            [this](const graph::Received<msgs::ObjectModel>& model) {
              waiting_.push_back({*model, steady_clock::now()});
              answer();
            })),
        evidence_(node.subscribe<msgs::AttemptEvidence>(
            "/cycle/evidence", graph::QoS::queue(kMostObjects),
            [this](const graph::Received<msgs::AttemptEvidence>& evidence) {
              const std::string problem = node_.shield("evidence", [&] { remember(*evidence); });
              if (!problem.empty()) {
                node_.report(graph::Health::kWarning, "an attempt is forgotten: " + problem);
              }
            })),
        timer_(node.create_timer(0.25, [this] { answer(); })) {}

 private:
  struct View {
    std::map<std::uint32_t, std::shared_ptr<const msgs::CompletedShape>> shapes;
    std::map<std::uint32_t, geometry::TriangleMesh> meshes_W;  // that were published
  };
  struct Waiting {
    msgs::ObjectModel model;
    steady_clock::time_point since;
  };

  belief::AttemptMemory declare_memory() {
    const auto platform = node_.declare_parameter<std::string>(
        {.name = "platform",
         .default_value = "stage_pg70",
         .description = "the robot whose hand touches (stage_pg70, kr5_sdh, ...)",
         .read_only = true});
    const std::string platforms = nodes::declare_platforms(node_);
    const auto use = node_.declare_parameter<std::string>(
        {.name = "evidence",
         .default_value = "looks",
         .choices = {"none", "contacts", "empty_space", "looks"},
         .description = "what of attempts is put to use when an object is seen again: where it was "
                        "touched, what the hand went through without a touch, what was seen of it "
                        "before; each with those before it",
         .read_only = true});
    belief::AttemptMemoryOptions options;
    options.use = kUses.at(use);
    const control::Task task = nodes::declare_task(node_);
    const bool probes =
        task.does(control::Primitive::kProbe) || task.does(control::Primitive::kDecide);
    const int most = node_.declare_parameter<int>(
        {.name = "probes",
         .default_value = 6,
         .minimum = 0,
         .description = "ways of a fingertip by which most would be learnt of an object, for "
                        "planning to choose from; of a task that probes or decides, 0: none",
         .read_only = true});
    options.probes = probes ? most : 0;
    probes_ = options.probes;
    probe_ = options.probe;
    platform_ = robot::read_platform(robot::platform_file(platforms, platform));
    return belief::AttemptMemory(platform_.hand, options);
  }

  View& view_of(std::int64_t stamp) {
    View& view = views_[stamp];
    while (views_.size() > kMostViews && views_.begin()->first != stamp) {
      views_.erase(views_.begin());
    }
    return view;
  }

  void remember(const msgs::AttemptEvidence& message) {
    if (message.hand() != platform_.hand.name) {
      throw geometry::InputError(
          "it was made with the hand " + message.hand() + ", not with " + platform_.hand.name,
          "Give this node the platform that the cycle has");
    }
    const auto view = views_.find(message.header().stamp());
    if (view == views_.end() || !view->second.shapes.contains(message.object_id()) ||
        !view->second.meshes_W.contains(message.object_id())) {
      throw geometry::InputError("the view of its object is not known any more",
                                 "Nothing: the next view is believed as it is predicted");
    }
    const msgs::CompletedShape& shape = *view->second.shapes.at(message.object_id());
    if (!shape.completed()) return;
    std::vector<geometry::TriangleMesh> neighbours_W;
    for (const auto& [id, mesh_W] : view->second.meshes_W) {
      if (id != message.object_id()) neighbours_W.push_back(mesh_W);
    }
    const geometry::TriangleMesh& believed_W = view->second.meshes_W.at(message.object_id());
    if (message.has_load()) {
      memory_.add_load(convert::from_message(message.load()), convert::from_message(shape),
                       support_of(shape), believed_W);
      node_.log_info("object {}: attempt {} told of its load", message.object_id(),
                     message.attempt());
      return;
    }
    if (message.looks()) {
      memory_.add_look(convert::from_message(shape), support_of(shape), believed_W);
      node_.log_info("object {}: it is looked at from elsewhere", message.object_id());
      return;
    }
    memory_.add(convert::from_message(message), convert::from_message(shape), support_of(shape),
                believed_W, neighbours_W);
    std::size_t contacts = 0;
    for (const auto& act : message.acts())
      contacts += static_cast<std::size_t>(act.contacts_size());
    node_.log_info("object {}: attempt {} touched it at {} places", message.object_id(),
                   message.attempt(), contacts);
  }

  // Publishes every model whose shape is there, or has not come in time.
  void answer() {
    std::deque<Waiting> still;
    for (Waiting& waiting : waiting_) {
      msgs::ObjectModel& model = waiting.model;
      View& view = view_of(model.header().stamp());
      const auto shape = view.shapes.find(model.id());
      const double waited =
          std::chrono::duration<double>(steady_clock::now() - waiting.since).count();
      // Of a known object all of the surface is known; what has no surface cannot be corrected.
      const bool may_change =
          model.valid() && !model.has_known() && (!memory_.empty() || probes_ > 0);
      if (may_change && shape == view.shapes.end() && waited < patience_) {
        still.push_back(std::move(waiting));
        continue;
      }
      if (may_change && shape == view.shapes.end()) {
        node_.report(
            graph::Health::kWarning,
            fmt::format("object {}: its shape has not come, it stays as predicted", model.id()));
      } else if (may_change && shape->second->completed()) {
        const std::string problem = node_.shield(fmt::format("object {}", model.id()),
                                                 [&] { correct(*shape->second, &model); });
        if (!problem.empty()) node_.report(graph::Health::kWarning, problem);
      }
      if (shape != view.shapes.end()) add_first_probes(*shape->second, &model);
      if (model.valid()) view.meshes_W[model.id()] = convert::from_message(model.mesh());
      forecasts_.seen(model);
      models_.publish(std::move(model));
    }
    waiting_ = std::move(still);
  }

  void correct(const msgs::CompletedShape& shape, msgs::ObjectModel* model) {
    const auto start = steady_clock::now();
    const std::optional<belief::Recollection> known =
        memory_.recall(convert::from_message(shape), support_of(shape));
    if (!known && memory_.problem().empty()) return;
    msgs::Belief belief;
    if (known) belief = convert::to_message(*known);
    *belief.mutable_header() = model->header();
    belief.set_id(model->id());
    belief.set_problem(memory_.problem());
    msgs::StageTime* time = belief.add_times();
    time->set_stage("belief");
    time->set_seconds(std::chrono::duration<double>(steady_clock::now() - start).count());
    if (known) {
      put(*known, model);
      put(known->probes, probe_.radius, model);
      *model->add_times() = *time;
      std::string text = fmt::format(
          "object {}: {} contacts and {} looks before make it {:.1f} mm other than predicted; {}",
          model->id(), known->contacts.size(), known->looks, 1e3 * known->change,
          known->after.front().name);
      if (known->load.is_known()) text += "; " + belief::in_words(known->load);
      if (!known->load_problem.empty()) text += "; " + known->load_problem;
      node_.log_info("{}", text);
      node_.report(graph::Health::kOk, text);
    } else {
      node_.log_info("object {}: {}", model->id(), memory_.problem());
    }
    beliefs_.publish(std::move(belief));
  }

  static void put(const std::vector<belief::Probe>& probes, double radius,
                  msgs::ObjectModel* model) {
    for (const belief::Probe& probe : probes) {
      msgs::ProbeMotion& message = *model->add_probes();
      *message.mutable_start() = convert::to_message(probe.start_W);
      *message.mutable_end() = convert::to_message(probe.end_W);
      *message.mutable_at() = convert::to_message(probe.at_W);
      message.set_radius(radius);
      message.set_gain(probe.gain);
    }
  }

  // Of an object of which nothing is known but this look.
  void add_first_probes(const msgs::CompletedShape& shape, msgs::ObjectModel* model) {
    const bool lacks = model->valid() && !model->has_known() && model->probes_size() == 0;
    if (probes_ == 0 || !lacks || !shape.completed()) return;
    const std::string problem = node_.shield(fmt::format("object {}", model->id()), [&] {
      const belief::ObjectBelief believed(convert::from_message(shape), support_of(shape));
      put(belief::best_probes(believed, probes_, probe_), probe_.radius, model);
    });
    if (!problem.empty()) node_.report(graph::Health::kWarning, problem);
  }

  // What the view says stays; the solid is what is believed.
  static void put(const belief::Recollection& known, msgs::ObjectModel* model) {
    msgs::ObjectModel solid = convert::to_message(known.model);
    solid.set_valid(true);
    *solid.mutable_header() = model->header();
    solid.set_id(model->id());
    solid.set_object_count(model->object_count());
    *solid.mutable_table() = model->table();
    *solid.mutable_times() = model->times();
    solid.set_touches_image_border(model->touches_image_border());
    solid.set_occluded_share(model->occluded_share());
    solid.set_vote(model->vote());
    solid.set_confidence(model->confidence());
    solid.set_method(model->method());
    convert::set_load(known.load, &solid);
    if (model->has_fidelity()) *solid.mutable_fidelity() = model->fidelity();
    *model = std::move(solid);
  }

  graph::Node& node_;
  robot::Platform platform_;
  int probes_ = 0;
  belief::ProbeOptions probe_;
  belief::AttemptMemory memory_;
  double patience_;  // s
  nodes::ActForecasts forecasts_;
  nodes::LiftViewServer lift_views_;
  std::map<std::int64_t, View> views_;  // by the stamp [ns]
  std::deque<Waiting> waiting_;
  graph::Publisher<msgs::ObjectModel> models_;
  graph::Publisher<msgs::Belief> beliefs_;
  graph::Subscription shapes_, predicted_, evidence_;
  graph::Node::Timer timer_;
};

void run(graph::Node& node) {
  const BeliefNode belief(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"belief",
     "Corrects what is predicted of an object by what attempts at it found out. Takes the models "
     "predicted of a view (/predicted_models: remap the meshing's /models to it) with their shapes "
     "(/shapes), and what attempts felt and went through (/cycle/evidence). Publishes each model "
     "on /models: as it is, or, of an object that was touched before, as it is believed now, and "
     "what was made of the evidence on /belief. Foretells what the act that begins is to perceive "
     "(/percepts/forecast), and says in bits how surprising is what it perceived "
     "(/percepts/surprise). Asked to (action /percepts/view, by the cycle that has lifted "
     "something), takes the next picture's depth (/camera/look) and says what it shows of that."},
    run);

}  // namespace
