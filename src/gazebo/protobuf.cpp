#include "gazebo/protobuf.hpp"

namespace threewe::gazebo {

namespace {
constexpr std::uint64_t kMostFields = (1U << 29U) - 1;  // the largest number that a field may have
}

bool FieldReader::next() {
  if (!ok_ || rest_.empty()) return false;
  ok_ = false;  // until all of the field is there
  const auto key = take_varint();
  if (!key || *key >> 3U == 0 || *key >> 3U > kMostFields) return false;
  number_ = static_cast<std::uint32_t>(*key >> 3U);
  wire_ = static_cast<Wire>(*key & 7U);
  switch (wire_) {
    case Wire::varint: {
      const auto value = take_varint();
      integer_ = value.value_or(0);
      ok_ = value.has_value();
      break;
    }
    case Wire::fixed64: ok_ = take(8); break;
    case Wire::fixed32: ok_ = take(4); break;
    case Wire::bytes: {
      const auto size = take_varint();
      ok_ = size && *size <= rest_.size() && take(static_cast<std::size_t>(*size));
      break;
    }
    default: break;  // groups, which are obsolete, and what is no kind at all
  }
  return ok_;
}

std::optional<std::uint64_t> FieldReader::integer() const {
  if (wire_ != Wire::varint) return std::nullopt;
  return integer_;
}

std::optional<double> FieldReader::real() const {
  if (wire_ != Wire::fixed64) return std::nullopt;
  double value = 0.0;
  std::memcpy(&value, value_.data(), sizeof value);
  return value;
}

std::optional<ByteView> FieldReader::bytes() const {
  if (wire_ != Wire::bytes) return std::nullopt;
  return value_;
}

std::optional<std::uint64_t> FieldReader::take_varint() {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !rest_.empty(); shift += 7) {
    const std::uint8_t byte = rest_.front();
    rest_ = rest_.subspan(1);
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if (byte < 0x80U) return value;
  }
  return std::nullopt;
}

bool FieldReader::take(std::size_t size) {
  if (size > rest_.size()) return false;
  value_ = rest_.first(size);
  rest_ = rest_.subspan(size);
  return true;
}

void FieldWriter::put_varint(std::uint64_t value) {
  for (; value >= 0x80U; value >>= 7U) bytes_.push_back(static_cast<std::uint8_t>(value | 0x80U));
  bytes_.push_back(static_cast<std::uint8_t>(value));
}

void FieldWriter::put_integer(std::uint32_t number, std::uint64_t value) {
  put_varint(std::uint64_t{number} << 3U);
  put_varint(value);
}

void FieldWriter::put_real(std::uint32_t number, double value) {
  put_varint(std::uint64_t{number} << 3U | 1U);
  const std::size_t at = bytes_.size();
  bytes_.resize(at + sizeof value);
  std::memcpy(bytes_.data() + at, &value, sizeof value);
}

void FieldWriter::put_bytes(std::uint32_t number, ByteView value) {
  put_varint(std::uint64_t{number} << 3U | 2U);
  put_varint(value.size());
  bytes_.insert(bytes_.end(), value.begin(), value.end());
}

}  // namespace threewe::gazebo
