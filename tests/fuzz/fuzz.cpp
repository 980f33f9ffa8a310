#include "fuzz.hpp"

#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <vector>

#include <sanitizer/allocator_interface.h>

#include "threewe/core/errors.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace threewe::fuzz {
namespace {

// Bytes that are allocated now, and the most there were since the last input began.
std::atomic<std::ptrdiff_t> held{0};
std::atomic<std::ptrdiff_t> most_held{0};

void on_malloc(const volatile void*, std::size_t size) {
  const std::ptrdiff_t now = held += static_cast<std::ptrdiff_t>(size);
  if (now > most_held) most_held = now;
}
void on_free(const volatile void* pointer) {
  if (pointer == nullptr) return;
  held -= static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(const_cast<const void*>(pointer)));
}

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

constexpr std::array kExtremes = {"0",
                                  "-0.0",
                                  "1",
                                  "-1",
                                  "nan",
                                  ".nan",
                                  "inf",
                                  "-.inf",
                                  "1e308",
                                  "-1e308",
                                  "1e-320",
                                  "1e400",
                                  "1e6",
                                  "-1000000",
                                  "1000001",
                                  "8192",
                                  "8193",
                                  "16384",
                                  "32767",
                                  "-32768",
                                  "65535",
                                  "65536",
                                  "2147483647",
                                  "2147483648",
                                  "-2147483649",
                                  "4294967296",
                                  "9223372036854775807",
                                  "9223372036854775808",
                                  "18446744073709551615",
                                  "0.001",
                                  "6.2832",
                                  "3.14159",
                                  "1e9",
                                  "1e-9",
                                  "0x10",
                                  "true",
                                  "~",
                                  "{}",
                                  "[]",
                                  "*a",
                                  "&a",
                                  "<<",
                                  "!!int",
                                  "|",
                                  "\"\\0\"",
                                  "../../x"};

class Mutation {
 public:
  Mutation(std::string text, unsigned seed) : text_(std::move(text)), random_(seed) {}

  std::string apply() {
    const bool by_line = below(2) == 0;
    const Piece piece = by_line ? line() : word();
    const std::string copy = text_.substr(piece.begin, piece.size);
    switch (below(by_line ? 5 : 6)) {
      case 0: text_.erase(piece.begin, piece.size); break;
      case 1: text_.insert(piece.begin, by_line ? copy : copy + " "); break;
      case 2: {  // from elsewhere
        const Piece other = by_line ? line() : word();
        text_.replace(piece.begin, piece.size, text_.substr(other.begin, other.size));
        break;
      }
      case 3: {  // moved
        text_.erase(piece.begin, piece.size);
        text_.insert(by_line ? line().begin : word().begin, copy);
        break;
      }
      case 4: {  // many of the same
        std::string many;
        for (std::size_t n = std::size_t{1} << below(7); n > 0 && many.size() < text_.size() + 512; --n) many += copy;
        text_.insert(piece.begin, many);
        break;
      }
      default: text_.replace(piece.begin, piece.size, kExtremes[below(kExtremes.size())]); break;
    }
    return text_;
  }

 private:
  struct Piece {
    std::size_t begin;
    std::size_t size;
  };

  std::size_t below(std::size_t count) { return random_() % count; }

  Piece line() {
    const std::size_t at = below(text_.size() + 1);
    const std::size_t before = at == 0 ? std::string::npos : text_.rfind('\n', at - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(text_.find('\n', begin), text_.size());
    return {begin, std::min(end + 1, text_.size()) - begin};
  }

  Piece word() {
    const auto belongs = [this](std::size_t i) {
      const char c = text_[i];
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+' || c == '_';
    };
    std::size_t begin = below(text_.size() + 1);
    while (begin < text_.size() && !belongs(begin)) ++begin;
    while (begin > 0 && begin < text_.size() && belongs(begin - 1)) --begin;
    std::size_t end = begin;
    while (end < text_.size() && belongs(end)) ++end;
    return {begin, end - begin};
  }

  std::string text_;
  std::minstd_rand random_;
};

}  // namespace

void read(std::string_view input, const std::function<void()>& reader, std::size_t free_memory, std::size_t per_byte) {
  static const bool hooked = [] { return __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free) != 0; }();
  if (!hooked) fail("memory cannot be counted");
  const std::ptrdiff_t before = held;
  most_held = before;
  const Limit limit;
  try {
    reader();
  } catch (const ConfigError&) {  // refused
  } catch (const std::exception& error) {
    fail(error.what());
  }
  const std::size_t taken = static_cast<std::size_t>(most_held - before);
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

std::size_t mutate_text(char* text, std::size_t size, std::size_t most, unsigned seed) {
  const std::string changed = Mutation(std::string(text, size), seed).apply();
  const std::size_t kept = std::min(changed.size(), most);
  std::copy_n(changed.data(), kept, text);
  return kept;
}

}  // namespace threewe::fuzz

// Two of three changes know what texts are made of, the others are libFuzzer's own.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  if (seed % 3 == 0) return LLVMFuzzerMutate(data, size, most);
  return threewe::fuzz::mutate_text(reinterpret_cast<char*>(data), size, most, seed / 3);
}
