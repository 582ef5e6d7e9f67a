#pragma once

#include <string>

#include "prehend/recording/mcap_records.h"

namespace prehend {

/// Metadata record of a recording that says what it was made by.
inline constexpr const char* kRunMetadata = "prehend.run";

/// Name of this host, command line and working directory of this process, the git revision of that
/// folder (with "-dirty" when files differ from it; absent where it is no git tree), and the wall
/// time. Waits at most 2 s for git.
recording::McapMetadata run_facts();

/// The file as it is now, named by its file name. Throws std::runtime_error when it cannot be read.
recording::McapAttachment attachment_of(const std::string& path);

}  // namespace prehend
