// Our own nodes, through the public interface only, registry included.

#include <unistd.h>
#include <cstring>

#include "bench/graph/latency.h"
#include "bench/graph/node_options.h"
#include "bench/graph/peers.h"
#include "msgs/sensors.pb.h"

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;
using graph::QoS;
using msgs::StereoPair;

constexpr const char* kTopic = "/bench/cloud";
const QoS kQos = QoS::queue(8);

class NodeSender : public Sender {
 public:
  NodeSender(NodeWay way, const Job& job)
      : way_(way),
        payload_(job.bytes, static_cast<char>(kPayloadMark)),
        registry_({.endpoint = "tcp://127.0.0.1:*"}),
        node_(node_options("sender", registry_.endpoint(), way != NodeWay::kInline)),
        publisher_(node_.advertise<StereoPair>(kTopic, kQos)) {
    if (way != NodeWay::kSlabLoaned) message_.set_data(payload_);
    node_.spin_in_background();
  }
  std::string address() const override { return registry_.endpoint(); }
  void wait_until_connected() override {
    if (!publisher_.wait_for_subscribers(1, 10s)) throw BenchError("the subscriber does not join");
  }
  void send() override {
    switch (way_) {
      case NodeWay::kInline:
      case NodeWay::kSlabCopy:
        message_.mutable_header()->set_stamp(monotonic_now());
        publisher_.publish(message_);
        return;
      case NodeWay::kSlabLoaned:
        return send_loaned();
      case NodeWay::kHandOver:
        return send_pointer();
    }
  }

 private:
  /// The time of filling is taken out of what is measured.
  void send_loaned() {
    const std::int64_t begin = monotonic_now();
    graph::LoanedPayload loan = publisher_.loan(payload_.size());
    const std::int64_t loaned = monotonic_now();
    std::memcpy(loan.bytes().data(), payload_.data(), payload_.size());
    StereoPair message;
    message.mutable_header()->set_stamp(monotonic_now() - (loaned - begin));
    publisher_.publish(std::move(message), std::move(loan));
  }
  /// Likewise: the message is made before the clock starts.
  void send_pointer() {
    auto message = std::make_shared<StereoPair>(message_);
    message->mutable_header()->set_stamp(monotonic_now());
    publisher_.publish(std::shared_ptr<const StereoPair>(std::move(message)));
  }

  const NodeWay way_;
  const std::string payload_;
  StereoPair message_;
  graph::Registry registry_;
  graph::Node node_;
  graph::Publisher<StereoPair> publisher_;
};

class NodeReceiver : public Receiver {
 public:
  NodeReceiver(NodeWay way, const Job& job, const std::string& registry, OnMessage on_message)
      : node_(node_options("receiver", registry, way != NodeWay::kInline)),
        subscription_(node_.subscribe<StereoPair>(
            kTopic, kQos,
            [bytes = job.bytes,
             on_message = std::move(on_message)](const graph::Received<StereoPair>& received) {
              const auto payload = received.payload();
              if (const char* problem = check_payload(payload.data(), payload.size(), bytes)) {
                end_worker(problem);
              }
              on_message(received.body().header().stamp());
            })) {
    node_.spin_in_background();
  }

 private:
  graph::Node node_;
  graph::Subscription subscription_;
};

}  // namespace

MakeSender make_node_sender(NodeWay way) {
  return [way](const Job& job) { return std::make_unique<NodeSender>(way, job); };
}

MakeReceiver make_node_receiver(NodeWay way) {
  return [way](const Job& job, const std::string& address, OnMessage on_message) {
    return std::make_unique<NodeReceiver>(way, job, address, std::move(on_message));
  };
}

}  // namespace prehend::bench
