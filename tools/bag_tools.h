#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace prehend::tools {

// What `prehend bag ...` does; each returns the exit code and throws std::exception with one clear
// line when it cannot do it.

/// Prints what a recording holds.
int bag_info(const std::string& path, bool json);

/// Prints what is wrong with a recording; 1 when anything is.
int bag_check(const std::string& path, bool json);

/// Copies what can be read of `from` to the new file `to`.
int bag_recover(const std::string& from, const std::string& to);

struct BagFilter {
  std::string from, to;
  std::vector<std::string> topics, without;  ///< patterns; no topics: all
  std::string start, end;                    ///< durations after its beginning, with unit; empty
  std::string compression = "lz4";
};
/// Copies a part of a recording to a new file. What was latched before the start is kept, at the
/// start.
int bag_filter(const BagFilter& filter);

/// Lists the attachments, or writes them (or the one named) to a folder.
int bag_attachments(const std::string& path, const std::string& folder, const std::string& name);

}  // namespace prehend::tools
