#include "tools/jog/terminal.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

// Macros named like what others use (move, erase, ...) stay out.
#define NCURSES_NOMACROS 1
#include <curses.h>
#include <term.h>
#undef lines
#undef columns
#undef newline

namespace prehend::tools {
namespace {

using control::JogKey;

constexpr int kEscapeDelay = 50;  // ms: so long after ESC the rest of an arrow key may come
constexpr short kRed = 1;

// A key, or nothing: the terminal's size changed.
std::optional<JogKey> key_of(int code) {
  switch (code) {
    case KEY_UP:
      return JogKey::kPrevious;
    case KEY_DOWN:
      return JogKey::kNext;
    case KEY_RIGHT:
      return JogKey::kPlus;
    case KEY_LEFT:
      return JogKey::kMinus;
    case KEY_RESIZE:
      return std::nullopt;
    default:
      return control::jog_key(code);
  }
}

}  // namespace

void Terminal::check() {
  if (::isatty(STDIN_FILENO) != 1 || ::isatty(STDOUT_FILENO) != 1) {
    throw std::runtime_error(
        "standard input and output must be a terminal: keys move the robot. Over ssh: ssh -t");
  }
  const char* name = std::getenv("TERM");
  int status = 0;
  if (!name || !*name || ::setupterm(name, STDOUT_FILENO, &status) != OK) {
    throw std::runtime_error(std::string("the terminal '") + (name ? name : "") +
                             "' (TERM) is not known here; try TERM=xterm, or install ncurses-term");
  }
  const char* cursor = ::tigetstr("cup");
  if (!cursor || cursor == reinterpret_cast<char*>(-1)) {
    throw std::runtime_error(std::string("the terminal '") + name +
                             "' (TERM) cannot place its cursor; prehend jog needs one that can, as "
                             "xterm, screen, tmux or linux");
  }
}

Terminal::Terminal() {
  check();
  ::set_escdelay(kEscapeDelay);
  if (!::newterm(nullptr, stdout, stdin)) {
    throw std::runtime_error("the terminal cannot be set up");
  }
  ::cbreak();  // Ctrl-C stays a signal, which ends
  ::noecho();
  ::nonl();
  ::keypad(stdscr, TRUE);
  ::nodelay(stdscr, TRUE);
  // Arrow keys in either mode of the keypad: one that is not known would begin with Escape.
  for (const auto& [name, code] :
       {std::pair{'A', KEY_UP}, {'B', KEY_DOWN}, {'C', KEY_RIGHT}, {'D', KEY_LEFT}}) {
    for (const char* before : {"\x1b[", "\x1bO"}) {
      ::define_key((std::string(before) + name).c_str(), code);
    }
  }
  ::curs_set(0);
  // What this program's node says comes by /log, too; on standard error it would tear the screen.
  errors_ = ::dup(STDERR_FILENO);
  if (const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0) {
    ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
  }
  // A suspended program would stop commanding, but could not say so.
  ::signal(SIGTSTP, SIG_IGN);
  has_colours_ = ::has_colors() && ::start_color() == OK;
  if (has_colours_) {
    ::use_default_colors();
    ::init_pair(kRed, COLOR_RED, -1);
  }
}

Terminal::~Terminal() {
  ::endwin();
  if (errors_ >= 0) {
    ::dup2(errors_, STDERR_FILENO);
    ::close(errors_);
  }
}

std::vector<JogKey> Terminal::keys(double seconds) {
  if (!is_there_) {
    std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, seconds)));
    return {};
  }
  pollfd input{STDIN_FILENO, POLLIN, 0};
  ::poll(&input, 1, seconds > 0 ? static_cast<int>(seconds * 1000 + 0.5) : 0);
  if (input.revents & (POLLHUP | POLLERR | POLLNVAL)) is_there_ = false;
  std::vector<JogKey> keys;
  for (int code = ::wgetch(stdscr); code != ERR; code = ::wgetch(stdscr)) {
    if (const auto key = key_of(code)) keys.push_back(*key);
  }
  return keys;
}

int Terminal::width() const { return ::getmaxx(stdscr); }
int Terminal::height() const { return ::getmaxy(stdscr); }

void Terminal::show(const std::vector<PanelLine>& shown) {
  ::werase(stdscr);
  int row = 0;
  for (const PanelLine& line : shown) {
    attr_t look = A_NORMAL;
    short colour = 0;
    switch (line.look) {
      case PanelLook::kPlain:
        break;
      case PanelLook::kTitle:
        look = A_BOLD;
        break;
      case PanelLook::kChosen:
        look = A_REVERSE;
        break;
      case PanelLook::kNear:
        look = A_BOLD;
        colour = kRed;
        break;
      case PanelLook::kAlarm:
        look = A_REVERSE | A_BOLD;
        colour = kRed;
        break;
    }
    ::wattr_set(stdscr, look, has_colours_ ? colour : short{0}, nullptr);
    ::mvwaddstr(stdscr, row++, 0, line.text.c_str());
  }
  ::wattr_set(stdscr, A_NORMAL, 0, nullptr);
  ::wrefresh(stdscr);
}

}  // namespace prehend::tools
