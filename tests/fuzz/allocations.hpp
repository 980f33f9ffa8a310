// Counter of the bytes that are allocated.
#pragma once

#include <atomic>
#include <cstddef>

namespace threewe::fuzz {

/// Bytes that are allocated now, and the most there were since the last input began.
inline std::atomic<std::ptrdiff_t> held_bytes{0};
inline std::atomic<std::ptrdiff_t> most_held_bytes{0};

/// Starts counting, once; false if that is impossible.
bool count_allocations();

inline void allocated(std::size_t size) {
  const std::ptrdiff_t now = held_bytes += static_cast<std::ptrdiff_t>(size);
  if (now > most_held_bytes) most_held_bytes = now;
}
inline void released(std::size_t size) { held_bytes -= static_cast<std::ptrdiff_t>(size); }

}  // namespace threewe::fuzz
