// Counts every allocation, by the hooks of the address sanitizer.
#include "allocations.hpp"

// g++ brings these functions without their header
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));
extern "C" std::size_t __sanitizer_get_allocated_size(const volatile void*);

namespace threewe::fuzz {

bool count_allocations() {
  const auto on_malloc = [](const volatile void*, std::size_t size) { allocated(size); };
  const auto on_free = [](const volatile void* pointer) {
    if (pointer != nullptr) released(__sanitizer_get_allocated_size(pointer));
  };
  static const bool hooked = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free) != 0;
  return hooked;
}

}  // namespace threewe::fuzz
