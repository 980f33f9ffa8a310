// Refuses a second thread for as long as the first is at work.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

#include "threewe/core/errors.hpp"

namespace threewe::env {

/// One call at a time: what several threads call without taking turns is refused, and not spoilt.
class ExclusiveUse {
 public:
  /// For as long as this lives. Throws ContractError naming the `call` where another one is going on.
  ExclusiveUse(std::atomic<bool>& busy, std::string_view call) : busy_(busy) {
    if (busy_.exchange(true, std::memory_order_acquire)) {
      throw ContractError(std::string(call) +
                          "() while another thread is in a call of the same environment; give each thread an "
                          "environment of its own, or a lock to share");
    }
  }
  ~ExclusiveUse() { busy_.store(false, std::memory_order_release); }
  ExclusiveUse(const ExclusiveUse&) = delete;
  ExclusiveUse& operator=(const ExclusiveUse&) = delete;

 private:
  std::atomic<bool>& busy_;
};

}  // namespace threewe::env
