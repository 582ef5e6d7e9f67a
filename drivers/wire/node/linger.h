#pragma once

#include <chrono>
#include <thread>

namespace prehend::drivers {

/// At the end of an emulator's node: its device answers for a little longer, as a real one outlives
/// the graph, so that drivers which end at the same moment can say goodbye to it.
inline void linger() { std::this_thread::sleep_for(std::chrono::milliseconds(700)); }

}  // namespace prehend::drivers
