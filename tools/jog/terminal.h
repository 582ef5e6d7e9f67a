#pragma once

#include <optional>
#include <vector>

#include "prehend/control/jog_session.h"
#include "tools/jog/panel.h"

namespace prehend::tools {

/// The whole screen of a terminal, by ncurses; given back when it goes. One at a time.
class Terminal {
 public:
  /// @throws std::runtime_error when standard input or output is no terminal, or it cannot place
  /// its cursor.
  static void check();
  /// @throws as check().
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Waits for keys, at most `seconds`; those that came. What the terminal says of itself is none.
  std::vector<control::JogKey> keys(double seconds);
  /// False once the terminal is gone.
  bool is_there() const { return is_there_; }
  int width() const;
  int height() const;
  void show(const std::vector<PanelLine>& lines);

 private:
  bool is_there_ = true;
  bool has_colours_ = false;
  int errors_ = -1;  // standard error as it was
};

}  // namespace prehend::tools
