#pragma once

#include <string>

namespace prehend::drivers::kuka_rsi {

/// Asks for what keeps the calling thread on time beside other programs: first-in-first-out
/// scheduling with `priority` (1 to 99), and the whole process's memory never swapped out, touched
/// or not. @return what was not granted and the mend, in words; empty where all was.
std::string ask_for_real_time(int priority);

}  // namespace prehend::drivers::kuka_rsi
