#pragma once

#include <memory>
#include <string>

#include "drivers/wire/stream/byte_stream.h"

namespace prehend::drivers {

/// The device's end of an emulated line: "tcp:PORT" listens on loopback, anything else is the file
/// name under which a pseudo-terminal can be opened.
/// @throws geometry::InputError for a bad port, or as PseudoTerminal and TcpServer.
std::unique_ptr<ByteStream> make_emulated_line(const std::string& line);

}  // namespace prehend::drivers
