// Thread pool that shares the work of a batch.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include <sys/types.h>

namespace threewe::env {

/// Calls a function for consecutive parts of a range, on threads that live as long as this; the caller's is one of
/// them.
class Workers {
 public:
  /// Throws ConfigError where the system gives fewer threads.
  explicit Workers(std::size_t threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// `work(part, begin, end)` for `threads` parts of [0, count). Returns when all are done; rethrows the first part's
  /// exception. Throws ContractError in a process forked since, which has no such threads.
  void run(std::size_t count, const std::function<void(std::size_t part, std::size_t begin, std::size_t end)>& work);

 private:
  struct Crew;

  pid_t process_;  // whose threads they are
  std::unique_ptr<Crew> crew_;
};

}  // namespace threewe::env
