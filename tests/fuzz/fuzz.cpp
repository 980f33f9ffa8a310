#include "fuzz.hpp"

#include <sys/time.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "allocations.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::fuzz {
namespace {

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "fuzz: %s\n", what);
  std::abort();
}

// While it lives, the process may compute for so long: other processes may keep it waiting.
class Limit {
 public:
  Limit() {
    std::signal(SIGPROF, [](int) { fail("computes for more than 5 s"); });
    set(kTimeLimit);
  }
  ~Limit() { set(0); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

 private:
  static void set(int seconds) {
    itimerval timer{};
    timer.it_value.tv_sec = seconds;
    setitimer(ITIMER_PROF, &timer, nullptr);
  }
};

}  // namespace

std::map<std::string, Fuzzer>& fuzzers() {
  static std::map<std::string, Fuzzer> of_format;
  return of_format;
}

void read(std::string_view input, const std::function<void()>& reader, std::size_t free_memory, std::size_t per_byte) {
  if (!count_allocations()) fail("memory cannot be counted");
  const std::ptrdiff_t before = held_bytes;
  most_held_bytes = before;
  const Limit limit;
  try {
    reader();
  } catch (const std::exception& error) {
    const bool refused = dynamic_cast<const ConfigError*>(&error) != nullptr;
    if (!refused) fail(error.what());
  }
  const auto taken = static_cast<std::size_t>(most_held_bytes - before);
  if (taken > free_memory + per_byte * input.size()) {
    std::fprintf(stderr, "fuzz: %zu bytes of memory for an input of %zu\n", taken, input.size());
    std::abort();
  }
}

const std::filesystem::path& folder() {
  static const std::filesystem::path own = [] {
    const auto path = std::filesystem::path("/dev/shm") / ("threewe_fuzz_" + std::to_string(::getpid()));
    std::filesystem::create_directories(path);
    static const struct Cleaner {
      std::filesystem::path path;
      ~Cleaner() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
      }
    } cleaner{path};
    return path;
  }();
  return own;
}

void write(const std::filesystem::path& file, std::string_view content) {
  std::ofstream(file, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
}

}  // namespace threewe::fuzz
