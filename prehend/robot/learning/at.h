#pragma once

#include <cstddef>

namespace prehend::robot::learning {

/// An index, which is not negative here, for a container.
inline std::size_t at(int index) { return static_cast<std::size_t>(index); }

}  // namespace prehend::robot::learning
