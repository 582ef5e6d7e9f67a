#include "bench/graph/workers.h"

#include <map>

#include "bench/graph/latency.h"
#include "bench/graph/peers.h"
#include "bench/graph/soak.h"

namespace prehend::bench {
namespace {

struct Ends {
  std::function<void(const Job&, Channel&)> sender;
  std::function<void(const Job&, Channel&)> receiver;
};

Ends latency_ends(MakeSender make_sender, MakeReceiver make_receiver) {
  return {
      [=](const Job& job, Channel& channel) { run_latency_sender(job, make_sender, channel); },
      [=](const Job& job, Channel& channel) { run_latency_receiver(job, make_receiver, channel); }};
}

Ends throughput_ends(bool batched) {
  return {[=](const Job& job, Channel& channel) { run_throughput_sender(job, batched, channel); },
          run_throughput_receiver};
}

Ends node_ends(NodeWay way) { return latency_ends(make_node_sender(way), make_node_receiver(way)); }

Ends ends_of(const std::string& peer) {
  const Ends naive = latency_ends(make_naive_sender, make_naive_receiver);
  const std::map<std::string, Ends> all = {
      {"naive_cold", naive},
      {"naive_warm", naive},
      {"ring", latency_ends(make_ring_sender, make_ring_receiver)},
      {"inline", node_ends(NodeWay::kInline)},
      {"slab_copy", node_ends(NodeWay::kSlabCopy)},
      {"slab_loaned", node_ends(NodeWay::kSlabLoaned)},
      {"service", {run_service_client, run_service_server}},
      {"soak", {run_soak_sender, run_soak_receiver}},
      {"throughput_publish", throughput_ends(false)},
      {"throughput_publish_all", throughput_ends(true)}};
  const auto found = all.find(peer);
  if (found == all.end()) throw BenchError("no such peer: " + peer);
  return found->second;
}

}  // namespace

void run_worker(const WorkerCommand& command) {
  // run_node does the same for every node's program.
  if (command.job.peer != "naive_cold") keep_heap_warm();
  if (command.role == "both") {
    run_latency_same_process(command.job, make_node_sender(NodeWay::kHandOver),
                             make_node_receiver(NodeWay::kHandOver));
    return;
  }
  Channel channel(WorkerProcess::kChannelDescriptor);
  const Ends ends = ends_of(command.job.peer);
  (command.role == "sender" ? ends.sender : ends.receiver)(command.job, channel);
}

}  // namespace prehend::bench
