// Entry points of libFuzzer, for a program with one fuzzer.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "fuzz.hpp"
#include "mutation.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const threewe::fuzz::Fuzzer fuzzer = threewe::fuzz::fuzzers().begin()->second;
  fuzzer({reinterpret_cast<const char*>(data), size});
  return 0;
}

// Two of three changes know what texts are made of, the others are libFuzzer's own.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  if (seed % 3 == 0) return LLVMFuzzerMutate(data, size, most);
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string changed = threewe::fuzz::change_text(text, seed / 3);
  return static_cast<std::size_t>(std::copy_n(changed.begin(), std::min(changed.size(), most), data) - data);
}
