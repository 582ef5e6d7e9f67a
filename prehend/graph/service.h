#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "prehend/graph/outcome.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

class ServiceCore;
class ServiceClientCore;

/// Holds a service: destroying it withdraws the service; requests that wait get an error.
class Service {
 public:
  Service() = default;
  explicit Service(std::shared_ptr<ServiceCore> core);
  ~Service();
  Service(Service&&) noexcept;
  Service& operator=(Service&&) noexcept;

 private:
  std::shared_ptr<ServiceCore> core_;
};

/// What all service clients share. Cheap to copy. All functions may be called from any thread.
class ServiceClientBase {
 public:
  /// Waits until a server is there; `timeout` is wall time. False when it ran out or the node was
  /// shut down. Calling does not need this: a call waits for its server too. Throws
  /// std::logic_error inside one of the node's callbacks, unless the timeout is 0.
  bool wait_for_server(std::chrono::nanoseconds timeout) const;
  const std::string& service() const;

 protected:
  ServiceClientBase() = default;
  explicit ServiceClientBase(std::shared_ptr<ServiceClientCore> core) : core_(std::move(core)) {}
  /// Fills `response` when the status is kOk, else `error`.
  Status call_core(const google::protobuf::Message& request, google::protobuf::Message& response,
                   std::chrono::nanoseconds timeout, std::string& error) const;
  void call_async_core(
      const google::protobuf::Message& request, std::chrono::nanoseconds timeout,
      std::function<void(Status, std::string error, const std::string& answer)> on_end) const;

  std::shared_ptr<ServiceClientCore> core_;
};

template <class Request, class Response>
class ServiceClient : public ServiceClientBase {
 public:
  ServiceClient() = default;
  explicit ServiceClient(std::shared_ptr<ServiceClientCore> core)
      : ServiceClientBase(std::move(core)) {}

  /// Sends the request once, when a server is known, and waits for its answer; all within `timeout`
  /// (wall time). Ends at once with kServerGone when the server dies. Inside one of the node's own
  /// callbacks it is refused at once (kRefused), as no other callback could run meanwhile: use
  /// call_async there. The handlers of actions have threads of their own and may call.
  Outcome<Response> call(const Request& request, std::chrono::nanoseconds timeout) const {
    Response response;
    std::string error;
    const Status status = call_core(request, response, timeout, error);
    if (status == Status::kOk) return Outcome<Response>(std::move(response));
    return Outcome<Response>(status, std::move(error));
  }

  /// The same without waiting: returns at once, and `callback` is called once, among the node's
  /// callbacks, with the answer or the reason why there is none (kTimeout after `timeout`, exact to
  /// about 1 ms). It is not called when this node shuts down before.
  void call_async(const Request& request, std::chrono::nanoseconds timeout,
                  std::function<void(const Outcome<Response>&)> callback) const {
    if (!callback) throw std::invalid_argument("service " + service() + ": no callback given");
    call_async_core(request, timeout,
                    [name = service(), callback = std::move(callback)](
                        Status status, std::string error, const std::string& answer) {
                      if (status != Status::kOk) return callback({status, std::move(error)});
                      Response response;
                      if (response.ParseFromString(answer)) return callback(std::move(response));
                      callback({Status::kFailed, "service " + name + ": the answer is damaged"});
                    });
  }
};

}  // namespace prehend::graph
