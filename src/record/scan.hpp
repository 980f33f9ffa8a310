// Scan of a journal's blocks, up to the first torn one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <vector>

#include "record/block.hpp"

namespace threewe::record {

/// Calls `visit` with each block and its content until it returns false, a block is torn, or the file ends. Returns
/// where it stopped [bytes]. Throws ConfigError where the file cannot be read.
std::uint64_t scan_blocks(const std::filesystem::path& file,
                          const std::function<bool(const BlockPlace&, std::span<const std::byte>)>& visit);

/// Reads blocks again, by their places. Keeps the content of the last one.
class BlockReader {
 public:
  /// Throws ConfigError.
  explicit BlockReader(const std::filesystem::path& file);
  /// The next block behind `offset`; false at the end, and where it is torn.
  bool read(std::uint64_t offset);
  const BlockPlace& place() const { return place_; }
  std::span<const std::byte> content() const { return content_; }

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;  // [bytes] of the file
  BlockPlace place_;
  bool valid_ = false;
  std::vector<std::byte> frame_, content_;
};

}  // namespace threewe::record
