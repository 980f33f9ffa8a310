// Replay of the fuzzers without libFuzzer: each reads the seeds of its format and hundreds of changed copies of them.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fuzz.hpp"
#include "mutation.hpp"
#include "threewe/core/errors.hpp"

namespace {

using namespace threewe;

// Changed inputs of a format, so that all take 10 s together: fewer where one takes milliseconds.
constexpr std::size_t kChangedInputs = 5000;
const std::map<std::string, std::size_t> kChangedInputsOfSlow = {
    {"lexicon", 200}, {"log", 300}, {"object", 1000}, {"profile", 1000}, {"scene", 250}};
constexpr unsigned kWallLimit = 120;  // [s] for one input, which other processes may keep waiting

struct Seed {
  std::string name;
  std::string bytes;
};

std::vector<Seed> read_seeds(const std::string& format) {
  std::vector<Seed> seeds;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(CORPUS) / format)) {
    if (!entry.is_regular_file()) continue;
    std::ostringstream bytes;
    bytes << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    seeds.push_back({entry.path().filename(), bytes.str()});
  }
  std::ranges::sort(seeds, {}, &Seed::name);
  return seeds;
}

// The seeds come first, as they are; then changed copies, which are the same in every run.
std::string make_input(const std::vector<Seed>& seeds, std::size_t number) {
  std::string bytes = seeds[number % seeds.size()].bytes;
  if (number < seeds.size()) return bytes;
  constexpr std::array kChanges = {1, 1, 2, 4};
  std::mt19937 random(static_cast<unsigned>(number));
  for (int left = kChanges[random() % kChanges.size()]; left > 0; --left) {
    const bool as_text = random() % 3 != 0;
    bytes = (as_text ? fuzz::change_text : fuzz::change_bytes)(bytes, static_cast<unsigned>(random()));
  }
  return bytes;
}

// Lets a child process read the first inputs of a format; its wait status, and the number of the last input.
std::pair<int, std::size_t> read_in_child(fuzz::Fuzzer fuzzer, const std::vector<Seed>& seeds, std::size_t count) {
  void* const shared = ::mmap(nullptr, sizeof(std::size_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  REQUIRE(shared != MAP_FAILED);
  auto& number = *static_cast<std::size_t*>(shared);
  (void)fuzz::folder();  // of this process, which outlives its children and removes it
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGILL}) std::signal(signal, SIG_DFL);  // doctest's report them
    for (; number < count; ++number) {
      ::alarm(kWallLimit);
      const std::string input = make_input(seeds, number);
      const std::vector<char> exact(input.begin(), input.end());  // the sanitizer sees a byte more that is read
      fuzzer({exact.data(), exact.size()});
    }
    ::_exit(0);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  const std::size_t last = number;
  ::munmap(shared, sizeof(std::size_t));
  return {status, last};
}

void replay(const std::string& format, fuzz::Fuzzer fuzzer) {
  const std::vector<Seed> seeds = read_seeds(format);
  REQUIRE(!seeds.empty());
  const auto slow = kChangedInputsOfSlow.find(format);
  const std::size_t changed = slow == kChangedInputsOfSlow.end() ? kChangedInputs : slow->second;
  const auto [status, number] = read_in_child(fuzzer, seeds, seeds.size() + changed);
  if (status == 0) return;
  const std::string& seed = seeds[number % seeds.size()].name;
  const auto kept = std::filesystem::temp_directory_path() / fmt::format("{}_{}_{}", format, seed, number);
  fuzz::write(kept, make_input(seeds, number));
  const std::string end =
      WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status)) : fmt::format("status {}", WEXITSTATUS(status));
  FAIL_CHECK(fmt::format("{}: input {}, {}seed {}: {}; kept in {}", format, number,
                         number < seeds.size() ? "" : "changed from ", seed, end, kept.string()));
}

// Readers of a test, which do so where an input is not empty.
void refuse(std::string_view input) {
  fuzz::read(input, [&] {
    if (!input.empty()) throw ConfigError("refused");
  });
}
void crash(std::string_view input) {
  fuzz::read(input, [&] {
    if (!input.empty()) std::raise(SIGSEGV);
  });
}
void throw_another_error(std::string_view input) {
  fuzz::read(input, [&] {
    if (!input.empty()) throw std::runtime_error("thrown by a test");
  });
}
void take_memory(std::string_view input) {
  static std::vector<char> taken;
  fuzz::read(input, [&] { taken.resize(input.size() * (fuzz::kFreeMemory + 1000)); });
}

}  // namespace

TEST_CASE("hostile inputs of every format are read or refused") {
  REQUIRE(!fuzz::fuzzers().empty());
  for (const auto& [format, fuzzer] : fuzz::fuzzers()) {
    SUBCASE(format.c_str()) { replay(format, fuzzer); }
  }
}

TEST_CASE("readers that crash, throw or take too much memory are found at the input that shows it") {
  const std::vector<Seed> seeds = {{"good", ""}, {"bad", "b"}, {"good", ""}};
  const auto check_end = [&](fuzz::Fuzzer fuzzer, int signal, std::size_t last) {
    const auto [status, number] = read_in_child(fuzzer, seeds, seeds.size());
    CHECK(WTERMSIG(status) == signal);
    CHECK(number == last);
  };
  SUBCASE("refuses") { check_end(refuse, 0, seeds.size()); }
  SUBCASE("crashes") { check_end(crash, SIGSEGV, 1); }
  SUBCASE("throws") { check_end(throw_another_error, SIGABRT, 1); }
  SUBCASE("takes memory") { check_end(take_memory, SIGABRT, 1); }
}
