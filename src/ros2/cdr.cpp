#include "ros2/cdr.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace threewe::ros2 {

void CdrWriter::put_bytes(const void* from, std::size_t size, std::size_t alignment) {
  const std::size_t end = bytes_.size() - kEncapsulation;
  const std::size_t begin = kEncapsulation + (end + alignment - 1) / alignment * alignment;
  bytes_.resize(begin + size);
  std::memcpy(bytes_.data() + begin, from, size);
}

CdrReader::CdrReader(std::span<const std::uint8_t> payload, Distribution distribution) : layout(distribution) {
  // 0 is plain CDR in the order of the last bit; all else (parameter lists, version 2) no ROS message comes in
  if (payload.size() < kEncapsulation || payload[0] != 0 || payload[1] > 1) {
    fail("encapsulation", "is not that of plain CDR");
    return;
  }
  swap_ = payload[1] == 0;
  payload_ = payload.subspan(kEncapsulation);
}

std::optional<std::string> CdrReader::finish(std::string_view type) {
  constexpr std::size_t kPadding = 3;  // [bytes] by which some fill up a multiple of 4
  if (ok() && left() > kPadding) mistake_ = fmt::format("{} bytes are left over", left());
  if (ok()) return std::nullopt;
  return fmt::format("{}: {}", type, mistake_);
}

void CdrReader::swap_bytes(std::uint8_t* bytes, std::size_t size, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) std::reverse(bytes + i * size, bytes + (i + 1) * size);
}

/// Steps over padding; false, and a mistake, where `size` more bytes are not there.
bool CdrReader::align(std::string_view name, std::size_t alignment, std::size_t size) {
  const std::size_t begin = (next_ + alignment - 1) / alignment * alignment;
  if (begin > payload_.size() || size > payload_.size() - begin) {
    fail(name, "is beyond the end");
    return false;
  }
  next_ = begin;
  return true;
}

/// How many elements follow; none, and a mistake, where they cannot all be there.
std::size_t CdrReader::get_count(std::string_view name, std::size_t least_size) {
  std::uint32_t count = 0;
  get_elements(name, &count, 1);
  if (count <= left() / least_size) return count;
  fail(name, fmt::format("has {} elements, which are beyond the end", count));
  return 0;
}

void CdrReader::get_text(std::string_view name, std::string& text) {
  const std::size_t size = get_count(name, 1);
  text.clear();
  if (size == 0) return;  // as some write an empty text, without its final zero
  const auto* begin = payload_.data() + next_;
  if (begin[size - 1] != 0) return fail(name, "does not end with a zero");
  text.assign(reinterpret_cast<const char*>(begin), size - 1);
  next_ += size;
}

void CdrReader::fail(std::string_view name, std::string_view what) {
  if (ok()) mistake_ = fmt::format("{} {}", name, what);
}

}  // namespace threewe::ros2
