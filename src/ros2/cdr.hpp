// CDR codec: ROS 2 messages to and from bytes on the wire (XCDR version 1), by the one list of members of each.
//
// Writing is little-endian. Reading takes both orders and trusts nothing: a length is believed only as far as bytes are
// left for it, so that no payload makes us allocate more than a small multiple of its own size.
#pragma once

#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include <tl/expected.hpp>

#include "ros2/messages/description.hpp"

namespace threewe::ros2 {

static_assert(std::endian::native == std::endian::little, "values are copied as they lie in memory");

/// [bytes] of the encapsulation before every payload: which encoding follows.
inline constexpr std::size_t kEncapsulation = 4;

/// The least bytes that a value takes on the wire, by its members; paddings are left out.
class WireSize {
 public:
  explicit WireSize(Distribution distribution) : layout(distribution) {}
  const Distribution layout;

  template <typename T>
  void operator()(std::string_view, const T& value) {
    if constexpr (Primitive<T>) {
      least_ += sizeof(T);
    } else if constexpr (Text<T> || kIsSequence<T>) {
      least_ += sizeof(std::uint32_t);
    } else if constexpr (IsFixedArray<T>) {
      for (const auto& element : value) (*this)({}, element);
    } else {
      T::members(value, *this);
    }
  }
  std::size_t least() const { return least_; }

 private:
  std::size_t least_ = 0;
};

/// The least bytes that any `T` takes on the wire; at least 1.
template <typename T>
std::size_t least_wire_size(Distribution layout) {
  WireSize size(layout);
  size({}, T{});
  return size.least();
}

/// Appends values to a payload.
class CdrWriter {
 public:
  explicit CdrWriter(Distribution distribution) : layout(distribution), bytes_{0, 1, 0, 0} {}
  const Distribution layout;

  template <typename T>
  void operator()(std::string_view, const T& value) {
    if constexpr (Primitive<T>) {
      put_elements(&value, 1);
    } else if constexpr (Text<T>) {
      put_count(value.size() + 1);
      put_bytes(value.c_str(), value.size() + 1, 1);
    } else if constexpr (kIsSequence<T>) {
      put_count(value.size());
      put_all(value);
    } else if constexpr (IsFixedArray<T>) {
      put_all(value);
    } else {
      T::members(value, *this);
    }
  }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  void put_count(std::size_t count) {
    const auto number = static_cast<std::uint32_t>(count);
    put_elements(&number, 1);
  }
  template <typename T>
  void put_all(const T& values) {
    using Element = std::remove_cvref_t<decltype(*values.begin())>;
    if constexpr (Primitive<Element>) {
      put_elements(values.data(), values.size());
    } else {
      for (const auto& value : values) (*this)({}, value);
    }
  }
  template <typename T>
  void put_elements(const T* values, std::size_t count) {
    if (count > 0) put_bytes(values, count * sizeof(T), sizeof(T));
  }
  void put_bytes(const void* from, std::size_t size, std::size_t alignment);

  std::vector<std::uint8_t> bytes_;
};

/// Reads values from a payload. After the first mistake it reads nothing any more.
class CdrReader {
 public:
  CdrReader(std::span<const std::uint8_t> payload, Distribution distribution);
  const Distribution layout;

  template <typename T>
  void operator()(std::string_view name, T&& value) {
    using Value = std::remove_cvref_t<T>;
    if (!ok()) return;
    if constexpr (std::same_as<Value, bool>) {
      std::uint8_t byte = 0;
      get_elements(name, &byte, 1);
      if (byte > 1) fail(name, "is neither false nor true");
      value = byte == 1;
    } else if constexpr (Primitive<Value>) {
      get_elements(name, &value, 1);
    } else if constexpr (Text<Value>) {
      get_text(name, value);
      if constexpr (requires { Value::kCapacity; }) {
        if (value.size() > Value::kCapacity) fail(name, "is longer than its type allows");
      }
    } else if constexpr (kIsSequence<Value>) {
      value.resize(get_count(name, least_wire_size<typename Value::value_type>(layout)));
      get_all(name, value);
    } else if constexpr (IsFixedArray<Value>) {
      get_all(name, value);
    } else {
      Value::members(value, *this);
    }
  }
  bool ok() const { return mistake_.empty(); }
  /// What is wrong with the payload of a `type`, and with which member of it; nothing where all of it was read.
  std::optional<std::string> finish(std::string_view type);

 private:
  template <typename T>
  void get_all(std::string_view name, T& values) {
    using Element = std::remove_cvref_t<decltype(*values.begin())>;
    static_assert(!std::same_as<Element, bool>, "vectors of bool have no elements to be read into");
    if constexpr (Primitive<Element>) {
      get_elements(name, values.data(), values.size());
    } else {
      for (auto& value : values) (*this)(name, value);
    }
  }
  template <typename T>
  void get_elements(std::string_view name, T* values, std::size_t count) {
    if (count == 0 || !align(name, sizeof(T), count * sizeof(T))) return;
    std::memcpy(values, payload_.data() + next_, count * sizeof(T));
    next_ += count * sizeof(T);
    if constexpr (sizeof(T) > 1) {
      if (swap_) swap_bytes(reinterpret_cast<std::uint8_t*>(values), sizeof(T), count);
    }
  }
  std::size_t left() const { return payload_.size() - next_; }
  static void swap_bytes(std::uint8_t* bytes, std::size_t size, std::size_t count);
  bool align(std::string_view name, std::size_t alignment, std::size_t size);
  std::size_t get_count(std::string_view name, std::size_t least_size);
  void get_text(std::string_view name, std::string& text);
  void fail(std::string_view name, std::string_view what);

  std::span<const std::uint8_t> payload_;  // without the encapsulation
  std::size_t next_ = 0;
  bool swap_ = false;
  std::string mistake_;
};

/// A message as a payload, with its encapsulation.
template <Message T>
std::vector<std::uint8_t> encode(const T& message, Distribution layout) {
  CdrWriter writer(layout);
  T::members(message, writer);
  return writer.take();
}

/// The message that a payload holds in this layout, or what is wrong with it: too short, too long, or no such values.
template <Message T>
tl::expected<T, std::string> decode(std::span<const std::uint8_t> payload, Distribution layout) {
  CdrReader reader(payload, layout);
  T message;
  if (reader.ok()) T::members(message, reader);
  if (auto mistake = reader.finish(T::kType)) return tl::unexpected(std::move(*mistake));
  return message;
}

}  // namespace threewe::ros2
