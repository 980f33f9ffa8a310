// Blocks of a journal: Zstandard frames with checksums, each behind a skippable frame that states its sizes. So
// `zstd --decompress` reads a journal, and a reader finds each block without looking into those before it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "record/file_system.hpp"

struct ZSTD_CCtx_s;

namespace threewe::record {

/// [bytes] of a block's header: magic number, 8, compressed size, content size; 32 bits each, little-endian.
inline constexpr std::size_t kBlockHeader = 16;
/// [bytes] that no block's content passes; the largest image has 201 MB.
inline constexpr std::size_t kLargestBlock = std::size_t{1} << 28U;

/// Compresses blocks.
class BlockCompressor {
 public:
  BlockCompressor();
  /// Header and frame, valid until the next call. Throws std::bad_alloc.
  std::span<const std::byte> compress(std::span<const std::byte> content);

 private:
  struct Free {
    void operator()(ZSTD_CCtx_s* context) const;
  };
  std::unique_ptr<ZSTD_CCtx_s, Free> context_;
  std::vector<std::byte> block_;
};

/// Where a block is in its file.
struct BlockPlace {
  std::uint64_t offset = 0;    ///< [bytes] of its header
  std::size_t compressed = 0;  ///< [bytes] behind the header
  std::size_t content = 0;     ///< [bytes]
  std::uint64_t end() const { return offset + kBlockHeader + compressed; }
};

/// What a header says, given where it stands; empty where it is none.
std::optional<BlockPlace> parse_header(std::span<const std::byte> header, std::uint64_t offset);
/// [bytes] of content that a frame says to have; empty where it does not say. Memory is taken for no more than this
/// and the block's header agree on.
std::optional<std::uint64_t> content_size(std::span<const std::byte> frame);
/// The content of a frame; false where it is torn or changed.
bool decompress(std::span<const std::byte> frame, std::vector<std::byte>& content);

}  // namespace threewe::record
