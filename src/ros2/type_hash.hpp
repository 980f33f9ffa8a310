// Type hashes: the RIHS01 of a message, by which ROS 2 nodes from Iron on tell whether they mean the same type.
#pragma once

#include <map>
#include <utility>

#include "ros2/messages/description.hpp"

namespace threewe::ros2 {

/// Collects the descriptions of a message and of all that it contains, as JSON that the hash is computed of.
class TypeDescriber {
 public:
  explicit TypeDescriber(Distribution distribution) : layout(distribution) {}
  const Distribution layout;

  /// Describes the next member of the message at hand.
  template <typename T>
  void operator()(std::string_view name, const T&) {
    add_field(name, kind<T>());
  }
  /// Describes a message, unless it has been.
  template <Message T>
  void describe() {
    if (types_.contains(std::string(T::kType))) return;
    types_[std::string(T::kType)];  // before its members: none contains itself, but two may contain the same
    const std::string outer = std::exchange(current_, std::string(T::kType));
    const T message;
    T::members(message, *this);
    current_ = outer;
  }
  /// "RIHS01_" and 64 hexadecimal digits, of a message that was described.
  std::string hash(std::string_view type) const;

 private:
  // How the type description numbers kinds of member, as in type_description_interfaces/msg/FieldType.
  struct Kind {
    int id = 0;
    std::size_t capacity = 0;
    std::size_t text_capacity = 0;
    std::string nested;
  };
  static constexpr int kArray = 48;
  static constexpr int kSequence = 144;

  template <typename T>
  static constexpr int primitive_id() {
    if constexpr (std::same_as<T, bool>) return 15;
    if constexpr (std::same_as<T, std::byte>) return 16;
    if constexpr (std::same_as<T, float>) return 10;
    if constexpr (std::same_as<T, double>) return 11;
    constexpr int kUnsigned = std::is_unsigned_v<T> ? 1 : 0;
    return (sizeof(T) == 1 ? 2 : sizeof(T) == 2 ? 4 : sizeof(T) == 4 ? 6 : 8) + kUnsigned;
  }
  template <typename T>
  Kind kind() {
    if constexpr (Primitive<T>) {
      return {primitive_id<T>(), 0, 0, ""};
    } else if constexpr (requires { T::kCapacity; }) {
      return {21, 0, T::kCapacity, ""};
    } else if constexpr (Text<T>) {
      return {17, 0, 0, ""};
    } else if constexpr (kIsSequence<T>) {
      Kind element = kind<typename T::value_type>();
      element.id += kSequence;
      return element;
    } else if constexpr (IsFixedArray<T>) {
      Kind element = kind<typename FixedArray<T>::Element>();
      element.id += kArray;
      element.capacity = FixedArray<T>::kSize;
      return element;
    } else {
      describe<T>();
      return {1, 0, 0, std::string(T::kType)};
    }
  }
  void add_field(std::string_view name, const Kind& kind);

  std::map<std::string, std::string> types_;  // by name, the fields of each
  std::string current_;
};

/// The hash of a message in the layout of a distribution.
template <Message T>
std::string type_hash(Distribution layout) {
  TypeDescriber describer(layout);
  describer.describe<T>();
  return describer.hash(T::kType);
}

}  // namespace threewe::ros2
