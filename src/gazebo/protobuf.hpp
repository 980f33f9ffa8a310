// Protocol Buffers codec: messages as structs with a list of their fields, which gives reading and writing.
//
//   struct Time {
//     std::int64_t sec = 0;
//     std::int32_t nsec = 0;
//     static constexpr auto kFields = std::tuple(Field{1, &Time::sec}, Field{2, &Time::nsec});
//   };
//
// A std::optional message is absent where it is empty; fields that a struct does not list are skipped.
#pragma once

#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace threewe::gazebo {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

/// One field of a message: its number, and the member that holds it.
template <typename Struct, typename Member>
struct Field {
  std::uint32_t number;
  Member Struct::* member;
};

/// A struct with a list of fields.
template <typename T>
concept Message = requires { T::kFields; };

/// Reads fields one after the other, and never beyond the end.
class FieldReader {
 public:
  explicit FieldReader(ByteView bytes) : rest_(bytes) {}
  /// Goes to the next field. False at the end, and where what follows is none: then `ok` is false.
  bool next();
  bool ok() const { return ok_; }
  std::uint32_t number() const { return number_; }

  // The value of the field that `next` went to; empty where it was written as another kind.
  std::optional<std::uint64_t> integer() const;
  std::optional<double> real() const;
  std::optional<ByteView> bytes() const;

 private:
  enum class Wire : std::uint8_t { varint = 0, fixed64 = 1, bytes = 2, fixed32 = 5 };
  std::optional<std::uint64_t> take_varint();
  bool take(std::size_t size);

  ByteView rest_;
  ByteView value_;
  std::uint64_t integer_ = 0;
  std::uint32_t number_ = 0;
  Wire wire_{};
  bool ok_ = true;
};

/// Appends fields to a message. Values that are zero or empty are left out, as Protocol Buffers have it.
class FieldWriter {
 public:
  void put_integer(std::uint32_t number, std::uint64_t value);
  void put_real(std::uint32_t number, double value);
  void put_bytes(std::uint32_t number, ByteView value);
  Bytes take() { return std::move(bytes_); }

 private:
  void put_varint(std::uint64_t value);

  Bytes bytes_;
};

/// The message that some bytes hold; empty where they hold none. Fields of another kind than expected are an error.
template <Message T>
std::optional<T> decode(ByteView bytes);
/// The bytes of a message.
template <Message T>
Bytes encode(const T& message);

// Values of each type.

inline ByteView view(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

template <typename T>
bool read_value(const FieldReader& field, T& value) {
  if constexpr (std::integral<T> || std::is_enum_v<T>) {
    const auto integer = field.integer();
    if (integer) value = static_cast<T>(*integer);
    return integer.has_value();
  } else if constexpr (std::same_as<T, double>) {
    const auto real = field.real();
    if (real) value = *real;
    return real.has_value();
  } else if constexpr (Message<T>) {
    const auto bytes = field.bytes();
    auto read = bytes ? decode<T>(*bytes) : std::nullopt;
    if (read) value = std::move(*read);
    return read.has_value();
  } else {
    const auto bytes = field.bytes();
    if (bytes) value.assign(bytes->begin(), bytes->end());
    return bytes.has_value();
  }
}

template <typename T>
bool read_value(const FieldReader& field, std::optional<T>& value) {
  return read_value(field, value.emplace());
}

template <Message T>
bool read_value(const FieldReader& field, std::vector<T>& values) {
  return read_value(field, values.emplace_back());
}

/// Packed into one field, or one field each.
inline bool read_value(const FieldReader& field, std::vector<double>& values) {
  if (const auto real = field.real()) {
    values.push_back(*real);
    return true;
  }
  const auto bytes = field.bytes();
  if (!bytes || bytes->size() % sizeof(double) != 0) return false;
  const std::size_t before = values.size();
  values.resize(before + bytes->size() / sizeof(double));
  if (!bytes->empty()) std::memcpy(values.data() + before, bytes->data(), bytes->size());
  return true;
}

template <typename T>
void write_value(FieldWriter& out, std::uint32_t number, const T& value) {
  if constexpr (std::integral<T> || std::is_enum_v<T>) {
    // negative numbers fill 64 bits
    if (value != T{}) out.put_integer(number, static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
  } else if constexpr (std::same_as<T, double>) {
    if (value != 0.0) out.put_real(number, value);
  } else if constexpr (Message<T>) {
    out.put_bytes(number, encode(value));
  } else if constexpr (std::same_as<T, std::string>) {
    if (!value.empty()) out.put_bytes(number, view(value));
  } else {
    if (!value.empty()) out.put_bytes(number, value);
  }
}

template <typename T>
void write_value(FieldWriter& out, std::uint32_t number, const std::optional<T>& value) {
  if (value) write_value(out, number, *value);
}

template <Message T>
void write_value(FieldWriter& out, std::uint32_t number, const std::vector<T>& values) {
  for (const T& value : values) write_value(out, number, value);
}

inline void write_value(FieldWriter& out, std::uint32_t number, const std::vector<double>& values) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(values.data());
  if (!values.empty()) out.put_bytes(number, {bytes, values.size() * sizeof(double)});
}

template <Message T>
std::optional<T> decode(ByteView bytes) {
  T message;
  FieldReader field(bytes);
  bool good = true;
  while (good && field.next()) {
    const auto read = [&](const auto& one) {
      if (one.number == field.number()) good = read_value(field, message.*one.member);
    };
    std::apply([&](const auto&... fields) { (read(fields), ...); }, T::kFields);
  }
  if (!good || !field.ok()) return std::nullopt;
  return message;
}

template <Message T>
Bytes encode(const T& message) {
  FieldWriter out;
  const auto write = [&](const auto& one) { write_value(out, one.number, message.*one.member); };
  std::apply([&](const auto&... fields) { (write(fields), ...); }, T::kFields);
  return out.take();
}

}  // namespace threewe::gazebo
