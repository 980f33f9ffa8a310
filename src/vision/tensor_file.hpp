// Reader of safetensors files: named arrays of integers, and a mapping of text.
// Format: https://huggingface.co/docs/safetensors, a length of 8 bytes, a JSON header, the arrays.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace threewe::vision {

inline constexpr std::size_t kLargestTensorFile = 64U << 20U;  ///< [bytes]

/// All arrays of a file, widened to 32 bits.
class TensorFile {
 public:
  /// Reads a file. Throws ConfigError naming it and what is wrong: not there, cut off, too large, no such format.
  static TensorFile load(const std::filesystem::path& file);
  /// Parses the bytes of one; `name` stands for the file in messages.
  static TensorFile parse(const std::string& bytes, const std::string& name);

  /// A text of the header's metadata. Throws ConfigError where there is none.
  const std::string& text(const std::string& key) const;
  /// An array of exactly this shape. Throws ConfigError where there is none, or it has another.
  const std::vector<std::int32_t>& array(const std::string& name, const std::vector<std::size_t>& shape) const;
  /// Throws ConfigError with the file's name.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  struct Array {
    std::vector<std::size_t> shape;
    std::vector<std::int32_t> values;
  };
  std::string name_;
  std::map<std::string, std::string> texts_;
  std::map<std::string, Array> arrays_;
};

}  // namespace threewe::vision
