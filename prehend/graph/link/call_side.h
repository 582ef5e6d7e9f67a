#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/executor.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/offers.h"
#include "prehend/graph/link/peer_channels.h"
#include "prehend/graph/link/registry_link.h"
#include "prehend/graph/service.h"

namespace prehend::graph {

/// A service at its server: requests wait for the node's callback thread.
class ServiceCore : public CallbackSource, public std::enable_shared_from_this<ServiceCore> {
 public:
  using Handler = std::function<std::string(const std::string& body)>;
  ServiceCore(std::shared_ptr<NodeLink> link, OfferType offer, Handler handler);

  const OfferType& offer() const { return offer_; }
  /// In the loop's thread.
  void push(const std::string& client, msgs::graph::PeerMessage::Call call);
  void set_withdraw(std::function<void()> withdraw) { withdraw_ = std::move(withdraw); }
  void withdraw();

 protected:
  bool run_one() override;

 private:
  struct Request {
    std::string client;
    std::uint64_t id = 0;
    std::string body;
  };
  void answer_error(const Request& request, const std::string& error);

  const std::shared_ptr<NodeLink> link_;
  const OfferType offer_;
  const Handler handler_;
  std::function<void()> withdraw_;
  std::mutex mutex_;
  std::deque<Request> queue_;
};

/// A call at its client, or a wait for the server only.
struct PendingCall {
  // Constant once started:
  std::uint64_t id = 0;
  OfferType offer;
  bool only_wait = false;
  std::string body;

  std::string server;  // instance; in the loop's thread only

  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  Status status = Status::kTimeout;
  std::string error;
  std::string answer;
  std::string server_name;  // node it was sent to

  void finish(Status end_status, std::string text, std::string content = "");
};

/// The node's calls of others' services. In the loop's thread only.
class CallSide {
 public:
  CallSide(PeerChannels& channels, const RegistryLink& registry)
      : channels_(channels), registry_(registry) {}

  void start(const std::shared_ptr<PendingCall>& call);
  void forget(std::uint64_t id) { calls_.erase(id); }
  /// Nodes have changed: servers may be there now.
  void look_again();
  void lose_server(const std::string& server);
  void take_answer(msgs::graph::PeerMessage::Answer& answer);
  void stop();

 private:
  bool advance(PendingCall& call);

  PeerChannels& channels_;
  const RegistryLink& registry_;
  std::map<std::uint64_t, std::shared_ptr<PendingCall>> calls_;
  bool stopped_ = false;
};

/// What a ServiceClient holds.
class ServiceClientCore {
 public:
  ServiceClientCore(std::shared_ptr<NodeLink> link, CallSide& side, OfferType offer)
      : link_(std::move(link)), side_(side), offer_(std::move(offer)) {}

  const OfferType& offer() const { return offer_; }
  /// Sends `body` and waits; see ServiceClient::call.
  Status call(std::string body, bool only_wait, std::chrono::nanoseconds timeout,
              std::string& answer, std::string& error);

 private:
  const std::shared_ptr<NodeLink> link_;
  CallSide& side_;  // used in the loop's thread only, which ends before it does
  const OfferType offer_;
};

}  // namespace prehend::graph
