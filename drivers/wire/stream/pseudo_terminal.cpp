#include "drivers/wire/stream/pseudo_terminal.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <thread>

#include "prehend/geometry/errors.h"

namespace prehend::drivers {

struct PseudoTerminal::Line {
  int master = -1;
  int slave = -1;  // held open, so that the line outlives a driver that closes it
  std::string name;

  Line() = default;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  ~Line() {
    for (const int descriptor : {slave, master}) {
      if (descriptor >= 0) ::close(descriptor);
    }
  }
};

PseudoTerminal::PseudoTerminal(std::string link) : link_(std::move(link)) { plug(); }

PseudoTerminal::~PseudoTerminal() { unplug(); }

void PseudoTerminal::plug() {
  if (plugged()) return;
  const auto fail = [](const std::string& what, const char* mend, int code = errno) {
    throw geometry::InputError(what + ": " + std::strerror(code), mend);
  };
  auto line = std::make_shared<Line>();
  line->master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 64> name{};
  if (line->master < 0 || ::grantpt(line->master) != 0 || ::unlockpt(line->master) != 0 ||
      ::ptsname_r(line->master, name.data(), name.size()) != 0) {
    fail("no pseudo-terminal can be opened", "Mount devpts, or close other terminals");
  }
  line->name = name.data();
  line->slave = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  if (line->slave < 0 || ::tcgetattr(line->slave, &settings) != 0) {
    fail("cannot open " + line->name, "Check the permissions of /dev/pts");
  }
  ::cfmakeraw(&settings);
  ::tcsetattr(line->slave, TCSANOW, &settings);
  if (!link_.empty()) {
    std::error_code error;
    if (std::filesystem::is_symlink(link_, error)) std::filesystem::remove(link_, error);
    std::filesystem::create_symlink(line->name, link_, error);
    if (error) {
      fail("cannot make the link " + link_, "Name one in a folder where you may write",
           error.value());
    }
  }
  const std::lock_guard lock(mutex_);
  if (first_name_.empty()) first_name_ = line->name;
  line_ = std::move(line);
}

void PseudoTerminal::unplug() {
  std::shared_ptr<const Line> line;
  {
    const std::lock_guard lock(mutex_);
    line = std::move(line_);
    line_ = nullptr;
  }
  if (!line || link_.empty()) return;
  std::error_code ignored;
  if (std::filesystem::read_symlink(link_, ignored) == line->name) {
    std::filesystem::remove(link_, ignored);
  }
}

unsigned PseudoTerminal::baud() const {
  struct Rate {
    speed_t code;
    unsigned baud;
  };
  constexpr Rate kRates[] = {{B600, 600},     {B1200, 1200},   {B2400, 2400},
                             {B4800, 4800},   {B9600, 9600},   {B19200, 19200},
                             {B38400, 38400}, {B57600, 57600}, {B115200, 115200}};
  const auto line = line_now();
  termios settings{};
  if (!line || ::tcgetattr(line->slave, &settings) != 0) return 0;
  const speed_t code = ::cfgetospeed(&settings);
  for (const Rate& rate : kRates) {
    if (rate.code == code) return rate.baud;
  }
  return 0;
}

IoResult PseudoTerminal::read(std::span<std::uint8_t> buffer, std::chrono::nanoseconds timeout) {
  if (const auto line = line_now()) return read_descriptor(line->master, buffer, timeout);
  std::this_thread::sleep_for(timeout);
  return {};
}

IoResult PseudoTerminal::write(Bytes bytes, std::chrono::nanoseconds timeout) {
  if (const auto line = line_now()) return write_descriptor(line->master, bytes, timeout);
  return {IoStatus::kOk, bytes.size(), {}};
}

}  // namespace prehend::drivers
