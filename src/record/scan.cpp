#include "record/scan.hpp"

#include <array>

#include "threewe/core/errors.hpp"

namespace threewe::record {
namespace {

bool read_at(std::ifstream& stream, std::uint64_t offset, std::span<std::byte> to) {
  stream.clear();
  stream.seekg(static_cast<std::streamoff>(offset));
  stream.read(reinterpret_cast<char*>(to.data()), static_cast<std::streamsize>(to.size()));
  return static_cast<std::size_t>(stream.gcount()) == to.size();
}

}  // namespace

BlockReader::BlockReader(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw ConfigError(file.string() + ": no such file");
  stream_.open(file, std::ios::binary);
  size_ = std::filesystem::file_size(file, error);
  if (!stream_ || error) throw ConfigError(file.string() + ": cannot be read");
}

bool BlockReader::read(std::uint64_t offset) {
  if (valid_ && place_.offset == offset) return true;
  valid_ = false;
  std::array<std::byte, kBlockHeader> header{};
  if (!read_at(stream_, offset, header)) return false;
  const auto place = parse_header(header, offset);
  if (!place) return false;
  if (place->end() > size_) return false;
  frame_.resize(place->compressed);
  if (!read_at(stream_, offset + kBlockHeader, frame_) || content_size(frame_) != place->content) return false;
  content_.resize(place->content);
  if (!decompress(frame_, content_)) return false;
  place_ = *place;
  valid_ = true;
  return true;
}

std::uint64_t scan_blocks(const std::filesystem::path& file,
                          const std::function<bool(const BlockPlace&, std::span<const std::byte>)>& visit) {
  BlockReader reader(file);
  std::uint64_t offset = 0;
  while (reader.read(offset) && visit(reader.place(), reader.content())) offset = reader.place().end();
  return offset;
}

}  // namespace threewe::record
