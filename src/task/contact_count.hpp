// Contact counter: how often a body came to touch walls or furniture.
#pragma once

namespace threewe::task {

/// A contact begins this near [m] ...
inline constexpr double kContactBegins = 0.001;
/// ... and is over this far [m] away: sliding along a wall is one contact.
inline constexpr double kContactEnds = 0.01;

/// Contacts of an episode so far. Plain data.
struct ContactCount {
  bool touching = false;
  int contacts = 0;
  friend bool operator==(const ContactCount&, const ContactCount&) = default;
};

/// The count once the body is `clearance` [m] from the nearest obstacle.
inline ContactCount advance(ContactCount count, double clearance) {
  if (!count.touching && clearance < kContactBegins) return {true, count.contacts + 1};
  if (clearance > kContactEnds) count.touching = false;
  return count;
}

}  // namespace threewe::task
