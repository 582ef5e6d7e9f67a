#pragma once

#include <string>

// The names of a recording's file over its life. While it is written it is NAME.partial; once it is
// whole and closed it becomes NAME, and what was NAME before becomes NAME.1. So nobody who starts a
// recorder by mistake, or whose recorder is killed, loses the recording before.
namespace prehend::recording {

/// "NAME.partial".
std::string partial_path(const std::string& path);

/// Makes way for a new recording of that name. A partial one that a killed recorder left is moved
/// to NAME.partial.1, .2, ..., never overwritten. Returns what it was moved to; "" when there was
/// none. Throws McapError when `path` is something else than a file, or another process is writing
/// it.
std::string make_way(const std::string& path);

/// What has that name becomes NAME.1, instead of what had that name; does nothing when there is no
/// such file. Throws McapError, which ends with `otherwise`.
void set_aside(const std::string& path, const std::string& otherwise = "");

/// The partial recording is whole: gives it its name, and sets aside the one before. Throws
/// McapError, naming where the recording is, when it cannot be renamed.
void give_name(const std::string& path);

}  // namespace prehend::recording
