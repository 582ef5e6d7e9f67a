#include "nodes/viewer/bridge.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "msgs/views/views.h"
#include "nodes/viewer/message_types.h"
#include "prehend/text/tree_file.h"
#include "prehend/viewing/page_files.h"

namespace prehend::nodes {
namespace {

using viewing::StatusLevel;
using views::View;

constexpr std::size_t kMostWaiting = 64;  // questions of viewers
constexpr int kCalls = 4;                 // services that are called at once
const std::string kAssets = "package://prehend/config/";

std::uint64_t unsigned_time(std::int64_t stamp) {
  return stamp < 0 ? 0 : static_cast<std::uint64_t>(stamp);
}

views::ViewedMessage viewed(const graph::RawMessage& message) {
  const std::chrono::nanoseconds now = std::chrono::steady_clock::now().time_since_epoch();
  return {message.info.topic.str(),  message.info.sender.str(),
          message.schema->name,      message.bytes,
          message.info.publish_time, now.count()};
}

viewing::AssetAnswer asset(const std::string& uri) {
  if (uri.rfind(kAssets, 0) != 0) {
    return {fmt::format("'{}' is not served: only files of {}", uri, kAssets), ""};
  }
  auto file = viewing::page_file(text::tree_file("config"), "/" + uri.substr(kAssets.size()));
  if (file.status != 200) return {fmt::format("there is no file '{}'", uri), ""};
  return {"", std::move(file.content)};
}

}  // namespace

Tasks::Failed Bridge::failed(const char* what) {
  return [this, what](const std::string& why) { node_.log_warning("{}: {}", what, why); };
}

Bridge::Bridge(graph::Node& node, Options options)
    : node_(node),
      options_(std::move(options)),
      graph_(options_.registry, std::chrono::seconds(2), options_.keys_file),
      parameters_(options_.registry, options_.keys_file),
      topics_(node),
      client_topics_(node),
      looking_(1, failed("looking at the graph")),
      asking_(1, failed("parameters")),
      calling_(kCalls, failed("services")),
      calls_(node, calling_),
      own_services_(own_services(calls_, parameters_)) {
  server_ = std::make_unique<viewing::Server>(
      options_.server, options_.control ? control_handlers(handlers()) : handlers());
  looking_.post([this] {
    parameter_events_ = topics_.listen(
        "/parameter_events", 0, [this](const Message& message) { tell_parameters(message); });
    for (const View& view : options_.views) {
      if (view.topics.empty()) add_view(view);
    }
  });
  look();
}

Bridge::~Bridge() {
  looking_.stop();
  asking_.stop();
  calling_.stop();
  parameter_events_.end();
  channels_.clear();
  server_.reset();
}

viewing::Handlers Bridge::handlers() {
  viewing::Handlers handlers;
  handlers.on_news = [this](StatusLevel level, const std::string& text) {
    node_.log(level == StatusLevel::kInfo ? graph::LogLevel::kInfo : graph::LogLevel::kWarning,
              text);
  };
  handlers.on_channel_wanted = [this](viewing::ChannelId id, bool wanted) {
    looking_.post([this, id, wanted] { want(id, wanted); });
  };
  handlers.on_get_parameters = [this](const std::vector<std::string>& names, auto answer) {
    const bool taken = asking_.post_unless_full(
        [this, names, answer] { answer(parameters_.get(names)); }, kMostWaiting);
    if (!taken) answer({{}, "getParameters: too many questions wait for their answers"});
  };
  handlers.on_service_call = [this](viewing::ServiceId id, const viewing::ServiceCall& request,
                                    auto answer) { call(id, request, std::move(answer)); };
  handlers.on_fetch_asset = [this](const std::string& uri, auto answer) {
    const bool taken =
        calling_.post_unless_full([uri, answer] { answer(asset(uri)); }, kMostWaiting);
    if (!taken) answer({"too many questions wait for their answers", ""});
  };
  handlers.on_set_parameters = [](const auto&, auto answer) {
    answer({{}, "setParameters: viewers may only look here (control:=false)"});
  };
  return handlers;
}

viewing::Handlers Bridge::control_handlers(viewing::Handlers handlers) {
  handlers.on_set_parameters = [this](const std::vector<viewing::Parameter>& values, auto answer) {
    const bool taken = asking_.post_unless_full(
        [this, values, answer] { answer(parameters_.set(values)); }, kMostWaiting);
    if (!taken) answer({{}, "setParameters: too many questions wait for their answers"});
  };
  handlers.on_client_advertise = [this](viewing::ViewerId viewer,
                                        const viewing::ClientChannel& channel) {
    client_topics_.advertise(viewer, channel);
  };
  handlers.on_client_unadvertise = [this](viewing::ViewerId viewer, std::uint32_t channel) {
    client_topics_.unadvertise(viewer, channel);
  };
  handlers.on_client_message = [this](viewing::ViewerId viewer, std::uint32_t channel,
                                      std::string_view payload) {
    client_topics_.publish(viewer, channel, payload);
  };
  return handlers;
}

void Bridge::tell_time() {
  constexpr int kPaused = 30;  // a time that stands is told that seldom, to who has just come
  const std::uint64_t now = unsigned_time(node_.clock().now());
  const bool is_news = now != last_time_ || ++silent_turns_ >= kPaused;
  if (!is_news || server_->viewers() == 0) return;
  last_time_ = now;
  silent_turns_ = 0;
  server_->set_time(now);
}

void Bridge::look() {
  const auto look_at_graph = [this] {
    try {
      see(offers_of(graph_.nodes()));
      is_blind_ = false;
    } catch (const std::runtime_error& error) {
      if (std::exchange(is_blind_, true)) return;
      node_.log_warning("what is new in the graph is not seen: {}", error.what());
    }
  };
  looking_.post_unless_full(look_at_graph, 1);  // else the last look still waits
}

void Bridge::see(const Offers& offers) {
  const auto& nodes = offers.nodes;
  if (std::find(nodes.begin(), nodes.end(), node_.name()) == nodes.end()) {
    throw std::runtime_error(fmt::format(
        "the registry {} does not know this node; start it with that of the graph in the "
        "environment variable PREHEND_REGISTRY, not by --registry",
        graph_.registry()));
  }
  offers_ = offers;
  see_topics(offers);
  see_views(offers);
  see_services(offers);
  server_->set_graph(offers.graph);
}

// --- topics -------------------------------------------------------------------------------------

void Bridge::see_topics(const Offers& offers) {
  const auto remove = [this](const std::string& topic) {
    const viewing::ChannelId id = by_topic_.at(topic);
    server_->remove_channel(id);
    channels_.erase(id);
    by_topic_.erase(topic);
  };
  std::vector<std::string> gone;
  for (const auto& [topic, id] : by_topic_) {
    const Offered& offered = channels_.at(id);
    const auto now = offers.topics.find(topic);
    // Who looks at a topic whose node is started again keeps it.
    const bool is_gone = now == offers.topics.end() && !offered.wanted;
    const bool is_another =
        now != offers.topics.end() && now->second.schema_hash != offered.type.schema_hash;
    if (is_gone || is_another) gone.push_back(topic);
  }
  for (const std::string& topic : gone) remove(topic);
  for (const auto& [topic, type] : offers.topics) {
    if (by_topic_.count(topic) > 0 || type.schema_name.empty()) continue;
    const auto viewed = viewed_type(graph_, type.schema_name, type.schema_hash);
    client_topics_.know(topic, viewed);
    const viewing::ChannelId id = server_->add_channel({topic, viewed, type.latched, false});
    by_topic_[topic] = id;
    channels_[id] = {topic, type, nullptr, false, {}};
  }
}

void Bridge::want(viewing::ChannelId id, bool wanted) {
  const auto found = channels_.find(id);
  if (found == channels_.end()) return;  // it has gone meanwhile
  Offered& offered = found->second;
  offered.wanted = wanted;
  if (!wanted) {
    offered.listening.clear();
  } else if (offered.view != nullptr) {
    begin_view(id, offered);
  } else {
    begin_topic(id, offered);
  }
}

void Bridge::begin_topic(viewing::ChannelId id, Offered& offered) {
  const auto publish = [this, id, hash = offered.type.schema_hash](const Message& message) {
    if (message->info.schema_hash != hash) return;  // advertised anew at the next look
    server_->publish(id, unsigned_time(message->info.publish_time),
                     viewing::Payload(message, &message->bytes), message->info.sender.str());
  };
  offered.listening.push_back(topics_.listen(offered.topic, offered.type.latched, publish));
}

// --- views --------------------------------------------------------------------------------------

void Bridge::add_view(const View& view) {
  const views::ViewChannel& channel = view.channel;
  const viewing::ChannelId id = server_->add_channel(
      {channel.topic, viewed_type(*channel.type), channel.latched, channel.may_drop});
  channels_[id] = {"", {}, &view, false, {}};
}

void Bridge::see_views(const Offers& offers) {
  std::set<std::string> shown;
  for (const auto& [id, offered] : channels_) {
    if (offered.view != nullptr) shown.insert(offered.view->channel.topic);
  }
  const auto is_offered = [&](const View& view) {
    return std::any_of(view.topics.begin(), view.topics.end(),
                       [&](const auto& topic) { return offers.topics.count(topic) > 0; });
  };
  for (const View& view : options_.views) {
    if (shown.count(view.channel.topic) == 0 && is_offered(view)) add_view(view);
  }
  for (const auto& [topic, type] : offers.topics) {
    if (pad_views_.count(topic) > 0) continue;
    auto view = views::pad_view(topic, type.schema_name);
    if (!view) continue;
    add_view(*pad_views_.emplace(topic, std::move(view)).first->second);
  }
}

void Bridge::begin_view(viewing::ChannelId id, Offered& offered) {
  const std::string name = offered.view->channel.topic;
  const auto publish = [this, id](std::int64_t stamp, std::string bytes, const std::string& key) {
    server_->publish(id, unsigned_time(stamp),
                     std::make_shared<const std::string>(std::move(bytes)), key);
  };
  for (View::Source& source : offered.view->begin(publish)) {
    const auto known = offers_.topics.find(source.topic);
    const std::size_t latched =
        known == offers_.topics.end() ? 1 : std::max<std::size_t>(known->second.latched, 1);
    offered.listening.push_back(topics_.listen(
        source.topic, latched, [this, name, take = std::move(source.take)](const Message& message) {
          (void)node_.shield(name, [&] { take(viewed(*message)); });
        }));
  }
}

// --- services and parameters --------------------------------------------------------------------

void Bridge::see_services(const Offers& offers) {
  std::map<std::string, CallableService> now;
  for (const auto& [name, types] : offers.services) {
    if (!options_.control) break;
    now[name] = {{name, types.request, {}, {}}, nullptr, types.request_hash ^ types.response_hash};
  }
  for (const OwnService& own : own_services_) {
    const bool is_there = std::all_of(own.needs.begin(), own.needs.end(), [&](const auto& need) {
      return offers.services.count(need) > 0;
    });
    const bool only_tells = own.needs.empty();
    if (is_there && (options_.control || only_tells)) now[own.type.name] = {own.type, &own, 0};
  }
  const std::lock_guard lock(services_mutex_);
  for (auto known = service_ids_.begin(); known != service_ids_.end();) {
    const auto there = now.find(known->first);
    if (there != now.end() && there->second.hashes == services_[known->second].hashes) {
      now.erase(there);
      ++known;
      continue;
    }
    server_->remove_service(known->second);
    services_.erase(known->second);
    known = service_ids_.erase(known);
  }
  for (auto& [name, service] : now) {
    if (service.own == nullptr) {
      const OfferedService& types = offers.services.at(name);
      service.type.request = viewed_type(graph_, types.request, types.request_hash);
      service.type.response = viewed_type(graph_, types.response, types.response_hash);
    }
    const viewing::ServiceId id = server_->add_service(service.type);
    service_ids_[name] = id;
    services_[id] = service;
  }
}

void Bridge::call(viewing::ServiceId id, const viewing::ServiceCall& request,
                  ServiceCalls::Answer answer) {
  CallableService service;
  {
    const std::lock_guard lock(services_mutex_);
    const auto found = services_.find(id);
    if (found == services_.end()) {
      throw std::runtime_error(fmt::format("service {} has gone", id));
    }
    service = found->second;
  }
  const std::string payload(request.payload);
  if (service.own == nullptr) {
    return calls_.call(service.type, request.encoding, payload, std::move(answer));
  }
  if (request.encoding != "json") {
    throw std::runtime_error(fmt::format("service {} takes json", service.type.name));
  }
  call_own(*service.own, payload, std::move(answer));
}

void Bridge::call_own(const OwnService& service, const std::string& request,
                      ServiceCalls::Answer answer) {
  Tasks& tasks = service.uses_parameters ? asking_ : calling_;
  const bool taken = tasks.post_unless_full(
      [&service, request, answer] {
        try {
          answer({"", "json", service.call(request)});
        } catch (const std::exception& error) {
          answer({fmt::format("service {}: {}", service.type.name, error.what()), "", ""});
        }
      },
      kMostWaiting);
  if (!taken) answer({"too many calls wait for their answers", "", ""});
}

void Bridge::tell_parameters(const Message& message) {
  msgs::graph::ParameterEvent event;
  if (!event.ParseFromString(message->bytes)) return;
  std::vector<viewing::Parameter> parameters;
  for (const auto& record : event.changed()) {
    parameters.push_back(viewed_parameter(event.node(), record));
  }
  server_->publish_parameters(std::move(parameters));
}

}  // namespace prehend::nodes
