// Threads that share the work of a batch.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace threewe::env {

/// Calls a function for consecutive parts of a range, on threads that live as long as this; the caller's is one of
/// them.
class Workers {
 public:
  explicit Workers(std::size_t threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// `work(part, begin, end)` for `threads` parts of [0, count). Returns when all are done; rethrows the first part's
  /// exception.
  void run(std::size_t count, const std::function<void(std::size_t part, std::size_t begin, std::size_t end)>& work);
  std::size_t count() const { return errors_.size(); }

 private:
  void serve(std::size_t part);
  void do_part(std::size_t part);

  std::mutex mutex_;
  std::condition_variable go_;
  std::condition_variable done_;
  const std::function<void(std::size_t, std::size_t, std::size_t)>* work_ = nullptr;
  std::size_t range_ = 0;
  std::uint64_t round_ = 0;
  std::size_t busy_ = 0;
  bool over_ = false;
  std::vector<std::exception_ptr> errors_;  // by part
  std::vector<std::thread> threads_;
};

}  // namespace threewe::env
