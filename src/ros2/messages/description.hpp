// Message descriptions: what kinds of member a ROS 2 message may have, and the distributions whose layouts differ.
//
// A message is a struct with a name and one list of its members, in the order of the wire:
//
//   struct Twist {
//     static constexpr std::string_view kType = "geometry_msgs/msg/Twist";
//     Vector3 linear, angular;
//     static void members(auto& self, auto&& member) {
//       member("linear", self.linear);
//       member("angular", self.angular);
//     }
//   };
//
// Reading and writing CDR, the type hash and every bound on sizes follow from that list. A member that only some
// distributions have stands behind a question to `member.layout`.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace threewe::ros2 {

/// The releases of ROS 2 whose layouts we know, oldest first.
enum class Distribution : std::uint8_t { humble, jazzy, kilted };
/// All of them.
inline constexpr std::array kDistributions{Distribution::humble, Distribution::jazzy, Distribution::kilted};
/// Serves messages whose layout is the same in all of them.
inline constexpr Distribution kAnyLayout = Distribution::jazzy;
/// Its name, such as "jazzy".
std::string_view to_string(Distribution distribution);

/// A text of at most N characters. On the wire it is as any text; in a type's hash it is not.
template <std::size_t N>
struct BoundedString : std::string {
  using std::string::string;
  static constexpr std::size_t kCapacity = N;
};

/// A struct with a name and a list of members.
template <typename T>
concept Message = requires {
  { T::kType } -> std::convertible_to<std::string_view>;
};

/// One number, truth value or byte.
template <typename T>
concept Primitive = std::is_arithmetic_v<T> || std::same_as<T, std::byte>;

/// A text, of any length or bounded.
template <typename T>
concept Text = std::derived_from<T, std::string>;

/// A sequence of any length.
template <typename T>
inline constexpr bool kIsSequence = false;
template <typename T>
inline constexpr bool kIsSequence<std::vector<T>> = true;

/// A fixed number of elements: an array, or a view of the first elements of a longer one.
template <typename T>
struct FixedArray {
  static constexpr std::size_t kSize = 0;
};
template <typename T, std::size_t N>
struct FixedArray<std::array<T, N>> {
  using Element = T;
  static constexpr std::size_t kSize = N;
};
template <typename T, std::size_t N>
struct FixedArray<std::span<T, N>> {
  using Element = std::remove_const_t<T>;
  static constexpr std::size_t kSize = N;
};
template <typename T>
concept IsFixedArray = FixedArray<T>::kSize > 0;

}  // namespace threewe::ros2
