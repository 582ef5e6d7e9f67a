#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Shares the node's one subscription to each topic among all who want its messages, and ends it
/// with the last of them: what nobody looks at costs nothing. Who comes later gets the last
/// messages of latched topics, as the first one did.
class Topics {
 public:
  using Message = std::shared_ptr<const graph::RawMessage>;
  using Callback = std::function<void(const Message&)>;

  /// Holds what listen() began; ends it when destroyed. No callback runs afterwards.
  class Listening {
   public:
    Listening() = default;
    Listening(Topics* topics, std::string topic, std::uint64_t id)
        : topics_(topics), topic_(std::move(topic)), id_(id) {}
    ~Listening() { end(); }
    Listening(Listening&& other) noexcept { *this = std::move(other); }
    Listening& operator=(Listening&& other) noexcept;
    void end();

   private:
    Topics* topics_ = nullptr;
    std::string topic_;
    std::uint64_t id_ = 0;
  };

  explicit Topics(graph::Node& node) : node_(node) {}

  /// `topic`: its name in the whole graph. `latched`: how many messages of each sender those who
  /// come later get. `callback` runs among the node's callbacks, or, for those, in the calling
  /// thread; never twice at once. One thread at a time may call this and end what it began.
  [[nodiscard]] Listening listen(const std::string& topic, std::size_t latched, Callback callback);

 private:
  struct Listener {
    std::mutex mutex;
    Callback callback;  // empty: ended
  };
  struct Source {
    std::mutex mutex;  // of what follows
    std::map<std::uint64_t, std::shared_ptr<Listener>> listeners;
    std::deque<Message> kept;
    std::size_t kept_bytes = 0;
    std::size_t latched = 0;
    graph::Subscription subscription;
  };
  static void keep(Source& source, const Message& message);
  static void deliver(Source& source, const Message& message);
  void end(const std::string& topic, std::uint64_t id);

  graph::Node& node_;
  std::map<std::string, std::shared_ptr<Source>> sources_;
  std::uint64_t last_id_ = 0;
};

}  // namespace prehend::nodes
