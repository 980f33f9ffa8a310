#include "env/workers.hpp"

#include <utility>

namespace threewe::env {

Workers::Workers(std::size_t threads) : errors_(threads) {
  for (std::size_t part = 1; part < threads; ++part) threads_.emplace_back([this, part] { serve(part); });
}

Workers::~Workers() {
  {
    const std::scoped_lock lock(mutex_);
    over_ = true;
  }
  go_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void Workers::run(std::size_t count, const std::function<void(std::size_t, std::size_t, std::size_t)>& work) {
  {
    const std::scoped_lock lock(mutex_);
    work_ = &work;
    range_ = count;
    busy_ = threads_.size();
    ++round_;
  }
  go_.notify_all();
  do_part(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
  for (std::exception_ptr& error : errors_) {
    if (error) std::rethrow_exception(std::exchange(error, nullptr));
  }
}

void Workers::serve(std::size_t part) {
  std::uint64_t served = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      go_.wait(lock, [&] { return over_ || round_ != served; });
      if (over_) return;
      served = round_;
    }
    do_part(part);
    const std::scoped_lock lock(mutex_);
    if (--busy_ == 0) done_.notify_one();
  }
}

void Workers::do_part(std::size_t part) {
  const std::size_t begin = range_ * part / errors_.size();
  const std::size_t end = range_ * (part + 1) / errors_.size();
  try {
    if (begin < end) (*work_)(part, begin, end);
  } catch (...) {
    errors_[part] = std::current_exception();
  }
}

}  // namespace threewe::env
