// The transport most people write first: the whole protobuf message in one ZeroMQ frame.

#include <atomic>
#include <thread>

#include <zmq.hpp>

#include "bench/graph/peers.h"
#include "msgs/sensors.pb.h"

namespace prehend::bench {
namespace {

class NaiveSender : public Sender {
 public:
  explicit NaiveSender(const Job& job) {
    message_.set_data(std::string(job.bytes, static_cast<char>(kPayloadMark)));
    socket_.set(zmq::sockopt::sndtimeo, 10'000);
    socket_.set(zmq::sockopt::linger, 0);
    socket_.bind("ipc://@prehend-bench-naive-" + std::to_string(getpid()));
  }
  std::string address() const override { return socket_.get(zmq::sockopt::last_endpoint); }
  // A PAIR socket blocks until its other side is there.
  void wait_until_connected() override {}
  void send() override {
    message_.mutable_header()->set_stamp(monotonic_now());
    const std::string bytes = message_.SerializeAsString();
    if (!socket_.send(zmq::buffer(bytes))) throw BenchError("ZeroMQ does not send");
  }

 private:
  msgs::StereoPair message_;
  zmq::context_t context_;
  zmq::socket_t socket_{context_, zmq::socket_type::pair};
};

class NaiveReceiver : public Receiver {
 public:
  NaiveReceiver(const Job& job, const std::string& address, OnMessage on_message)
      : thread_([this, job, address, on_message = std::move(on_message)] {
          receive(job, address, on_message);
        }) {}
  ~NaiveReceiver() override {
    stop_ = true;
    thread_.join();
  }

 private:
  void receive(const Job& job, const std::string& address, const OnMessage& on_message) {
    zmq::socket_t socket(context_, zmq::socket_type::pair);
    socket.set(zmq::sockopt::rcvtimeo, 200);
    socket.connect(address);
    while (!stop_) {
      zmq::message_t frame;
      if (!socket.recv(frame)) continue;
      msgs::StereoPair message;
      if (!message.ParseFromArray(frame.data(), static_cast<int>(frame.size()))) {
        end_worker("a naive message does not parse");
      }
      const auto* data = reinterpret_cast<const std::uint8_t*>(message.data().data());
      if (const char* problem = check_payload(data, message.data().size(), job.bytes)) {
        end_worker(problem);
      }
      on_message(message.header().stamp());
    }
  }

  zmq::context_t context_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Sender> make_naive_sender(const Job& job) {
  return std::make_unique<NaiveSender>(job);
}
std::unique_ptr<Receiver> make_naive_receiver(const Job& job, const std::string& address,
                                              OnMessage on_message) {
  return std::make_unique<NaiveReceiver>(job, address, std::move(on_message));
}

}  // namespace prehend::bench
