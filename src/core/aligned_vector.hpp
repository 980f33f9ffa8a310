// Vector that begins where a line of the cache does, for kernels: a load of a whole SIMD vector then never spans two.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace threewe {

inline constexpr std::align_val_t kCacheLine{64};

/// Allocates memory that begins at a line of the cache.
template <class T>
struct AlignedAllocator {
  using value_type = T;

  AlignedAllocator() = default;
  template <class Other>
  AlignedAllocator(const AlignedAllocator<Other>&) {}  // NOLINT(misc-explicit-constructor): containers convert it

  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kCacheLine)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kCacheLine); }

  friend bool operator==(const AlignedAllocator&, const AlignedAllocator&) { return true; }
};

template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

}  // namespace threewe
