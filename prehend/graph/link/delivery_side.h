#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "msgs/graph.pb.h"
#include "prehend/graph/delivery.h"

namespace prehend::graph {

/// Asks the nodes that read this one's topics to say when their callbacks have run for all that was
/// sent to them so far. Questions go the way of the messages and so come after them. In the loop's
/// thread only.
class DeliverySide {
 public:
  using Send = std::function<bool(const std::string& client, const msgs::graph::PeerMessage&)>;
  using Done = std::function<void(ReaderQueues)>;

  explicit DeliverySide(Send send) : send_(std::move(send)) {}

  /// Calls `done` once every client has answered or is gone. Returns the question's id.
  std::uint64_t ask(std::set<std::string> clients, Done done);
  /// `done` is not called any more.
  void forget(std::uint64_t id) { questions_.erase(id); }
  void take_answer(const std::string& client, const msgs::graph::PeerMessage::DeliveryAnswer&);
  void lose_client(const std::string& client);

 private:
  struct Question {
    std::set<std::string> awaited;
    ReaderQueues queues;
    Done done;
  };
  void end_if_answered(std::uint64_t id);

  Send send_;
  std::uint64_t last_id_ = 0;
  std::map<std::uint64_t, Question> questions_;
};

}  // namespace prehend::graph
