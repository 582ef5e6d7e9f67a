#include "prehend/viewing/server.h"

#include <unistd.h>

#include <atomic>
#include <random>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "prehend/viewing/connection.h"

namespace prehend::viewing {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

std::string random_word() {
  std::random_device random;
  std::string word;
  for (int i = 0; i < 4; ++i) word += fmt::format("{:08x}", random());
  return word;
}

}  // namespace

struct Server::Impl {
  Impl(const ServerOptions& its_options, Handlers handlers)
      : options(its_options),
        hub(options.name, random_word(), std::move(handlers), options.limits,
            [this](std::function<void()> function) { asio::post(io, std::move(function)); }),
        acceptor(io),
        pause(io),
        second(io) {}

  void listen();
  void accept();
  void tick();
  void run() { io.run(); }
  void post(std::function<void()> function) { asio::post(io, std::move(function)); }

  const ServerOptions options;
  AccessRules rules;
  ConnectionCount connections;
  Hub hub;
  asio::io_context io{1};  // goes with the connections that it still holds, which tell the hub
  tcp::acceptor acceptor;
  asio::steady_timer pause, second;
  std::atomic<ChannelId> last_channel{0};
  std::atomic<ServiceId> last_service{0};
  std::atomic<std::size_t> viewers{0};
  bool ends = false;  // in the thread
  std::thread thread;
};

void Server::Impl::listen() {
  const auto failed = [this](const std::string& why) {
    return std::runtime_error(
        fmt::format("cannot listen at {} port {}: {}", options.address, options.port, why));
  };
  error_code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error) throw failed("this is no address, as 127.0.0.1 is one");
  rules = {address.is_loopback(), options.token, options.allowed_origins};
  if (!rules.loopback && rules.token.empty()) {
    throw failed(
        "whoever reaches this address could move the robot; give a token, or listen at "
        "127.0.0.1");
  }
  const tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), error);
  if (error) throw failed(error.message());
  acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  acceptor.bind(endpoint, error);
  if (error == asio::error::address_in_use) {
    throw failed(
        "another program, perhaps another viewer, has it; choose another port, or 0 for "
        "any that is free");
  }
  if (error) throw failed(error.message());
  acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) throw failed(error.message());
}

void Server::Impl::accept() {
  acceptor.async_accept([this](error_code error, tcp::socket socket) {
    if (ends || error == asio::error::operation_aborted) return;
    if (error) {  // as no file handle is free: those that are served go on
      pause.expires_after(std::chrono::milliseconds(100));
      pause.async_wait([this](error_code) { accept(); });
      return;
    }
    serve_connection(std::move(socket), hub, options, rules, connections);
    accept();
  });
}

void Server::Impl::tick() {
  hub.tell_losses();
  second.expires_after(std::chrono::seconds(1));
  second.async_wait([this](error_code error) {
    if (!error && !ends) tick();
  });
}

Server::Server(const ServerOptions& options, Handlers handlers)
    : impl_(std::make_unique<Impl>(options, std::move(handlers))) {
  impl_->listen();
  impl_->accept();
  impl_->tick();
  impl_->thread = std::thread([this] { impl_->run(); });
}

Server::~Server() {
  impl_->post([impl = impl_.get()] {
    impl->ends = true;
    error_code ignored;
    impl->acceptor.close(ignored);
    impl->second.cancel();
    impl->connections.close_all();
    // Who does not answer a goodbye is left without.
    impl->pause.expires_after(std::chrono::milliseconds(300));
    impl->pause.async_wait([impl](error_code) { impl->io.stop(); });
    impl->connections.on_empty = [impl] { impl->io.stop(); };
    if (impl->connections.empty()) impl->io.stop();
  });
  impl_->thread.join();
  impl_->connections.on_empty = nullptr;
}

std::uint16_t Server::port() const { return impl_->acceptor.local_endpoint().port(); }

std::string Server::page_address() const {
  const auto address = impl_->acceptor.local_endpoint().address();
  std::string host = address.to_string();
  if (address.is_unspecified()) {
    char name[256] = {};
    host = ::gethostname(name, sizeof name - 1) == 0 ? name : "localhost";
  } else if (address.is_v6()) {
    host = "[" + host + "]";
  }
  return fmt::format("http://{}:{}/{}", host, port(),
                     impl_->rules.token.empty() ? "" : "?token=" + impl_->rules.token);
}

ChannelId Server::add_channel(Channel channel) {
  const ChannelId id = ++impl_->last_channel;
  impl_->post([impl = impl_.get(), id, channel = std::move(channel)]() mutable {
    impl->hub.add_channel(id, std::move(channel));
  });
  return id;
}

void Server::remove_channel(ChannelId id) {
  impl_->post([impl = impl_.get(), id] { impl->hub.remove_channel(id); });
}

ServiceId Server::add_service(ServiceType service) {
  const ServiceId id = ++impl_->last_service;
  impl_->post([impl = impl_.get(), id, service = std::move(service)]() mutable {
    impl->hub.add_service(id, std::move(service));
  });
  return id;
}

void Server::remove_service(ServiceId id) {
  impl_->post([impl = impl_.get(), id] { impl->hub.remove_service(id); });
}

void Server::publish(ChannelId id, std::uint64_t time, Payload payload, std::string sender) {
  impl_->post([impl = impl_.get(), id, time, payload = std::move(payload),
               sender = std::move(sender)] { impl->hub.publish(id, time, payload, sender); });
}

void Server::set_time(std::uint64_t time) {
  impl_->post([impl = impl_.get(), time] { impl->hub.set_time(time); });
}

void Server::set_graph(ConnectionGraph graph) {
  impl_->post([impl = impl_.get(), graph = std::move(graph)]() mutable {
    impl->hub.set_graph(std::move(graph));
  });
}

void Server::publish_parameters(std::vector<Parameter> parameters) {
  impl_->post([impl = impl_.get(), parameters = std::move(parameters)] {
    impl->hub.publish_parameters(parameters);
  });
}

void Server::tell(StatusLevel level, std::string message, std::string id) {
  impl_->post([impl = impl_.get(), level, message = std::move(message), id = std::move(id)] {
    impl->hub.tell(level, message, id);
  });
}

std::size_t Server::viewers() const { return impl_->connections.viewers(); }

}  // namespace prehend::viewing
