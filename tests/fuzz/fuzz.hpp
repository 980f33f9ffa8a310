// What the fuzzers of all formats share: how an input is read, what counts as a failure, how inputs are changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
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

/// Reads an input, which is accepted or refused by a ConfigError. Aborts where anything else is thrown, where
/// reading took longer than it may, or held more memory at once.
void read(std::string_view input, const std::function<void()>& reader, std::size_t free_memory = kFreeMemory,
          std::size_t per_byte = kMemoryPerByte);

/// A folder in memory that is this process's own.
const std::filesystem::path& folder();
void write(const std::filesystem::path& file, std::string_view content);

/// One change of a text that knows what texts are made of: a number becomes another, often an extreme one; a word, a
/// line or a block of lines is lost, doubled, moved or taken from elsewhere. Returns the new size, at most `most`.
std::size_t mutate_text(char* text, std::size_t size, std::size_t most, unsigned seed);

}  // namespace threewe::fuzz
