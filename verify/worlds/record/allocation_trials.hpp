// Trials of the recorder in which each allocation that it makes fails once. Allocations of the world, on the trials'
// own thread, do not count. Replaces `operator new`: for one source of a program.
#pragma once

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "record/crash_trials.hpp"
#include "threewe/record/recorder.hpp"

namespace threewe::record::trials {

inline std::atomic<long> left{-1};            ///< allocations until one fails; negative: none does
inline thread_local bool is_recorder = true;  ///< but where a trial says otherwise

/// Memory, unless this allocation is to fail.
inline void* allocate(std::size_t size) {
  if (is_recorder && left.load() >= 0 && left.fetch_sub(1) == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

// Out of line: compilers that see `free` after a `new` of their own take it for a mistake.
[[gnu::noinline]] inline void release(void* memory) noexcept { std::free(memory); }

}  // namespace threewe::record::trials

// All forms but the aligned ones: where some are replaced, sanitizers would call the others mismatched.
// NOLINTBEGIN(misc-definitions-in-headers): a replacement must not be inline
void* operator new(std::size_t size) { return threewe::record::trials::allocate(size); }
void* operator new[](std::size_t size) { return threewe::record::trials::allocate(size); }
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept { return std::malloc(size); }
void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept { return std::malloc(size); }
void operator delete(void* memory) noexcept { threewe::record::trials::release(memory); }
void operator delete[](void* memory) noexcept { threewe::record::trials::release(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { threewe::record::trials::release(memory); }
void operator delete[](void* memory, std::size_t /*size*/) noexcept { threewe::record::trials::release(memory); }
void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept { threewe::record::trials::release(memory); }
void operator delete[](void* memory, const std::nothrow_t& /*tag*/) noexcept {
  threewe::record::trials::release(memory);
}
// NOLINTEND(misc-definitions-in-headers)

namespace threewe::record::trials {

/// Whether the recorder's own work on this thread counts.
class Counting {
 public:
  explicit Counting(bool on) : before_(std::exchange(is_recorder, on)) {}
  ~Counting() { is_recorder = before_; }
  Counting(const Counting&) = delete;
  Counting& operator=(const Counting&) = delete;

 private:
  bool before_;
};

/// Records two episodes while allocation number `fails` fails (none: -1); what is wrong then. `made` counts
/// allocations.
inline std::string allocation_trial(World& world, long fails, long& made) {
  constexpr int kTicks = 30;
  constexpr long kNever = 1'000'000'000;
  const ScratchFolder folder;
  std::set<std::size_t> finished;
  {
    const Counting off(false);
    const auto begin = world.robot(0).observe([](const TickView&) { is_recorder = true; });
    std::uint64_t end = 0;
    std::optional<Recorder> recorder;
    RecorderOptions options;
    options.files = std::make_shared<UnsyncedFiles>();
    left = fails < 0 ? kNever : fails;
    try {
      {
        const Counting on(true);
        recorder.emplace(world, folder.path(), options);
      }
      end = world.robot(0).observe([](const TickView&) { is_recorder = false; });
      for (int i = 0; i < 2; ++i) {
        try {
          std::size_t number = 0;
          {
            const Counting on(true);
            number = recorder->start_episode("trial");
          }
          for (int t = 0; t < kTicks; ++t) world.tick();
          const Counting on(true);
          recorder->end_episode(true);
          finished.insert(number);
        } catch (const RecordingError&) {
        } catch (const std::bad_alloc&) {
          if (recorder->recording()) recorder->end_episode(true);  // which can be asked for again
        }
      }
    } catch (const RecordingError&) {
    } catch (const std::bad_alloc&) {
    } catch (const std::system_error&) {  // no thread could be made
    }
    is_recorder = false;
    recorder.reset();
    made = kNever - left;
    left = -1;
    world.robot(0).unobserve(begin);
    world.robot(0).unobserve(end);
  }
  if (fails < 0 && finished.size() != 2) return "without a failure there are not two episodes";
  (void)recover(folder.path(), std::make_shared<UnsyncedFiles>());
  std::set<std::size_t> there;
  for (const auto& file : journals(folder.path())) there.insert(Journal::open(file).episode());
  for (const std::size_t number : finished) {
    if (!there.contains(number)) return fmt::format("episode {} is not there", number);
  }
  return {};
}

}  // namespace threewe::record::trials
