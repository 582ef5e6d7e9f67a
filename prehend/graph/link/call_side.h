#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
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

/// How a call ended.
struct CallEnd {
  Status status = Status::kTimeout;
  std::string error;
  std::string answer;
};

/// A call at its client, or a wait for the server only.
struct PendingCall {
  // Constant once started:
  std::uint64_t id = 0;
  OfferType offer;
  bool only_wait = false;
  std::string body;
  std::chrono::nanoseconds timeout{0};
  std::chrono::steady_clock::time_point deadline;
  std::function<void(CallEnd)> on_end;  ///< empty: somebody waits for `changed`

  // In the loop's thread only:
  std::string server;                           ///< instance it was sent to
  std::chrono::steady_clock::time_point since;  ///< waits for that server, or for any
  std::optional<IoLoop::Alarm> alarm;

  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  CallEnd end;
  std::string server_name;  // node it was sent to

  void finish(Status status, std::string error, std::string answer = "");
  /// That nothing came in time, and whose fault it is. With the mutex held.
  std::string timeout_error() const;
};

/// The node's calls of others' services. In the loop's thread only.
class CallSide {
 public:
  CallSide(IoLoop& loop, PeerChannels& channels, const RegistryLink& registry)
      : loop_(loop), channels_(channels), registry_(registry) {}

  void start(const std::shared_ptr<PendingCall>& call);
  void forget(std::uint64_t id);
  /// Nodes have changed: servers may be there now.
  void look_again();
  void lose_server(const std::string& server);
  /// Ends calls of servers that died before a connection to them stood.
  void check_connections();
  void take_answer(const std::string& server, msgs::graph::PeerMessage::Answer& answer);
  void stop();

 private:
  using Calls = std::map<std::uint64_t, std::shared_ptr<PendingCall>>;
  bool advance(PendingCall& call);
  void expire(std::uint64_t id);
  Calls::iterator erase(Calls::iterator call);

  IoLoop& loop_;
  PeerChannels& channels_;
  const RegistryLink& registry_;
  Calls calls_;
  bool stopped_ = false;
};

/// What a ServiceClient holds.
class ServiceClientCore {
 public:
  ServiceClientCore(std::shared_ptr<NodeLink> link, CallSide& side, OfferType offer)
      : link_(std::move(link)), side_(side), offer_(std::move(offer)) {}

  const OfferType& offer() const { return offer_; }
  /// Sends `body` and waits; see ServiceClient::call.
  CallEnd call(std::string body, std::chrono::nanoseconds timeout);
  /// The same without waiting; `on_end` is called among the node's callbacks.
  void call_async(std::string body, std::chrono::nanoseconds timeout,
                  std::function<void(CallEnd)> on_end);
  /// See ServiceClientBase::wait_for_server. Throws std::logic_error inside a callback.
  bool wait_for_server(std::chrono::nanoseconds timeout);

 private:
  std::shared_ptr<PendingCall> make_call(std::string body, std::chrono::nanoseconds timeout) const;
  CallEnd run(const std::shared_ptr<PendingCall>& call);
  bool post(const std::shared_ptr<PendingCall>& call);

  const std::shared_ptr<NodeLink> link_;
  CallSide& side_;  // used in the loop's thread only, which ends before it does
  const OfferType offer_;
};

}  // namespace prehend::graph
