// Shared parts of the fuzzers: their registry, what counts as a failure, and where a reader finds its files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace threewe::fuzz {

/// Memory that reading may take [bytes]: so much for each byte of input, and besides so much for libraries of assets
/// and tables, or, where a map is drawn, for grids of 16.7 million cells: two that grow while a third is made of one.
inline constexpr std::size_t kMemoryPerByte = 64;
inline constexpr std::size_t kFreeMemory = 64U << 20U;
inline constexpr std::size_t kMapMemory = 1U << 30U;
/// A message from the wire, and what is written of it again.
inline constexpr std::size_t kMessageMemory = 4096;
inline constexpr std::size_t kMessageMemoryPerByte = 16;

inline constexpr int kTimeLimit = 5;  ///< [s] of computing for one input

/// Reads one input of a format.
using Fuzzer = void (*)(std::string_view input);

/// The fuzzers of a program by their formats: one where libFuzzer makes the inputs, all of them in the replay.
std::map<std::string, Fuzzer>& fuzzers();

/// Reads an input, which is accepted or refused by a ConfigError. Aborts where anything else is thrown, where
/// reading took longer than it may, or held more memory at once.
void read(std::string_view input, const std::function<void()>& reader, std::size_t free_memory = kFreeMemory,
          std::size_t per_byte = kMemoryPerByte);

/// A folder in memory that is this process's own, and its children's.
const std::filesystem::path& folder();
void write(const std::filesystem::path& file, std::string_view content);

}  // namespace threewe::fuzz

/// Defines the fuzzer of a format: THREEWE_FUZZER(scene)(std::string_view input) { ... }
#define THREEWE_FUZZER(format)                                         \
  static void fuzz_##format(std::string_view);                         \
  [[maybe_unused]] static const bool format##_is_new =                 \
      threewe::fuzz::fuzzers().emplace(#format, fuzz_##format).second; \
  static void fuzz_##format
