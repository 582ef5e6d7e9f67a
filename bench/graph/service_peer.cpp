// The round trip of a service between two processes, from call() until the answer is decoded.

#include "bench/graph/latency.h"
#include "bench/graph/node_options.h"
#include "bench/graph/peers.h"
#include "msgs/sensors.pb.h"

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;
using msgs::Clock;
using msgs::StereoPair;

constexpr const char* kService = "/bench/size";

}  // namespace

void run_service_client(const Job& job, Channel& channel) {
  graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  graph::Node node(node_options("client", registry.endpoint()));
  node.spin_in_background();
  const auto client = node.client<StereoPair, Clock>(kService);
  channel.write_line(registry.endpoint());
  channel.read_line(20s);
  if (!client.wait_for_server(10s)) throw BenchError("the service does not appear");

  StereoPair request;
  request.set_data(std::string(job.bytes, static_cast<char>(kPayloadMark)));
  std::vector<std::int64_t> round_trips;
  const std::int64_t end = monotonic_now() + static_cast<std::int64_t>(job.seconds * 1e9);
  while (!interrupted && monotonic_now() < end) {
    const std::int64_t begin = monotonic_now();
    const auto answer = client.call(request, 10s);
    round_trips.push_back(monotonic_now() - begin);
    if (!answer.ok()) throw BenchError("a service call failed: " + answer.error());
    if (answer->time() != static_cast<std::int64_t>(job.bytes)) {
      throw BenchError("a service answered with a wrong value");
    }
  }
  print_latencies(round_trips);
}

void run_service_server(const Job&, Channel& channel) {
  graph::Node node(node_options("server", channel.read_line(20s)));
  const auto service = node.serve<StereoPair, Clock>(kService, [](const StereoPair& request) {
    Clock answer;
    answer.set_time(static_cast<std::int64_t>(request.data().size()));
    return answer;
  });
  node.spin_in_background();
  channel.write_line("ready");
  channel.wait_for_end();
}

}  // namespace prehend::bench
