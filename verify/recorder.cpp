// recorder kills SEED COUNT, recorder power SEED DISKS, recorder faults, recorder allocations PART PARTS: prints what
// went wrong, a line each, then how many trials there were.
#include <cstdio>
#include <cstring>

#include "number.hpp"
#include "record/allocation_trials.hpp"

namespace {

using namespace threewe::record;

void report(const std::string& wrong) {
  if (!wrong.empty()) std::printf("%s\n", wrong.c_str());
}

int kill_trials(threewe::World& world, std::uint64_t seed, std::uint64_t count) {
  for (std::uint64_t i = 0; i < count; ++i) report(trials::kill_trial(world, seed + i));
  return static_cast<int>(count);
}

int fault_trials(threewe::World& world) {
  int calls = 0;
  report(trials::fault_trial(world, -1, EIO, calls));
  int done = 0;
  for (int call = 0; call < calls; ++call) {
    for (const int error : {ENOSPC, EIO, 0}) {
      int ignored = 0;
      const std::string wrong = trials::fault_trial(world, call, error, ignored);
      report(wrong.empty() ? "" : fmt::format("call {}, error {}: {}", call, error, wrong));
      ++done;
    }
  }
  return done;
}

// Every `parts`-th of the allocations, from number `part` on.
int allocation_trials(threewe::World& world, std::uint64_t part, std::uint64_t parts) {
  const auto warnings = threewe::set_warning_handler([](std::string_view) {});
  long count = 0;
  report(trials::allocation_trial(world, -1, count));
  int done = 0;
  for (auto fails = static_cast<long>(part); fails < count; fails += static_cast<long>(parts), ++done) {
    long ignored = 0;
    const std::string wrong = trials::allocation_trial(world, fails, ignored);
    report(wrong.empty() ? "" : fmt::format("allocation {}: {}", fails, wrong));
  }
  (void)threewe::set_warning_handler(warnings);
  return done;
}

}  // namespace

int main(int count, char** words) {
  const auto number = [&](int i) { return i < count ? threewe::parse_number(words[i]) : std::nullopt; };
  const std::string_view what = count > 1 ? words[1] : "";
  const auto world = trials::make_world();
  int done = 0;
  if (what == "kills" && number(2) && number(3)) {
    done = kill_trials(*world, *number(2), *number(3));
  } else if (what == "power" && number(2) && number(3)) {
    report(trials::power_cut_trial(*world, *number(2), static_cast<int>(*number(3)), done));
  } else if (what == "faults") {
    done = fault_trials(*world);
  } else if (what == "allocations" && number(2) && number(3).value_or(0) > 0) {
    done = allocation_trials(*world, *number(2), *number(3));
  } else {
    std::fprintf(stderr, "recorder kills SEED COUNT | power SEED DISKS | faults | allocations PART PARTS\n");
    return 2;
  }
  std::printf("trials %d\n", done);
}
