// Counts what `new` allocates, without sanitizers: nearly all. Allocations of C libraries count in the sanitized tree.
#include "allocations.hpp"

#include <malloc.h>

#include <cstdlib>
#include <new>

namespace {

void* counted(void* pointer) {
  if (pointer == nullptr) throw std::bad_alloc();
  threewe::fuzz::allocated(malloc_usable_size(pointer));
  return pointer;
}

void release(void* pointer) {
  threewe::fuzz::released(malloc_usable_size(pointer));
  std::free(pointer);
}

}  // namespace

// the other forms of new and delete call these
void* operator new(std::size_t size) { return counted(std::malloc(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(std::aligned_alloc(static_cast<std::size_t>(alignment), size));
}
void operator delete(void* pointer) noexcept { release(pointer); }
void operator delete(void* pointer, std::size_t) noexcept { release(pointer); }
void operator delete(void* pointer, std::align_val_t) noexcept { release(pointer); }
void operator delete(void* pointer, std::size_t, std::align_val_t) noexcept { release(pointer); }

bool threewe::fuzz::count_allocations() { return true; }
