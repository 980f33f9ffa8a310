// What a clock of the system says.
#pragma once

#include <ctime>

/// [s] by CLOCK_MONOTONIC, or what this process or thread has computed by CLOCK_PROCESS_CPUTIME_ID or
/// CLOCK_THREAD_CPUTIME_ID.
inline double seconds_by(clockid_t clock) {
  std::timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
