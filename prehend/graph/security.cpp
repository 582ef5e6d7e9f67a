#include "prehend/graph/security.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "prehend/text/nearest_match.h"

namespace prehend::graph {
namespace {

constexpr std::size_t kKeyLength = 40;       // characters of Z85
constexpr std::size_t kMaxFileBytes = 4096;  // a key file has about 250
constexpr const char* kPublicLine = "public_key";
constexpr const char* kSecretLine = "secret_key";

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error("key file '" + file + "': " + what);
}

// Closes the descriptor it holds.
class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

void check_curve() {
  if (zmq_has("curve") != 1) {
    throw std::runtime_error("this ZeroMQ library was built without CURVE (libsodium)");
  }
}

void write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw std::runtime_error(std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(descriptor) != 0) throw std::runtime_error(std::strerror(errno));
}

std::string read_private_file(const std::string& file) {
  // O_NONBLOCK: a pipe of that name must not make the program wait.
  const File opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status = {};
  if (opened.get() < 0 || ::fstat(opened.get(), &status) != 0) {
    fail(file, std::string(std::strerror(errno)) +
                   (errno == ENOENT ? "; 'prehend keys create' makes one" : ""));
  }
  if (!S_ISREG(status.st_mode)) fail(file, "not a regular file");
  if ((status.st_mode & 077) != 0) {
    fail(file, fmt::format("others than its owner may use it (mode {:04o}); run: chmod 600 {}",
                           status.st_mode & 07777, file));
  }
  std::string text(kMaxFileBytes + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = ::read(opened.get(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(file, std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > kMaxFileBytes) fail(file, "larger than any key file");
  text.resize(size);
  return text;
}

void check_key(const std::string& file, int line, const std::string& name, const std::string& key) {
  if (key.size() != kKeyLength) {
    fail(file, fmt::format("line {}: {} has {} characters, a key has {}", line, name, key.size(),
                           kKeyLength));
  }
  std::array<std::uint8_t, 32> decoded{};
  // A null character would end the text early for ZeroMQ.
  if (key.find('\0') != std::string::npos || !zmq_z85_decode(decoded.data(), key.c_str())) {
    fail(file, fmt::format("line {}: {} is not in Z85", line, name));
  }
}

std::string host_of_tcp(const std::string& endpoint) {
  const std::string rest = endpoint.substr(std::strlen("tcp://"));
  return rest.substr(0, rest.rfind(':'));
}

}  // namespace

GraphKeys create_graph_keys(const std::string& file) {
  check_curve();
  std::array<char, kKeyLength + 1> public_key{}, secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
    throw std::runtime_error(std::string("cannot make keys: ") + zmq_strerror(zmq_errno()));
  }
  const File created(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  if (created.get() < 0) {
    fail(file, errno == EEXIST ? "exists already; keys are never overwritten, name another file"
                               : std::strerror(errno));
  }
  GraphKeys keys{public_key.data(), secret_key.data()};
  try {
    write_all(created.get(),
              fmt::format("# Keys of a prehend graph. Whoever can read this can join the graph and "
                          "read all of it.\n{}: {}\n{}: {}\n",
                          kPublicLine, keys.public_key, kSecretLine, keys.secret_key));
  } catch (const std::runtime_error& error) {
    ::unlink(file.c_str());
    fail(file, error.what());
  }
  return keys;
}

GraphKeys load_graph_keys(const std::string& file) {
  check_curve();
  GraphKeys keys;
  std::istringstream lines(read_private_file(file));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t colon = line.find(": ");
    const std::string name = line.substr(0, colon);
    if (name != kPublicLine && name != kSecretLine) {
      fail(file, fmt::format("line {}: no such entry{}", number,
                             text::nearest_match_hint(name, {kPublicLine, kSecretLine})));
    }
    std::string& key = name == kPublicLine ? keys.public_key : keys.secret_key;
    if (!key.empty()) fail(file, fmt::format("line {}: {} a second time", number, name));
    key = colon == std::string::npos ? "" : line.substr(colon + 2);
    check_key(file, number, name, key);
  }
  for (const auto& [name, key] :
       {std::pair(kPublicLine, keys.public_key), std::pair(kSecretLine, keys.secret_key)}) {
    if (key.empty()) fail(file, std::string(name) + " is missing");
  }
  std::array<char, kKeyLength + 1> matching{};
  if (zmq_curve_public(matching.data(), keys.secret_key.c_str()) != 0 ||
      keys.public_key != matching.data()) {
    fail(file, "public_key and secret_key are no pair");
  }
  return keys;
}

std::optional<GraphKeys> find_graph_keys(const std::string& file) {
  if (!file.empty()) return load_graph_keys(file);
  const char* from_environment = std::getenv("PREHEND_KEYS");
  if (!from_environment || !*from_environment) return std::nullopt;
  return load_graph_keys(from_environment);
}

bool is_local_endpoint(const std::string& endpoint) {
  if (endpoint.starts_with("ipc://") || endpoint.starts_with("inproc://")) return true;
  if (!endpoint.starts_with("tcp://")) return false;
  const std::string host = host_of_tcp(endpoint);
  in_addr address = {};
  if (::inet_pton(AF_INET, host.c_str(), &address) == 1) {
    return (ntohl(address.s_addr) >> 24) == 127;
  }
  return host == "localhost" || host == "[::1]";
}

void check_endpoint_is_safe(const std::string& endpoint, bool has_keys) {
  const bool known = endpoint.starts_with("tcp://") || endpoint.starts_with("ipc://") ||
                     endpoint.starts_with("inproc://");
  if (!known) {
    throw std::runtime_error("endpoint '" + endpoint +
                             "': must begin with tcp:// or ipc://; an example is "
                             "tcp://127.0.0.1:11411");
  }
  if (has_keys || is_local_endpoint(endpoint)) return;
  throw std::runtime_error(
      "endpoint '" + endpoint +
      "' is beyond this host's loopback, and no keys are given: make them once "
      "with 'prehend keys create', copy the file to every host, and give "
      "--keys FILE or set PREHEND_KEYS");
}

}  // namespace prehend::graph
