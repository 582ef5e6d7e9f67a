#include "drivers/wire/stream/emulated_line.h"

#include <charconv>
#include <cstdint>
#include <string_view>

#include "drivers/wire/stream/pseudo_terminal.h"
#include "drivers/wire/stream/tcp_server.h"
#include "prehend/geometry/errors.h"

namespace prehend::drivers {

std::unique_ptr<ByteStream> make_emulated_line(const std::string& line) {
  constexpr std::string_view kTcp = "tcp:";
  if (!line.starts_with(kTcp)) return std::make_unique<PseudoTerminal>(line);
  std::uint16_t port = 0;
  const char* end = line.data() + line.size();
  const auto result = std::from_chars(line.data() + kTcp.size(), end, port);
  if (result.ec != std::errc{} || result.ptr != end) {
    throw geometry::InputError("'" + line + "' names no port", "Write tcp:PORT");
  }
  return std::make_unique<TcpServer>(port);
}

}  // namespace prehend::drivers
