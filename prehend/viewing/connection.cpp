#include "prehend/viewing/connection.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <boost/asio/bind_executor.hpp>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "prehend/viewing/page_files.h"
#include "prehend/viewing/protocol.h"

namespace prehend::viewing {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

constexpr auto kRequestTimeout = std::chrono::seconds(10);
constexpr std::size_t kReadAtOnce = 65536;
constexpr std::size_t kMostHeaderBytes = 16384;

std::string address_of(const tcp::socket& socket) {
  error_code error;
  const auto peer = socket.remote_endpoint(error);
  return error ? "?" : fmt::format("{}:{}", peer.address().to_string(), peer.port());
}

std::string text_of(beast::string_view view) { return {view.data(), view.size()}; }

// What all of them need.
struct Surroundings {
  Hub& hub;
  const ServerOptions& options;
  const AccessRules& rules;
  ConnectionCount& connections;
};

// --- a viewer -----------------------------------------------------------------------------------

class ViewerConnection : public std::enable_shared_from_this<ViewerConnection> {
 public:
  ViewerConnection(beast::tcp_stream stream, const Surroundings& around)
      : around_(around),
        peer_(address_of(stream.socket())),
        socket_(std::move(stream)),
        place_(around_.connections.add([] {}, true)) {}
  ~ViewerConnection() {
    if (id_) around_.hub.disconnect(*id_);
    around_.connections.remove(place_, true);
  }

  void accept(const http::request<http::string_body>& request, const std::string& subprotocol) {
    auto self = shared_from_this();
    *place_ = [weak = weak_from_this()] {
      if (const auto it = weak.lock())
        it->close(websocket::close_code::going_away, "the viewer ends");
    };
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has its own
    socket_.set_option(
        websocket::stream_base::timeout{kRequestTimeout, around_.options.idle_timeout, true});
    socket_.set_option(
        websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
          response.set(http::field::sec_websocket_protocol, subprotocol);
          response.set(http::field::server, "prehend");
        }));
    socket_.read_message_max(0);   // see read()
    socket_.auto_fragment(false);  // a payload goes out from where it lies
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().set_option(tcp::no_delay(true), ignored);
    writing_ = true;  // the answer: a close frame may not come between
    socket_.async_accept(request, [self](error_code error) {
      self->writing_ = false;
      if (error) return;
      if (self->pending_close_) return self->send_close();
      self->begin();
    });
  }

 private:
  void begin() {
    // The hub may speak in the middle of what it does, so nothing is done at once.
    const auto later = [weak = weak_from_this()](auto function) {
      return [weak, function](auto... arguments) {
        const auto self = weak.lock();
        if (!self) return;
        asio::post(self->socket_.get_executor(),
                   [self, function, arguments...] { function(*self, arguments...); });
      };
    };
    Hub::Wire wire;
    wire.wake = [this, wake = later([](ViewerConnection& self) { self.write(); })] {
      if (std::exchange(woken_, true)) return;
      wake();
    };
    wire.close = later([](ViewerConnection& self, const std::string& reason) {
      self.close(websocket::close_code::policy_error, reason);
      self.drop_soon();
    });
    id_ = around_.hub.connect(peer_, std::move(wire));
    read();
  }

  void read() {
    socket_.async_read_some(buffer_, kReadAtOnce,
                            [self = shared_from_this()](error_code error, std::size_t) {
                              if (!error) self->take();
                            });
  }

  // A message is refused before more of it is kept than it may have, whatever its header says.
  void take() {
    if (buffer_.size() > around_.options.most_frame_bytes) {
      closing_ = true;
      const std::string why =
          fmt::format("a message may have at most {} bytes", around_.options.most_frame_bytes);
      return close(websocket::close_code::too_big, why);
    }
    if (socket_.is_message_done()) {
      const std::string_view message(static_cast<const char*>(buffer_.data().data()),
                                     buffer_.size());
      if (socket_.got_text()) {
        around_.hub.receive_text(*id_, message);
      } else {
        around_.hub.receive_binary(*id_, message);
      }
      buffer_.consume(buffer_.size());
      if (buffer_.capacity() > kReadAtOnce) buffer_.shrink_to_fit();
    }
    read();
  }

  void write() {
    woken_ = false;
    if (writing_ || closing_) return;
    auto frame = around_.hub.next_frame(*id_);
    if (!frame) return;
    frame_ = std::move(*frame);
    writing_ = true;
    socket_.text(frame_.is_text);
    const std::array<asio::const_buffer, 2> parts{
        asio::const_buffer(frame_.head.data(), frame_.head_size), asio::buffer(*frame_.payload)};
    socket_.async_write(parts, [self = shared_from_this()](error_code error, std::size_t) {
      self->writing_ = false;
      self->frame_.payload.reset();
      if (error) return self->drop();
      if (self->pending_close_) return self->send_close();
      self->write();
    });
  }

  // A close frame waits for the message that is being sent.
  void close(websocket::close_code code, const std::string& reason) {
    closing_ = true;
    if (pending_close_) return;
    constexpr std::size_t kLongestReason = 120;
    pending_close_ = websocket::close_reason(code, reason.substr(0, kLongestReason));
    if (!writing_) send_close();
  }

  void send_close() {
    socket_.async_close(*pending_close_, [self = shared_from_this()](error_code) { self->drop(); });
  }

  // Who does not read does not get the close frame either.
  void drop_soon() {
    if (writing_) drop();
  }

  void drop() {
    closing_ = true;
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

  Surroundings around_;
  const std::string peer_;
  websocket::stream<beast::tcp_stream> socket_;
  ConnectionCount::Place place_;
  beast::flat_buffer buffer_;
  std::optional<ViewerId> id_;
  Outbox::Frame frame_;  // that is being sent
  bool writing_ = false, woken_ = false, closing_ = false;
  std::optional<websocket::close_reason> pending_close_;
};

// --- HTTP ---------------------------------------------------------------------------------------

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket socket, const Surroundings& around)
      : around_(around),
        stream_(std::move(socket)),
        place_(around_.connections.add([] {}, false)) {}
  ~HttpConnection() { around_.connections.remove(place_, false); }

  void read() {
    *place_ = [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->end();
    };
    parser_.emplace();
    parser_->header_limit(kMostHeaderBytes);
    parser_->body_limit(0);
    stream_.expires_after(kRequestTimeout);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](error_code error, std::size_t) { self->take(error); });
  }

 private:
  using Response = http::response<http::string_body>;

  void take(error_code error) {
    if (error == http::error::end_of_stream) return end();
    if (error == http::error::header_limit || error == http::error::body_limit) {
      return answer_words(http::status::payload_too_large, "This request is too long.");
    }
    if (error.category() == http::make_error_code(http::error::bad_method).category()) {
      return answer_words(http::status::bad_request, "This is no HTTP request: " + error.message());
    }
    if (error) return;
    const auto& request = parser_->get();
    if (websocket::is_upgrade(request)) return upgrade(request);
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      return answer_words(http::status::method_not_allowed, "Only GET and HEAD are served.");
    }
    PageFile file = page_file(around_.options.page, text_of(request.target()));
    answer(static_cast<http::status>(file.status), file.type, std::move(file.content),
           request.keep_alive(), request.method() == http::verb::head);
  }

  void upgrade(const http::request<http::string_body>& request) {
    if (around_.connections.viewers() >= around_.options.most_viewers) {
      return answer_words(
          http::status::service_unavailable,
          fmt::format("{} viewers are here already.", around_.options.most_viewers));
    }
    AccessRequest access;
    access.host = text_of(request[http::field::host]);
    access.target = text_of(request.target());
    if (const auto origin = request.find(http::field::origin); origin != request.end()) {
      access.origin = text_of(origin->value());
    }
    if (const std::string why = objection(around_.rules, access); !why.empty()) {
      return answer_words(http::status::forbidden, why);
    }
    const std::string subprotocol =
        chosen_subprotocol(text_of(request[http::field::sec_websocket_protocol]));
    if (subprotocol.empty()) {
      return answer_words(http::status::bad_request,
                          fmt::format("The WebSocket speaks the sub-protocols {} and {}, and was "
                                      "asked for '{}'.",
                                      kSubprotocols[0], kSubprotocols[1],
                                      text_of(request[http::field::sec_websocket_protocol])));
    }
    std::make_shared<ViewerConnection>(std::move(stream_), around_)->accept(request, subprotocol);
  }

  void answer_words(http::status status, const std::string& text) {
    answer(status, "text/plain; charset=utf-8", text + "\n", false, false);
  }

  void answer(http::status status, const std::string& type, std::string content, bool keep_alive,
              bool head_only) {
    auto response = std::make_shared<Response>(status, 11);
    response->set(http::field::server, "prehend");
    response->set(http::field::content_type, type);
    response->set(http::field::cache_control, "no-cache");
    response->set("Content-Security-Policy", kContentSecurityPolicy);
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->keep_alive(keep_alive);
    const std::size_t size = content.size();
    if (!head_only) response->body() = std::move(content);
    response->content_length(size);
    stream_.expires_after(kRequestTimeout);
    http::async_write(
        stream_, *response,
        [self = shared_from_this(), response, keep_alive](error_code error, std::size_t) {
          if (error || !keep_alive) return self->end();
          self->read();
        });
  }

  void end() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
    stream_.close();
  }

  Surroundings around_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMostHeaderBytes * 2};
  std::optional<http::request_parser<http::string_body>> parser_;
  ConnectionCount::Place place_;
};

}  // namespace

void serve_connection(tcp::socket socket, Hub& hub, const ServerOptions& options,
                      const AccessRules& rules, ConnectionCount& connections) {
  constexpr std::size_t kConnectionsForEach = 4;  // of a browser that loads the page
  if (connections.size() >= kConnectionsForEach * options.most_viewers) return;
  std::make_shared<HttpConnection>(std::move(socket),
                                   Surroundings{hub, options, rules, connections})
      ->read();
}

}  // namespace prehend::viewing
