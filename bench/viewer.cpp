// What a viewer costs the machine that the graph runs on: processor time of the node `viewer`,
// while a publisher sends so many MB/s and so many viewers read them all, or do not.

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "msgs/camera.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/system/launched.h"
#include "tests/viewing/websocket_client.h"

namespace {

using namespace prehend;
using nlohmann::json;
using std::chrono::steady_clock;
using testing::WebSocketClient;

constexpr const char* kTopic = "/bench/image";

struct Choices {
  double rate = 10;  // MB/s
  double size = 1;   // MB, of a message
  int viewers = 1;
  double duration = 10;  // s
};

/// Processor time [s] and memory [MB] of a process.
struct Use {
  double cpu = 0, memory = 0;
};
Use use_of(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text((std::istreambuf_iterator<char>(stat)), {});
  text = text.substr(text.rfind(')') + 2);
  std::istringstream fields(text);
  std::string word;
  for (int i = 3; i < 14; ++i) fields >> word;  // to utime, field 14
  double user = 0, system = 0;
  fields >> user >> system;
  for (int i = 16; i < 24; ++i) fields >> word;
  double pages = 0;
  fields >> pages;
  return {(user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK)),
          pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6};
}

/// A viewer that reads whatever comes.
class Reader {
 public:
  explicit Reader(std::uint16_t port) : client_(port) {
    thread_ = std::thread([this] { read(); });
  }
  ~Reader() {
    ends_ = true;
    thread_.join();
  }
  double megabytes() const { return 1e-6 * static_cast<double>(bytes_); }

 private:
  void read() {
    while (!ends_) {
      const auto frame = client_.receive(std::chrono::milliseconds(100));
      if (!frame) continue;
      if (!frame->is_text) {
        bytes_ += frame->bytes.size();
        continue;
      }
      const json object = json::parse(frame->bytes);
      if (object["op"] != "advertise") continue;
      for (const json& channel : object["channels"]) {
        if (channel["topic"] != kTopic) continue;
        client_.send_text(json{{"op", "subscribe"},
                               {"subscriptions", {{{"id", 1}, {"channelId", channel["id"]}}}}}
                              .dump());
      }
    }
  }

  WebSocketClient client_;
  std::atomic<bool> ends_{false};
  std::atomic<std::uint64_t> bytes_{0};
  std::thread thread_;
};

std::uint16_t port_of(const testing::Launched& viewer) {
  const std::string before = "http://127.0.0.1:";
  const std::string text = viewer.output();
  const std::size_t at = text.find(before);
  if (at == std::string::npos) throw std::runtime_error("the viewer did not start: " + text);
  return static_cast<std::uint16_t>(std::atoi(text.c_str() + at + before.size()));
}

void publish_for(const graph::Publisher<msgs::Image>& publisher, const Choices& choices,
                 double seconds) {
  msgs::Image image;
  image.set_channels(1);
  image.set_width(1000);
  image.set_height(static_cast<std::uint32_t>(choices.size * 1000));
  image.set_data(std::string(static_cast<std::size_t>(choices.size * 1e6), 'x'));
  const std::chrono::duration<double> period(choices.size / choices.rate);
  const auto begin = steady_clock::now();
  for (int i = 0; i * period < std::chrono::duration<double>(seconds); ++i) {
    std::this_thread::sleep_until(begin +
                                  std::chrono::duration_cast<steady_clock::duration>(i * period));
    publisher.publish(image);
  }
}

void measure(const Choices& choices) {
  const graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  ::setenv("PREHEND_REGISTRY", registry.endpoint().c_str(), 1);
  graph::NodeOptions options;
  options.name = "bench";
  graph::Node node(options);
  node.spin_in_background();
  const auto publisher = node.advertise<msgs::Image>(kTopic, graph::QoS::queue(4));
  const testing::ScratchFolder scratch;
  testing::Launched viewer("viewer", {"--param", "port:=0"}, scratch.path() / "viewer");
  if (!viewer.wait_for_output("http://", std::chrono::seconds(20))) {
    throw std::runtime_error("the viewer did not start: " + viewer.output());
  }
  std::vector<std::unique_ptr<Reader>> readers;
  for (int i = 0; i < choices.viewers; ++i) {
    readers.push_back(std::make_unique<Reader>(port_of(viewer)));
  }
  if (choices.viewers > 0 && !publisher.wait_for_subscribers(1, std::chrono::seconds(10))) {
    throw std::runtime_error("no viewer subscribed");
  }
  publish_for(publisher, choices, 1);  // memory is warm then
  double before = 0, after = 0;
  for (const auto& reader : readers) before += reader->megabytes();
  const Use begin = use_of(viewer.pid());
  const auto start = steady_clock::now();
  publish_for(publisher, choices, choices.duration);
  const double elapsed = std::chrono::duration<double>(steady_clock::now() - start).count();
  const Use end = use_of(viewer.pid());
  for (const auto& reader : readers) after += reader->megabytes();
  std::printf(
      "%8.1f MB/s %7.3f MB a message %3d viewers: %6.2f %% of a core, %6.1f MB, got %7.1f MB/s\n",
      choices.rate, choices.size, choices.viewers, 100 * (end.cpu - begin.cpu) / elapsed,
      end.memory, (after - before) / elapsed);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What a viewer costs: processor time and memory of the node `viewer`."};
  Choices choices;
  app.add_option("--rate", choices.rate, "MB/s that are published")->check(CLI::Range(0.01, 1e4));
  app.add_option("--size", choices.size, "MB, of a message")->check(CLI::Range(0.001, 100.0));
  app.add_option("--viewers", choices.viewers, "that read all of it")->check(CLI::Range(0, 64));
  app.add_option("--duration", choices.duration, "s")->check(CLI::Range(1.0, 1e6));
  CLI11_PARSE(app, argc, argv);
  try {
    measure(choices);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_viewer: %s\n", error.what());
    return 1;
  }
  return 0;
}
