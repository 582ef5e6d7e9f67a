#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "prehend/viewing/types.h"

// The frames of the Foxglove WebSocket protocol, version 1 (github.com/foxglove/ws-protocol): text
// frames are JSON objects with an `op`, binary ones begin with an opcode; integers little endian.
namespace prehend::viewing {

/// By preference: what the SDK calls it now, what the npm client and older viewers call it.
inline constexpr std::array<const char*, 2> kSubprotocols{"foxglove.sdk.v1",
                                                          "foxglove.websocket.v1"};

/// The first of ours in the header Sec-WebSocket-Protocol, "a, b"; empty: none.
std::string chosen_subprotocol(std::string_view offered);

/// A viewer's frame that means nothing; what() says why, for the viewer to read.
class ProtocolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// --- from a viewer ------------------------------------------------------------------------------

struct Subscribe {
  struct One {
    std::uint32_t id = 0;  // the viewer's
    ChannelId channel = 0;
  };
  std::vector<One> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};
struct AdvertiseClient {
  std::vector<ClientChannel> channels;
};
struct UnadvertiseClient {
  std::vector<std::uint32_t> ids;
};
struct GetParameters {
  std::vector<std::string> names;  // empty: all
  std::optional<std::string> id;
};
struct SetParameters {
  std::vector<Parameter> parameters;
  std::optional<std::string> id;
};
struct SubscribeParameters {
  std::vector<std::string> names;  // empty: all
};
struct UnsubscribeParameters {
  std::vector<std::string> names;  // empty: all
};
struct SubscribeGraph {};
struct UnsubscribeGraph {};
struct FetchAsset {
  std::string uri;
  std::uint32_t request = 0;
};
using Request = std::variant<Subscribe, Unsubscribe, AdvertiseClient, UnadvertiseClient,
                             GetParameters, SetParameters, SubscribeParameters,
                             UnsubscribeParameters, SubscribeGraph, UnsubscribeGraph, FetchAsset>;

/// @throws ProtocolError for what is no JSON, has no known `op`, or lacks a member.
Request parse_request(std::string_view text);

struct ClientMessage {
  std::uint32_t channel = 0;  // of the viewer's own
  std::string_view payload;
};
struct ServiceCall {
  ServiceId service = 0;
  std::uint32_t call = 0;
  std::string encoding;
  std::string_view payload;
};
/// Views point into `bytes`. @throws ProtocolError for an unknown opcode or too few bytes.
std::variant<ClientMessage, ServiceCall> parse_binary(std::string_view bytes);

// --- to a viewer: JSON --------------------------------------------------------------------------

struct ServerInfo {
  std::string name;
  std::vector<std::string> capabilities;
  std::vector<std::string> encodings;  // of what viewers publish and call with
  std::string session;                 // another one tells viewers that the server is another
};
std::string server_info_text(const ServerInfo& info);
std::string status_text(StatusLevel level, const std::string& message, const std::string& id = "");
std::string advertise_text(const std::vector<std::pair<ChannelId, Channel>>& channels);
std::string unadvertise_text(const std::vector<ChannelId>& ids);
std::string advertise_services_text(const std::vector<std::pair<ServiceId, ServiceType>>& services);
std::string unadvertise_services_text(const std::vector<ServiceId>& ids);
std::string parameter_values_text(const std::vector<Parameter>& parameters,
                                  const std::optional<std::string>& id);
std::string service_failure_text(ServiceId service, std::uint32_t call, const std::string& message);
/// What changed from `before` to `now`.
std::string connection_graph_text(const ConnectionGraph& before, const ConnectionGraph& now);

/// Standard base64 with padding (RFC 4648).
std::string base64(std::string_view bytes);
/// @throws ProtocolError for what is none.
std::string from_base64(std::string_view text);

// --- to a viewer: binary ------------------------------------------------------------------------

/// Before a message's payload: the viewer's subscription and the time [ns].
std::array<std::uint8_t, 13> message_head(std::uint32_t subscription, std::uint64_t time);
std::string time_frame(std::uint64_t time);
std::string service_response(ServiceId service, std::uint32_t call, const std::string& encoding,
                             std::string_view payload);
/// `error` not empty: there is no such asset, why.
std::string asset_response(std::uint32_t request, const std::string& error,
                           std::string_view content);

}  // namespace prehend::viewing
