#include "prehend/graph/link/delivery_side.h"

#include <utility>
#include <vector>

namespace prehend::graph {

using msgs::graph::PeerMessage;

std::uint64_t DeliverySide::ask(std::set<std::string> clients, Done done) {
  const std::uint64_t id = ++last_id_;
  PeerMessage message;
  message.mutable_delivery_question()->set_id(id);
  std::erase_if(clients, [&](const std::string& client) { return !send_(client, message); });
  questions_[id] = {std::move(clients), {}, std::move(done)};
  end_if_answered(id);
  return id;
}

void DeliverySide::take_answer(const std::string& client,
                               const PeerMessage::DeliveryAnswer& answer) {
  const auto found = questions_.find(answer.id());
  if (found == questions_.end() || found->second.awaited.erase(client) == 0) return;
  for (const auto& queue : answer.queues()) {
    found->second.queues.push_back({queue.topic(), queue.depth(), queue.max_bytes()});
  }
  end_if_answered(answer.id());
}

void DeliverySide::lose_client(const std::string& client) {
  std::vector<std::uint64_t> ids;
  for (auto& [id, question] : questions_) {
    if (question.awaited.erase(client) > 0) ids.push_back(id);
  }
  for (const std::uint64_t id : ids) end_if_answered(id);
}

void DeliverySide::end_if_answered(std::uint64_t id) {
  const auto found = questions_.find(id);
  if (!found->second.awaited.empty()) return;
  const Question question = std::move(found->second);
  questions_.erase(found);
  question.done(question.queues);
}

}  // namespace prehend::graph
