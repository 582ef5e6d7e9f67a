#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "msgs/views/view.h"
#include "nodes/viewer/client_topics.h"
#include "nodes/viewer/offers.h"
#include "nodes/viewer/own_services.h"
#include "nodes/viewer/parameters.h"
#include "nodes/viewer/service_calls.h"
#include "nodes/viewer/tasks.h"
#include "nodes/viewer/topics.h"
#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"
#include "prehend/viewing/server.h"

namespace prehend::nodes {

/// A graph, for viewers: every topic under its own name, the views, services, parameters, the
/// connection graph, the time, files of config/ as assets.
class Bridge {
 public:
  struct Options {
    viewing::ServerOptions server;
    std::vector<views::View> views;
    bool control = true;    ///< viewers may set parameters, call services and publish
    std::string registry;   ///< as Introspection
    std::string keys_file;  ///< as Introspection
  };

  /// Listens at once. @throws as viewing::Server.
  Bridge(graph::Node& node, Options options);
  ~Bridge();

  const viewing::Server& server() const { return *server_; }
  /// Tells viewers the time; to be called about 30 times a second.
  void tell_time();
  /// Sees what has changed in the graph, soon, in a thread of its own; to be called about twice a
  /// second.
  void look();

 private:
  struct Offered {
    std::string topic;  // of the graph; empty: a view's
    OfferedTopic type;
    const views::View* view = nullptr;
    bool wanted = false;
    std::vector<Topics::Listening> listening;
  };
  struct CallableService {
    viewing::ServiceType type;
    const OwnService* own = nullptr;  // null: of the graph
    std::uint64_t hashes = 0;         // of both types
  };
  using Message = Topics::Message;

  viewing::Handlers handlers();
  viewing::Handlers control_handlers(viewing::Handlers handlers);
  void see(const Offers& offers);
  void see_topics(const Offers& offers);
  void see_views(const Offers& offers);
  void see_services(const Offers& offers);
  void add_view(const views::View& view);
  void want(viewing::ChannelId id, bool wanted);
  void begin_topic(viewing::ChannelId id, Offered& offered);
  void begin_view(viewing::ChannelId id, Offered& offered);
  void call(viewing::ServiceId id, const viewing::ServiceCall& call, ServiceCalls::Answer answer);
  void call_own(const OwnService& service, const std::string& request, ServiceCalls::Answer answer);
  void tell_parameters(const Message& message);
  Tasks::Failed failed(const char* what);

  graph::Node& node_;
  const Options options_;
  graph::Introspection graph_;  // of looking_'s thread
  Parameters parameters_;       // of asking_'s thread
  Topics topics_;               // of looking_'s thread
  ClientTopics client_topics_;
  std::map<viewing::ChannelId, Offered> channels_;      // as all that follow, of looking_'s thread
  std::map<std::string, viewing::ChannelId> by_topic_;  // those of the graph
  std::map<std::string, std::optional<views::View>> pad_views_;  // by the topic of a pad
  std::map<std::string, viewing::ServiceId> service_ids_;
  Offers offers_;
  bool is_blind_ = false;  // the graph does not answer
  std::mutex services_mutex_;
  std::map<viewing::ServiceId, CallableService> services_;
  Topics::Listening parameter_events_;
  std::uint64_t last_time_ = 0;  // with silent_turns_, of tell_time()'s thread
  int silent_turns_ = 0;
  // These run what may wait, and end before all that is above.
  Tasks looking_, asking_, calling_;
  ServiceCalls calls_;
  std::vector<OwnService> own_services_;
  std::unique_ptr<viewing::Server> server_;
};

}  // namespace prehend::nodes
