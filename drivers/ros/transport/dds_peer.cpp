#include "drivers/ros/transport/dds_peer.h"

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <fmt/format.h>

#include "drivers/ros/transport/dds_types.h"

namespace prehend::drivers::ros_link {
namespace {

/// An entity of DDS with what is in it.
class Entity {
 public:
  Entity() = default;
  Entity(dds_entity_t handle, const std::string& what) : handle_(handle) {
    if (handle < 0) throw std::runtime_error(what + ": " + dds_strretcode(-handle));
  }
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  dds_entity_t get() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

template <class Type, void (*Delete)(Type*)>
struct Deleter {
  void operator()(Type* object) const { Delete(object); }
};
using Qos = std::unique_ptr<dds_qos_t, Deleter<dds_qos_t, dds_delete_qos>>;
using Listener = std::unique_ptr<dds_listener_t, Deleter<dds_listener_t, dds_delete_listener>>;

Qos qos_of(const RosQos& qos) {
  Qos made(dds_create_qos());
  dds_qset_reliability(made.get(),
                       qos.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_durability(made.get(),
                      qos.is_latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(made.get(), DDS_HISTORY_KEEP_LAST, static_cast<std::int32_t>(qos.depth));
  return made;
}

const char* policy_name(std::uint32_t id) {
  switch (id) {
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    case DDS_DATA_REPRESENTATION_QOS_POLICY_ID:
      return "data representation";
    default:
      return "quality of service";
  }
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&' || c == '"') {
      result += fmt::format("&#{};", static_cast<int>(c));
    } else {
      result += c;
    }
  }
  return result;
}

/// CycloneDDS's own configuration (its manual, "Configuration"); empty: as the environment says.
std::string configuration(const DdsOptions& options) {
  if (options.network == "environment") return {};
  const bool is_loopback = options.network == "loopback";
  const bool is_address = options.network.find_first_not_of("0123456789.") == std::string::npos;
  const std::string interface = is_loopback  ? "address=\"127.0.0.1\""
                                : is_address ? "address=\"" + options.network + "\""
                                             : "name=\"" + escaped(options.network) + "\"";
  // Loopback has no multicast: participants there ask one another by their ports.
  return fmt::format(
      "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface {}/></Interfaces>"
      "{}</General>{}</Domain></CycloneDDS>",
      interface, is_loopback ? "<AllowMulticast>false</AllowMulticast>" : "",
      is_loopback ? "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
                    "<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>"
                    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>"
                  : "");
}

/// Says each thing once.
class Words {
 public:
  explicit Words(RosProblem tell) : tell_(std::move(tell)) {}
  void say(const std::string& problem) {
    {
      const std::lock_guard lock(mutex_);
      if (!said_.insert(problem).second) return;
    }
    tell_(problem);
  }

 private:
  const RosProblem tell_;
  std::mutex mutex_;
  std::set<std::string> said_;
};

/// What a listener of an entity tells with.
struct Told {
  std::shared_ptr<Words> words;
  std::string name, type;
};

void offered_in_vain(dds_entity_t, const dds_offered_incompatible_qos_status_t status,
                     void* context) {
  const auto& told = *static_cast<const Told*>(context);
  told.words->say(fmt::format(
      "{}: a reader of ROS asks for another {} than is offered, and gets nothing; set it in the "
      "mapping (reliability, latched)",
      told.name, policy_name(status.last_policy_id)));
}

void requested_in_vain(dds_entity_t, const dds_requested_incompatible_qos_status_t status,
                       void* context) {
  const auto& told = *static_cast<const Told*>(context);
  told.words->say(fmt::format(
      "{}: a writer of ROS offers another {} than is asked for, and nothing comes; set it in the "
      "mapping (reliability: best_effort, latched: false)",
      told.name, policy_name(status.last_policy_id)));
}

struct Topic {
  Entity entity;
  ddsi_sertype* type = nullptr;  // the topic's
};

Topic make_topic(dds_entity_t participant, const std::string& name, const std::string& type,
                 RosChannel channel) {
  Topic topic;
  topic.type = new_bytes_type(ros::dds_type_name(type));
  topic.entity = Entity(dds_create_topic_sertype(participant, dds_topic_name(name, channel).c_str(),
                                                 &topic.type, nullptr, nullptr, nullptr),
                        "DDS takes no topic '" + name + "' of type " + type);
  return topic;
}

class DdsPublisher : public RosPublisher {
 public:
  DdsPublisher(dds_entity_t participant, Told told, const RosQos& qos, RosChannel channel)
      : told_(std::make_unique<Told>(std::move(told))),
        listener_(dds_create_listener(told_.get())),
        topic_(make_topic(participant, told_->name, told_->type, channel)) {
    dds_lset_offered_incompatible_qos(listener_.get(), offered_in_vain);
    writer_ = Entity(
        dds_create_writer(participant, topic_.entity.get(), qos_of(qos).get(), listener_.get()),
        "DDS takes no writer of '" + told_->name + "'");
  }

  void publish(std::string bytes) override {
    ddsi_serdata* sample = new_sample(*topic_.type, std::move(bytes));
    sample->timestamp.v = dds_time();
    const dds_return_t status = dds_writecdr(writer_.get(), sample);
    // A reliable reader that does not keep up; the next message is tried again.
    if (status != DDS_RETCODE_OK) {
      told_->words->say(told_->name + ": a message was not taken: " + dds_strretcode(-status));
    }
  }
  std::size_t readers() const override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_.get(), &status);
    return status.current_count;
  }

 private:
  std::unique_ptr<Told> told_;
  Listener listener_;
  Topic topic_;
  Entity writer_;
};

/// Takes its messages in a thread of its own, so that a slow one does not hold up others.
class DdsSubscription : public RosSubscription {
 public:
  DdsSubscription(dds_entity_t participant, Told told, const RosQos& qos, RosChannel channel,
                  std::function<void(std::string_view)> take)
      : told_(std::make_unique<Told>(std::move(told))),
        listener_(dds_create_listener(told_.get())),
        take_(std::move(take)),
        topic_(make_topic(participant, told_->name, told_->type, channel)) {
    dds_lset_requested_incompatible_qos(listener_.get(), requested_in_vain);
    reader_ = Entity(
        dds_create_reader(participant, topic_.entity.get(), qos_of(qos).get(), listener_.get()),
        "DDS takes no reader of '" + told_->name + "'");
    set_ = Entity(dds_create_waitset(participant), "DDS makes no waitset");
    stop_ = Entity(dds_create_guardcondition(participant), "DDS makes no condition");
    // Deleted with its reader.
    dds_waitset_attach(set_.get(), dds_create_readcondition(reader_.get(), DDS_ANY_STATE), 0);
    dds_waitset_attach(set_.get(), stop_.get(), 0);
    thread_ = std::thread([this] { run(); });
  }
  ~DdsSubscription() override {
    stops_ = true;
    dds_set_guardcondition(stop_.get(), true);
    thread_.join();
  }
  std::size_t writers() const override {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader_.get(), &status);
    return status.current_count;
  }

 private:
  void run() {
    while (!stops_) {
      dds_attach_t which = 0;
      dds_waitset_wait(set_.get(), &which, 1, DDS_MSECS(500));
      take_all();
    }
  }
  void take_all() {
    constexpr std::uint32_t kMost = 16;
    std::array<ddsi_serdata*, kMost> samples{};
    std::array<dds_sample_info_t, kMost> infos{};
    dds_return_t count = 0;
    do {
      count = dds_takecdr(reader_.get(), samples.data(), kMost, infos.data(), DDS_ANY_STATE);
      for (dds_return_t i = 0; i < count; ++i) {
        const auto index = static_cast<std::size_t>(i);
        if (infos[index].valid_data && !stops_) take_(bytes_of(*samples[index]));
        ddsi_serdata_unref(samples[index]);
        samples[index] = nullptr;
      }
    } while (count == static_cast<dds_return_t>(kMost) && !stops_);
  }

  std::unique_ptr<Told> told_;
  Listener listener_;
  std::function<void(std::string_view)> take_;
  Topic topic_;
  Entity reader_, set_, stop_;
  std::atomic<bool> stops_ = false;
  std::thread thread_;
};

class DdsPeer : public RosPeer {
 public:
  DdsPeer(const DdsOptions& options, RosProblem tell)
      : words_(std::make_shared<Words>(std::move(tell))) {
    const auto domain = static_cast<dds_domainid_t>(options.domain);
    const std::string config = configuration(options);
    const std::string what = fmt::format("DDS does not begin on domain {}, network '{}'",
                                         options.domain, options.network);
    if (!config.empty()) domain_ = Entity(dds_create_domain(domain, config.c_str()), what);
    participant_ = Entity(dds_create_participant(domain, nullptr, nullptr), what);
    writers_ = Entity(
        dds_create_reader(participant_.get(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
        what);
    readers_ = Entity(
        dds_create_reader(participant_.get(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr),
        what);
    watcher_ = std::thread([this] { watch(); });
  }
  ~DdsPeer() override {
    stops_ = true;
    watcher_.join();
  }
  ros::Version version() const override { return ros::Version::kRos2; }

  std::unique_ptr<RosPublisher> advertise(const std::string& name, const std::string& type,
                                          const RosQos& qos, RosChannel channel) override {
    know(name, type, channel);
    return std::make_unique<DdsPublisher>(participant_.get(), Told{words_, name, type}, qos,
                                          channel);
  }
  std::unique_ptr<RosSubscription> subscribe(const std::string& name, const std::string& type,
                                             const RosQos& qos,
                                             std::function<void(std::string_view)> take,
                                             RosChannel channel) override {
    know(name, type, channel);
    return std::make_unique<DdsSubscription>(participant_.get(), Told{words_, name, type}, qos,
                                             channel, std::move(take));
  }

 private:
  void know(const std::string& name, const std::string& type, RosChannel channel) {
    const std::lock_guard lock(mutex_);
    types_[dds_topic_name(name, channel)] = ros::dds_type_name(type);
  }
  // DDS never matches a topic of another type, and says nothing of it.
  void watch() {
    constexpr int kTicks = 10;  // a second
    for (int tick = 0; !stops_; ++tick) {
      if (tick % kTicks == 0) {
        look_at(writers_.get());
        look_at(readers_.get());
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  void look_at(dds_entity_t endpoints) {
    constexpr std::size_t kMost = 64;
    std::array<void*, kMost> samples{};
    std::array<dds_sample_info_t, kMost> infos{};
    dds_return_t count = 0;
    do {
      samples.fill(nullptr);
      count = dds_take(endpoints, samples.data(), infos.data(), kMost, kMost);
      for (dds_return_t i = 0; i < count; ++i) {
        const auto index = static_cast<std::size_t>(i);
        if (!infos[index].valid_data) continue;
        const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[index]);
        compare(endpoint.topic_name, endpoint.type_name);
      }
      if (count > 0) dds_return_loan(endpoints, samples.data(), count);
    } while (count == static_cast<dds_return_t>(kMost));
  }
  void compare(const std::string& topic, const std::string& type) {
    std::string ours;
    {
      const std::lock_guard lock(mutex_);
      const auto found = types_.find(topic);
      if (found == types_.end() || found->second == type) return;
      ours = found->second;
    }
    words_->say(fmt::format("{}: a peer has it as {}, the mapping as {}: nothing is exchanged",
                            topic, type, ours));
  }

  std::shared_ptr<Words> words_;
  Entity domain_, participant_, writers_, readers_;
  std::mutex mutex_;
  std::map<std::string, std::string> types_;  // by DDS's names
  std::atomic<bool> stops_ = false;
  std::thread watcher_;
};

}  // namespace

std::string dds_topic_name(const std::string& name, RosChannel channel) {
  switch (channel) {
    case RosChannel::kRequest:
      return "rq" + name + "Request";
    case RosChannel::kReply:
      return "rr" + name + "Reply";
    default:
      return "rt" + name;
  }
}

std::unique_ptr<RosPeer> connect_dds(const DdsOptions& options, RosProblem tell) {
  return std::make_unique<DdsPeer>(options, std::move(tell));
}

}  // namespace prehend::drivers::ros_link
