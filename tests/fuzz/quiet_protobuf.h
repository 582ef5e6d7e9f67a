#pragma once

#include <google/protobuf/stubs/logging.h>

namespace prehend::fuzz {

/// Protobuf writes a line about every damaged text field; a fuzzer makes millions.
inline void quiet_protobuf() {
  static auto* const before = google::protobuf::SetLogHandler(nullptr);
  static_cast<void>(before);
}

}  // namespace prehend::fuzz
