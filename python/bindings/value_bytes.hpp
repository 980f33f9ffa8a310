// Plain structs as bytes and back, whatever their fields are: how values are pickled and hashed.
#pragma once

#include <array>
#include <chrono>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "fields.hpp"
#include "threewe/core/camera.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/core/footprint.hpp"

namespace value {

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// A value as bytes, field after field. Numbers that are equal become equal bytes where `for_hash`.
class Writer {
 public:
  explicit Writer(bool for_hash = false) : for_hash_(for_hash) {}

  template <Number T>
  void put(const T& number) {
    const T written = for_hash_ && number == T{} ? T{} : number;        // one zero
    bytes_.append(reinterpret_cast<const char*>(&written), sizeof(T));  // NOLINT: its bytes are meant
  }
  template <class Rep, class Period>
  void put(const std::chrono::duration<Rep, Period>& time) {
    put(time.count());
  }
  void put(const std::string& text) { put_items(text); }
  template <class T>
  void put(const std::vector<T>& items) {
    put_items(items);
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& items) {
    for (const T& item : items) put(item);
  }
  template <class T>
  void put(const std::optional<T>& maybe) {
    put(maybe.has_value());
    if (maybe) put(*maybe);
  }
  template <class... T>
  void put(const std::variant<T...>& one) {
    put(one.index());
    std::visit([this](const auto& which) { put(which); }, one);
  }
  void put(const threewe::Footprint& outline) { put(outline.corners()); }
  void put(const threewe::Picture& picture) { put(picture.image()); }
  template <class T>
    requires std::is_aggregate_v<T>
  void put(const T& aggregate) {
    std::apply([this](const auto&... field) { (put(field), ...); }, fields::of(aggregate));
  }

  const std::string& bytes() const { return bytes_; }

 private:
  template <class Items>
  void put_items(const Items& items) {
    put(items.size());
    if constexpr (Number<typename Items::value_type>) {
      if (!for_hash_) {  // the pixels of an image at once
        bytes_.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(items[0]));  // NOLINT
        return;
      }
    }
    for (const auto& item : items) put(item);
  }

  bool for_hash_;
  std::string bytes_;
};

/// The same the other way round. Throws ContractError where bytes are missing.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <Number T>
  void get(T& number) {
    std::memcpy(&number, take(sizeof(T)), sizeof(T));
  }
  template <class Rep, class Period>
  void get(std::chrono::duration<Rep, Period>& time) {
    time = std::chrono::duration<Rep, Period>(get<Rep>());
  }
  void get(std::string& text) { get_items(text); }
  template <class T>
  void get(std::vector<T>& items) {
    get_items(items);
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& items) {
    for (T& item : items) get(item);
  }
  template <class T>
  void get(std::optional<T>& maybe) {
    if (get<bool>()) get(maybe.emplace());
  }
  template <class... T>
  void get(std::variant<T...>& one) {
    get_alternative(one, get<std::size_t>(), std::index_sequence_for<T...>{});
  }
  void get(threewe::Footprint& outline) {
    const auto corners = get<std::vector<threewe::Vec2>>();
    if (!corners.empty()) outline = threewe::Footprint(corners);
  }
  void get(threewe::Picture& picture) { picture = threewe::Picture(get<threewe::RGBDImage>()); }
  template <class T>
    requires std::is_aggregate_v<T>
  void get(T& aggregate) {
    std::apply([this](auto&... field) { (get(field), ...); }, fields::of(aggregate));
  }
  template <class T>
  T get() {
    T read{};
    get(read);
    return read;
  }

  /// Throws ContractError where bytes are left.
  void finish() const {
    if (!bytes_.empty()) refuse();
  }

 private:
  [[noreturn]] static void refuse() {
    throw threewe::ContractError("this was pickled by another version of 3we, or is damaged");
  }
  const char* take(std::size_t count) {
    if (count > bytes_.size()) refuse();
    const char* taken = bytes_.data();
    bytes_.remove_prefix(count);
    return taken;
  }
  template <class Items>
  void get_items(Items& items) {
    const auto size = get<std::size_t>();
    if (size > bytes_.size()) refuse();  // no item is empty
    items.resize(size);
    if constexpr (Number<typename Items::value_type>) {
      const std::size_t length = size * sizeof(typename Items::value_type);
      if (const char* taken = take(length); length > 0) std::memcpy(items.data(), taken, length);
    } else {
      for (auto& item : items) get(item);
    }
  }
  template <class Variant, std::size_t... I>
  void get_alternative(Variant& one, std::size_t index, std::index_sequence<I...>) {
    if (!((index == I && (get(one.template emplace<I>()), true)) || ...)) refuse();
  }

  std::string_view bytes_;
};

}  // namespace value
