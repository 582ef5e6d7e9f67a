#pragma once

#include "bench/graph/channel.h"
#include "bench/graph/peer.h"

namespace prehend::bench {

std::unique_ptr<Sender> make_naive_sender(const Job& job);
std::unique_ptr<Receiver> make_naive_receiver(const Job& job, const std::string& address,
                                              OnMessage on_message);

std::unique_ptr<Sender> make_ring_sender(const Job& job);
std::unique_ptr<Receiver> make_ring_receiver(const Job& job, const std::string& address,
                                             OnMessage on_message);

/// How a node of the graph publishes.
enum class NodeWay {
  kInline,      ///< publish(const T&), shared memory off: frames over ipc
  kSlabCopy,    ///< publish(const T&): one copy into shared memory
  kSlabLoaned,  ///< loan(), filled before the clock starts, publish(T, LoanedPayload&&)
  kHandOver,    ///< publish(shared_ptr<const T>) to a node in the same process
};
MakeSender make_node_sender(NodeWay way);
MakeReceiver make_node_receiver(NodeWay way);

/// Round trips of a service; the caller's side measures.
void run_service_client(const Job& job, Channel& channel);
void run_service_server(const Job& job, Channel& channel);

/// Messages per second through one publisher, `batched`: by publish_all.
void run_throughput_sender(const Job& job, bool batched, Channel& channel);
void run_throughput_receiver(const Job& job, Channel& channel);

}  // namespace prehend::bench
