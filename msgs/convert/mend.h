#pragma once

namespace prehend::convert {

/// How to mend what a well-behaved sender never sends.
inline constexpr const char* kSenderMend = "Mend or update the node that published it";

}  // namespace prehend::convert
