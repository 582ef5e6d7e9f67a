// The peer ROS 1: PointCloud2 through roscpp's own interface, with a master of its own on loopback.
// Run by bench_graph as one of its workers.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <thread>

#include "bench/graph/latency.h"
#include "bench/graph/worker_pair.h"

namespace prehend::bench {
namespace {

using namespace std::chrono_literals;

constexpr const char* kMasterProgram = "/usr/bin/rosmaster";
constexpr const char* kTopic = "/bench/cloud";

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

int free_port() {
  const int socket_descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof(address);
  auto* pointer = reinterpret_cast<sockaddr*>(&address);
  const bool ok = bind(socket_descriptor, pointer, size) == 0 &&
                  getsockname(socket_descriptor, pointer, &size) == 0;
  close(socket_descriptor);
  if (!ok) throw BenchError("no free port on loopback for the ROS master");
  return ntohs(address.sin_port);
}

bool answers(int port) {
  const int socket_descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(port);
  const bool connected =
      connect(socket_descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  close(socket_descriptor);
  return connected;
}

/// A folder for ROS's log files that goes with the process.
class LogFolder {
 public:
  LogFolder() {
    char path[] = "/tmp/bench-graph-ros-XXXXXX";
    if (mkdtemp(path) == nullptr) throw BenchError("no folder in /tmp for ROS's logs");
    path_ = path;
    setenv("ROS_LOG_DIR", path, 1);
  }
  ~LogFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  LogFolder(const LogFolder&) = delete;
  LogFolder& operator=(const LogFolder&) = delete;

 private:
  std::string path_;
};

/// rosmaster on a free port of loopback; ends with this object or process.
class Master {
 public:
  Master()
      : port_(free_port()), process_(kMasterProgram, {"--core", "-p", std::to_string(port_)}, -1) {
    for (int i = 0; i < 1000 && !answers(port_) && !interrupted; ++i)
      std::this_thread::sleep_for(10ms);
    if (!answers(port_)) throw BenchError("the ROS master does not start within 10 s");
  }
  std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_); }

 private:
  int port_;
  WorkerProcess process_;
};

/// This process as a ROS node: made before anything else of roscpp.
class RosProcess {
 public:
  RosProcess(const std::string& master_uri, const std::string& name) {
    const ros::M_string remappings = {{"__master", master_uri}, {"__ip", "127.0.0.1"}};
    ros::init(remappings, name, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
    node_ = std::make_unique<ros::NodeHandle>();
  }
  ~RosProcess() { ros::shutdown(); }
  RosProcess(const RosProcess&) = delete;
  RosProcess& operator=(const RosProcess&) = delete;
  ros::NodeHandle& node() { return *node_; }

 private:
  std::unique_ptr<ros::NodeHandle> node_;
};

class RosSender : public Sender {
 public:
  explicit RosSender(const Job& job)
      : process_(master_.uri(), "bench_sender"),
        publisher_(process_.node().advertise<sensor_msgs::PointCloud2>(kTopic, 8)) {
    message_.data.assign(job.bytes, kPayloadMark);
    spinner_.start();
  }
  std::string address() const override { return master_.uri(); }
  void wait_until_connected() override {
    for (int i = 0; i < 1000 && !interrupted; ++i) {
      if (publisher_.getNumSubscribers() > 0) return;
      std::this_thread::sleep_for(10ms);
    }
    throw BenchError("the ROS subscriber does not join within 10 s");
  }
  void send() override {
    message_.header.stamp.fromNSec(static_cast<std::uint64_t>(monotonic_now()));
    publisher_.publish(message_);
  }

 private:
  Master master_;
  RosProcess process_;
  ros::Publisher publisher_;
  ros::AsyncSpinner spinner_{1};
  sensor_msgs::PointCloud2 message_;
};

class RosReceiver : public Receiver {
 public:
  RosReceiver(const Job& job, const std::string& master_uri, OnMessage on_message)
      : bytes_(job.bytes),
        on_message_(std::move(on_message)),
        process_(master_uri, "bench_receiver"),
        subscriber_(process_.node().subscribe(kTopic, 8, &RosReceiver::take, this,
                                              ros::TransportHints().tcpNoDelay())) {
    spinner_.start();
  }
  ~RosReceiver() override { spinner_.stop(); }

 private:
  void take(const sensor_msgs::PointCloud2ConstPtr& message) {
    if (const char* problem = check_payload(message->data.data(), message->data.size(), bytes_)) {
      end_worker(problem);
    }
    on_message_(static_cast<std::int64_t>(message->header.stamp.toNSec()));
  }

  std::size_t bytes_;
  OnMessage on_message_;
  RosProcess process_;
  ros::Subscriber subscriber_;
  ros::AsyncSpinner spinner_{1};
};

void run(const WorkerCommand& command) {
  const LogFolder logs;
  keep_heap_warm();
  Channel channel(WorkerProcess::kChannelDescriptor);
  if (command.role == "sender") {
    run_latency_sender(
        command.job, [](const Job& job) { return std::make_unique<RosSender>(job); }, channel);
  } else {
    run_latency_receiver(
        command.job,
        [](const Job& job, const std::string& address, OnMessage on_message) {
          return std::make_unique<RosReceiver>(job, address, std::move(on_message));
        },
        channel);
  }
}

}  // namespace
}  // namespace prehend::bench

int main(int argc, char** argv) {
  try {
    prehend::bench::catch_interrupts();
    prehend::bench::run(prehend::bench::parse_worker_arguments(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "bench_graph_ros1: " << error.what() << "\n";
    return 1;
  }
}
