#include "env/workers.hpp"

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "threewe/core/errors.hpp"

namespace threewe::env {

// The threads, and what they share.
struct Workers::Crew {
  explicit Crew(std::size_t count) : errors(count) {}
  ~Crew();

  void serve(std::size_t part);
  void do_part(std::size_t part);

  std::mutex mutex;
  std::condition_variable go;
  std::condition_variable done;
  const std::function<void(std::size_t, std::size_t, std::size_t)>* work = nullptr;
  std::size_t range = 0;
  std::uint64_t round = 0;
  std::size_t busy = 0;
  bool over = false;
  std::vector<std::exception_ptr> errors;  // by part
  std::vector<std::thread> threads;
};

Workers::Workers(std::size_t threads) : process_(getpid()), crew_(std::make_unique<Crew>(threads)) {
  Crew& crew = *crew_;
  crew.threads.reserve(threads - 1);
  try {
    for (std::size_t part = 1; part < threads; ++part) {
      crew.threads.emplace_back([&crew, part] { crew.serve(part); });
    }
  } catch (const std::system_error&) {
    throw ConfigError(
        fmt::format("num_threads: the system gives {} threads here, and not {}", crew.threads.size() + 1, threads));
  }
}

// A forked process has a copy of what the threads share but not the threads, for which any end would wait.
Workers::~Workers() {
  if (getpid() == process_) return;
  [[maybe_unused]] const Crew* const left_as_it_is = crew_.release();
}

void Workers::run(std::size_t count, const std::function<void(std::size_t, std::size_t, std::size_t)>& work) {
  Crew& crew = *crew_;
  if (!crew.threads.empty() && getpid() != process_) {
    throw ContractError(
        "this batch was made before the process was forked, and its threads stayed behind: make environments in the "
        "process that steps them, or with num_threads=1");
  }
  {
    const std::scoped_lock lock(crew.mutex);
    crew.work = &work;
    crew.range = count;
    crew.busy = crew.threads.size();
    ++crew.round;
  }
  crew.go.notify_all();
  crew.do_part(0);
  std::unique_lock lock(crew.mutex);
  crew.done.wait(lock, [&crew] { return crew.busy == 0; });
  for (std::exception_ptr& error : crew.errors) {
    if (error) std::rethrow_exception(std::exchange(error, nullptr));
  }
}

Workers::Crew::~Crew() {
  {
    const std::scoped_lock lock(mutex);
    over = true;
  }
  go.notify_all();
  for (std::thread& thread : threads) thread.join();
}

void Workers::Crew::serve(std::size_t part) {
  std::uint64_t served = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex);
      go.wait(lock, [&] { return over || round != served; });
      if (over) return;
      served = round;
    }
    do_part(part);
    const std::scoped_lock lock(mutex);
    if (--busy == 0) done.notify_one();
  }
}

void Workers::Crew::do_part(std::size_t part) {
  const std::size_t begin = range * part / errors.size();
  const std::size_t end = range * (part + 1) / errors.size();
  try {
    if (begin < end) (*work)(part, begin, end);
  } catch (...) {
    errors[part] = std::current_exception();
  }
}

}  // namespace threewe::env
