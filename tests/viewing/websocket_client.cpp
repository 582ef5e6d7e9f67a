#include "tests/viewing/websocket_client.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace prehend::testing {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http_ = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr auto kTimeout = std::chrono::seconds(10);

tcp::endpoint local(std::uint16_t port) { return {asio::ip::address_v4::loopback(), port}; }

}  // namespace

struct WebSocketClient::Impl {
  // Runs until the operation that was begun has ended.
  void run(std::chrono::nanoseconds timeout = kTimeout) {
    io.restart();
    io.run_for(timeout);
  }

  asio::io_context io{1};
  websocket::stream<beast::tcp_stream> socket{io};
  std::string subprotocol;
  beast::flat_buffer buffer;
  bool is_reading = false, is_ended = false;
  std::optional<Frame> frame;
};

WebSocketClient::WebSocketClient(std::uint16_t port) : WebSocketClient(port, Options()) {}

WebSocketClient::WebSocketClient(std::uint16_t port, const Options& options)
    : impl_(std::make_unique<Impl>()) {
  auto& socket = impl_->socket;
  tcp::socket& plain = beast::get_lowest_layer(socket).socket();
  plain.open(tcp::v4());
  if (options.receive_buffer > 0) {
    plain.set_option(tcp::socket::receive_buffer_size(options.receive_buffer));
  }
  plain.connect(local(port));
  socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    if (!options.subprotocols.empty()) {
      request.set(http_::field::sec_websocket_protocol, options.subprotocols);
    }
    for (const auto& [name, value] : options.headers) request.set(name, value);
  }));
  socket.read_message_max(0);
  websocket::response_type response;
  error_code failure = asio::error::timed_out;
  socket.async_handshake(response, "127.0.0.1:" + std::to_string(port), options.target,
                         [&](error_code error) { failure = error; });
  impl_->run();
  if (failure) {
    throw std::runtime_error(std::to_string(response.result_int()) + " " +
                             std::string(response.body()) + " " + failure.message());
  }
  impl_->subprotocol = std::string(response[http_::field::sec_websocket_protocol]);
}

WebSocketClient::~WebSocketClient() {
  error_code ignored;
  beast::get_lowest_layer(impl_->socket).socket().close(ignored);
  impl_->run(std::chrono::milliseconds(100));
}

const std::string& WebSocketClient::subprotocol() const { return impl_->subprotocol; }

void WebSocketClient::send_text(const std::string& text) {
  error_code failure = asio::error::timed_out;
  impl_->socket.text(true);
  // Runs what is being read as well, so the handler ends the run.
  impl_->socket.async_write(asio::buffer(text), [&](error_code error, std::size_t) {
    failure = error;
    impl_->io.stop();
  });
  impl_->run();
  if (failure) throw std::runtime_error("cannot send: " + failure.message());
}

void WebSocketClient::send_binary(const std::string& bytes) {
  error_code failure = asio::error::timed_out;
  impl_->socket.binary(true);
  impl_->socket.async_write(asio::buffer(bytes), [&](error_code error, std::size_t) {
    failure = error;
    impl_->io.stop();
  });
  impl_->run();
  if (failure) throw std::runtime_error("cannot send: " + failure.message());
}

std::optional<WebSocketClient::Frame> WebSocketClient::receive(std::chrono::milliseconds timeout) {
  Impl& impl = *impl_;
  if (!impl.is_reading && !impl.is_ended && !impl.frame) {
    impl.is_reading = true;
    impl.socket.async_read(impl.buffer, [&impl](error_code error, std::size_t) {
      impl.is_reading = false;
      impl.is_ended = bool(error);
      if (!error) {
        impl.frame = Frame{impl.socket.got_text(), beast::buffers_to_string(impl.buffer.data())};
      }
      impl.buffer.consume(impl.buffer.size());
      impl.io.stop();
    });
  }
  if (!impl.frame && !impl.is_ended) impl.run(timeout);
  auto frame = std::move(impl.frame);
  impl.frame.reset();
  return frame;
}

std::string WebSocketClient::close_reason() const {
  const auto reason = impl_->socket.reason().reason;
  return {reason.data(), reason.size()};
}

int WebSocketClient::close_code() const { return impl_->socket.reason().code; }

void WebSocketClient::close() {
  impl_->socket.async_close(websocket::close_code::normal, [](error_code) {});
  impl_->run(std::chrono::seconds(2));
}

HttpAnswer http(std::uint16_t port, const std::string& request) {
  asio::io_context io;
  beast::tcp_stream stream(io);
  stream.socket().connect(local(port));
  error_code failure = asio::error::timed_out;
  http_::response<http_::string_body> response;
  beast::flat_buffer buffer;
  stream.expires_after(kTimeout);
  asio::write(stream.socket(), asio::buffer(request));
  http_::async_read(stream, buffer, response,
                    [&](error_code error, std::size_t) { failure = error; });
  io.run_for(kTimeout);
  if (failure) throw std::runtime_error("no answer: " + failure.message());
  HttpAnswer answer{static_cast<int>(response.result_int()), {}, response.body()};
  for (const auto& field : response) {
    std::string name(field.name_string());
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    answer.headers[name] = std::string(field.value());
  }
  return answer;
}

HttpAnswer http_get(std::uint16_t port, const std::string& target) {
  return http(port, "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
}

}  // namespace prehend::testing
