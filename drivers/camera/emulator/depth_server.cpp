#include "drivers/camera/emulator/depth_server.h"

#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

#include "drivers/wire/stream/tcp_server.h"

namespace prehend::drivers::camera {
namespace {

using namespace std::chrono_literals;

constexpr auto kReadTime = 20ms;
constexpr auto kWriteTime = 1s;  // a picture of megabytes to a client that is held up

}  // namespace

DepthServer::DepthServer(std::uint16_t port) {
  auto server = std::make_unique<TcpServer>(port);  // here, so that a taken port is told
  address_ = server->name().substr(std::strlen("tcp://"));
  const auto own_port = static_cast<std::uint16_t>(
      std::strtoul(address_.c_str() + address_.rfind(':') + 1, nullptr, 10));
  thread_ = std::thread([this, own_port, server = std::move(server)]() mutable {
    std::array<std::uint8_t, kQuestionSize> buffer{};
    std::size_t count = 0;
    while (!ends_) {
      if (unplugged_) {
        server.reset();  // nobody listens: connections are refused
        count = 0;
        std::this_thread::sleep_for(kReadTime);
        continue;
      }
      if (!server) {
        try {
          server = std::make_unique<TcpServer>(own_port);
        } catch (const std::exception&) {  // another took the port meanwhile, or will give it back
          std::this_thread::sleep_for(kReadTime);
          continue;
        }
      }
      const IoResult result = server->read(std::span(buffer).subspan(count), kReadTime);
      if (result.status == IoStatus::kTimeout && !result.problem.empty()) count = 0;  // he left
      count += result.count;
      if (count < buffer.size()) continue;
      count = 0;
      const auto known = decode_question(buffer);
      if (!known) {
        server->disconnect();  // he speaks something else
        continue;
      }
      if (silent_) continue;
      std::vector<std::uint8_t> answer;
      {
        const std::lock_guard lock(mutex_);
        answer = *known == number_ || number_ == 0 ? encode_nothing_new(*known) : answer_;
      }
      if (server->write(answer, kWriteTime).count != answer.size()) server->disconnect();
    }
  });
}

DepthServer::~DepthServer() {
  ends_ = true;
  thread_.join();
}

void DepthServer::show(DepthPicture picture) {
  const std::lock_guard lock(mutex_);
  picture.number = ++number_;
  answer_ = encode_answer(picture);
}

}  // namespace prehend::drivers::camera
