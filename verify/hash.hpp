// FNV-1a over the bits of numbers.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>

namespace threewe {

class Hash {
 public:
  void add(std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) add_byte(static_cast<std::uint8_t>(word >> (8 * byte) & 0xFF));
  }
  void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
  /// The bytes of numbers that lie side by side.
  template <typename T, std::size_t N>
  void add(std::span<T, N> numbers) {
    for (const std::byte byte : std::as_bytes(numbers)) add_byte(std::to_integer<std::uint8_t>(byte));
  }
  std::uint64_t value() const { return value_; }

 private:
  void add_byte(std::uint8_t byte) { value_ = (value_ ^ byte) * 0x100000001B3ULL; }
  std::uint64_t value_ = 0xCBF29CE484222325ULL;
};

/// A line: what was run, and its hash.
inline void print_hash(const std::string& run, std::uint64_t hash) {
  std::printf("%s %016llx\n", run.c_str(), static_cast<unsigned long long>(hash));
}

}  // namespace threewe
