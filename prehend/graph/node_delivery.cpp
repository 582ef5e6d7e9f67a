// How a node learns that its messages have been worked on, and tells others so.

#include <future>

#include "prehend/graph/link/local_nodes.h"
#include "prehend/graph/node_impl.h"

namespace prehend::graph {

using namespace std::chrono_literals;
using msgs::graph::PeerMessage;

std::optional<ReaderQueues> Node::Impl::wait_until_delivered(std::chrono::nanoseconds timeout) {
  check_not_describing();
  auto answered = std::make_shared<std::promise<ReaderQueues>>();
  auto future = answered->get_future();
  auto id = std::make_shared<std::uint64_t>(0);  // of the loop's thread
  link->loop->post([this, answered, id] {
    const auto clients = publishers->drain_all();
    *id = deliveries->ask(
        clients, [answered](ReaderQueues queues) { answered->set_value(std::move(queues)); });
  });
  answered.reset();
  const auto deadline = deadline_after(timeout);
  constexpr auto kLook = 20ms;  // whether the node was shut down
  while (future.wait_until(std::min(deadline, std::chrono::steady_clock::now() + kLook)) !=
         std::future_status::ready) {
    if (!link->executor->is_stopped() && std::chrono::steady_clock::now() < deadline) continue;
    link->loop->post([this, id] { deliveries->forget(*id); });
    return std::nullopt;
  }
  try {
    return future.get();
  } catch (const std::future_error&) {  // the loop had ended
    return std::nullopt;
  }
}

// A node of this process has had its messages handed over already, so the question may go straight
// to it.
bool Node::Impl::ask_delivery(const std::string& client, const PeerMessage& question) {
  const LocalNode node = LocalNodes::of_this_process().find(client);
  if (!link->use_pointers || !node.loop) return channels->send_to_client(client, question);
  node.when_delivered(record.instance(), [this, loop = link->loop, client,
                                          id = question.delivery_question().id()](auto answer) {
    answer.set_id(id);
    loop->post([this, client, answer] { deliveries->take_answer(client, answer); });
  });
  return true;
}

// The executor runs callbacks in the order of arrival, so all messages that came before the
// question are through when its turn comes.
void Node::Impl::answer_delivery(const std::string& server,
                                 std::function<void(PeerMessage::DeliveryAnswer)> reply) {
  link->executor->schedule("delivery", [this, server, reply = std::move(reply)] {
    link->loop->post([this, server, reply] {
      PeerMessage::DeliveryAnswer answer;
      subscribers->fill(server, answer);
      reply(std::move(answer));
    });
  });
}

}  // namespace prehend::graph
