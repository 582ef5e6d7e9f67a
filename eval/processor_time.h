#pragma once

namespace prehend::eval {

/// Processor time of all threads of this process [s].
double processor_time();

}  // namespace prehend::eval
