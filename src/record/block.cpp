#include "record/block.hpp"

#include <cstring>
#include <new>

#include <zstd.h>

namespace threewe::record {
namespace {

constexpr std::uint32_t kSkippable = 0x184D2A53;  // one of sixteen numbers that RFC 8878, 3.1.2, leaves to its users
constexpr std::uint32_t kSizes = 8;
constexpr int kLevel = 1;

}  // namespace

void BlockCompressor::Free::operator()(ZSTD_CCtx_s* context) const { ZSTD_freeCCtx(context); }

BlockCompressor::BlockCompressor() : context_(ZSTD_createCCtx()) {
  if (!context_) throw std::bad_alloc();
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_checksumFlag, 1);
}

std::span<const std::byte> BlockCompressor::compress(std::span<const std::byte> content) {
  block_.resize(kBlockHeader + ZSTD_compressBound(content.size()));
  const std::size_t size = ZSTD_compress2(context_.get(), block_.data() + kBlockHeader, block_.size() - kBlockHeader,
                                          content.data(), content.size());
  if (ZSTD_isError(size)) throw std::bad_alloc();  // all that can be short is memory
  const std::uint32_t header[] = {kSkippable, kSizes, static_cast<std::uint32_t>(size),
                                  static_cast<std::uint32_t>(content.size())};
  static_assert(sizeof(header) == kBlockHeader);
  std::memcpy(block_.data(), header, sizeof(header));
  return {block_.data(), kBlockHeader + size};
}

std::optional<BlockPlace> parse_header(std::span<const std::byte> header, std::uint64_t offset) {
  std::uint32_t fields[4] = {};
  if (header.size() < sizeof(fields)) return {};
  std::memcpy(fields, header.data(), sizeof(fields));
  const BlockPlace place{offset, fields[2], fields[3]};
  const bool sane = fields[0] == kSkippable && fields[1] == kSizes && place.content <= kLargestBlock &&
                    place.compressed <= ZSTD_compressBound(place.content);
  return sane ? std::optional(place) : std::nullopt;
}

std::optional<std::uint64_t> content_size(std::span<const std::byte> frame) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  const bool known = size != ZSTD_CONTENTSIZE_UNKNOWN && size != ZSTD_CONTENTSIZE_ERROR;
  return known ? std::optional<std::uint64_t>(size) : std::nullopt;
}

bool decompress(std::span<const std::byte> frame, std::vector<std::byte>& content) {
  const std::size_t size = ZSTD_decompress(content.data(), content.size(), frame.data(), frame.size());
  return !ZSTD_isError(size) && size == content.size();
}

}  // namespace threewe::record
