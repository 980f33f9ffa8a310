// Each allocation that the recorder makes fails once. Allocations of the world, on the test's own thread, do not count.
#include <array>
#include <atomic>
#include <cstdlib>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "record/crash_trials.hpp"
#include "threewe/record/recorder.hpp"

namespace {

std::atomic<long> left{-1};            // allocations until one fails; negative: none does
thread_local bool is_recorder = true;  // but where the test says otherwise

void* allocate(std::size_t size) {
  if (is_recorder && left.load() >= 0 && left.fetch_sub(1) == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

// All forms but the aligned ones: where some are replaced, sanitizers would call the others mismatched.
void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept { return std::malloc(size); }
void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept { return std::malloc(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t& /*tag*/) noexcept { std::free(memory); }

namespace {

using namespace threewe;
using namespace threewe::record;

// Whether the recorder's own work on this thread counts.
class Counting {
 public:
  explicit Counting(bool on) : before_(std::exchange(is_recorder, on)) {}
  ~Counting() { is_recorder = before_; }
  Counting(const Counting&) = delete;
  Counting& operator=(const Counting&) = delete;

 private:
  bool before_;
};

// Records two episodes while allocation number `fails` fails; what is wrong then. `made` counts allocations.
std::string trial(World& world, long fails, long& made) {
  constexpr int kTicks = 30;
  constexpr long kNever = 1'000'000'000;
  const trials::ScratchFolder folder;
  std::set<std::size_t> finished;
  {
    const Counting off(false);
    const auto begin = world.robot(0).observe([](const TickView&) { is_recorder = true; });
    std::uint64_t end = 0;
    std::optional<Recorder> recorder;
    RecorderOptions options;
    options.files = std::make_shared<trials::UnsyncedFiles>();
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
  (void)recover(folder.path(), std::make_shared<trials::UnsyncedFiles>());
  std::set<std::size_t> there;
  for (const auto& file : journals(folder.path())) there.insert(Journal::open(file).episode());
  for (const std::size_t number : finished) {
    if (!there.contains(number)) return fmt::format("episode {} is not there", number);
  }
  return {};
}

}  // namespace

TEST_CASE("each allocation that fails once is an error, and finished episodes stay readable") {
  const auto world = trials::make_world();
  const auto warnings = set_warning_handler([](std::string_view) {});
  long count = 0;
  CHECK(trial(*world, -1, count).empty());
  REQUIRE(count > 100);
  for (long fails = 0; fails < count; fails += 1 + static_cast<long>(count / 400)) {
    long ignored = 0;
    const std::string wrong = trial(*world, fails, ignored);
    CHECK_MESSAGE(wrong.empty(), "allocation ", fails, ": ", wrong);
  }
  (void)set_warning_handler(warnings);
}
