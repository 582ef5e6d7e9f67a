#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "prehend/viewing/outbox.h"
#include "prehend/viewing/protocol.h"
#include "prehend/viewing/types.h"

namespace prehend::viewing {

using ViewerId = std::uint64_t;

struct ServiceAnswer {
  std::string error;  ///< not empty: the call failed, why
  std::string encoding;
  std::string payload;
};
struct AssetAnswer {
  std::string error;  ///< not empty: there is none, why
  std::string content;
};
struct ParameterAnswer {
  std::vector<Parameter> parameters;  ///< as they are now
  std::string error;                  ///< not empty: what was refused, why
};

/// What the server asks whoever has one. A capability whose functions are empty is not offered. All
/// are called in the server's thread and must not block; answers may be given from any thread,
/// once, later too. What they throw is told the viewer.
struct Handlers {
  /// The first viewer subscribed to a channel, or the last one left it.
  std::function<void(ChannelId, bool wanted)> on_channel_wanted;
  std::function<void(const std::vector<std::string>& names,
                     std::function<void(ParameterAnswer)> answer)>
      on_get_parameters;
  std::function<void(const std::vector<Parameter>& parameters,
                     std::function<void(ParameterAnswer)> answer)>
      on_set_parameters;
  std::function<void(ServiceId, const ServiceCall& call, std::function<void(ServiceAnswer)> answer)>
      on_service_call;
  /// A viewer wants to publish, or does no more. Throws std::runtime_error to refuse.
  std::function<void(ViewerId, const ClientChannel&)> on_client_advertise;
  std::function<void(ViewerId, std::uint32_t channel)> on_client_unadvertise;
  std::function<void(ViewerId, std::uint32_t channel, std::string_view payload)> on_client_message;
  std::function<void(const std::string& uri, std::function<void(AssetAnswer)> answer)>
      on_fetch_asset;
  /// What the operator is to read: viewers that come, go, are slow or refused.
  std::function<void(StatusLevel, const std::string& text)> on_news;
};

/// What one viewer may make the server keep.
struct ViewerLimits {
  std::size_t outbox_bytes = std::size_t{16} << 20;   ///< see Outbox
  std::size_t latched_bytes = std::size_t{64} << 20;  ///< of each channel, for all viewers together
  std::size_t client_channels = 256;
  std::size_t parameter_names = 10000;
};

/// The state of a server of the Foxglove WebSocket protocol: channels, services, viewers and what
/// each of them subscribed to, without any socket. Not thread-safe.
class Hub {
 public:
  /// How the hub reaches a viewer's connection.
  struct Wire {
    std::function<void()> wake;                            ///< something is in the outbox
    std::function<void(const std::string& reason)> close;  ///< it is to be given up
  };
  /// `post` runs a function in the thread of this object, later. It must outlive the answers that
  /// handlers give.
  using Post = std::function<void(std::function<void()>)>;

  Hub(std::string name, std::string session, Handlers handlers, ViewerLimits limits, Post post);
  ~Hub();

  /// `id` must be new.
  void add_channel(ChannelId id, Channel channel);
  void remove_channel(ChannelId id);
  void add_service(ServiceId id, ServiceType service);
  void remove_service(ServiceId id);
  /// Sends to whoever subscribed. `sender` tells apart whose last messages are kept of a latched
  /// channel. Does nothing for a channel that is unknown or nobody wants.
  void publish(ChannelId id, std::uint64_t time, const Payload& payload, const std::string& sender);
  void set_time(std::uint64_t time);
  void set_graph(ConnectionGraph graph);
  /// To viewers that asked for updates of these.
  void publish_parameters(const std::vector<Parameter>& parameters);
  /// To all viewers; `id`: replaces the one of that id.
  void tell(StatusLevel level, const std::string& message, const std::string& id);

  /// A viewer that called itself `peer` (an address) came.
  ViewerId connect(const std::string& peer, Wire wire);
  void disconnect(ViewerId id);
  void receive_text(ViewerId id, std::string_view text);
  void receive_binary(ViewerId id, std::string_view bytes);
  /// The frame to be sent next; none: nothing waits.
  std::optional<Outbox::Frame> next_frame(ViewerId id);
  /// Tells slow viewers what they lost; to be called about once a second.
  void tell_losses();

  std::size_t viewers() const { return viewers_.size(); }

 private:
  struct Kept {
    std::uint64_t time = 0;
    Payload payload;
    std::string sender;
  };
  struct Offered {
    Channel channel;
    std::set<ViewerId> viewers;
    std::deque<Kept> kept;
    std::size_t kept_bytes = 0;
  };
  struct Viewer;
  using Handled = std::function<void(Viewer&)>;

  bool is_offered(const Request& request) const;
  std::vector<std::string> capabilities() const;
  void send(Viewer& viewer, std::string text);
  void send_binary(Viewer& viewer, std::string bytes);
  void send_all(const std::string& text);
  void push(Viewer& viewer, Outbox::Frame frame);
  void refuse(Viewer& viewer, const std::string& why);
  void keep(Offered& offered, Kept message);
  void send_message(Viewer& viewer, const Offered& offered, std::uint32_t subscription,
                    const Kept& message);
  void leave_channel(Viewer& viewer, std::uint32_t subscription);
  void news(StatusLevel level, const std::string& text) const;
  /// Runs `handled` later in this object's thread, if the viewer is still there.
  void later(ViewerId id, Handled handled);
  std::function<void(ParameterAnswer)> parameter_answer(ViewerId id,
                                                        std::optional<std::string> word);

  void handle(Viewer& viewer, const Subscribe& request);
  void handle(Viewer& viewer, const Unsubscribe& request);
  void handle(Viewer& viewer, const AdvertiseClient& request);
  void handle(Viewer& viewer, const UnadvertiseClient& request);
  void handle(Viewer& viewer, const GetParameters& request);
  void handle(Viewer& viewer, const SetParameters& request);
  void handle(Viewer& viewer, const SubscribeParameters& request);
  void handle(Viewer& viewer, const UnsubscribeParameters& request);
  void handle(Viewer& viewer, const SubscribeGraph& request);
  void handle(Viewer& viewer, const UnsubscribeGraph& request);
  void handle(Viewer& viewer, const FetchAsset& request);
  void handle(Viewer& viewer, const ClientMessage& message);
  void handle(Viewer& viewer, const ServiceCall& call);

  const ServerInfo info_;
  const Handlers handlers_;
  const ViewerLimits limits_;
  const Post post_;
  std::map<ChannelId, Offered> channels_;
  std::map<ServiceId, ServiceType> services_;
  std::map<ViewerId, std::unique_ptr<Viewer>> viewers_;
  ConnectionGraph graph_;
  ViewerId last_viewer_ = 0;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

}  // namespace prehend::viewing
