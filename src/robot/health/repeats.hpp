// Does a sensor deliver the same reading again and again?
#pragma once

#include <optional>

#include "threewe/core/samples.hpp"

namespace threewe::health {

/// What is known about the robot's motion, by whom it does not matter.
struct Motion {
  bool moving = false;  ///< somebody says so
  bool driven = false;  ///< it has been told to for some time
  bool still = false;   ///< nobody says otherwise
};

/// Notices a frozen sensor. A reading that is the same is no fault where the robot stands, nor where a sensor without
/// noise looks at what does not change; so it matters whether readings have been seen to change while nothing else did.
class RepeatCheck {
 public:
  /// True when this reading repeats those before and should not.
  bool is_frozen(const SampleData& data, const Motion& motion);

 private:
  bool should_have_changed(const SampleData& data, const Motion& motion) const;

  std::optional<SampleData> before_;
  int repeats_ = 0;  // in a row, while the robot moved
  int changes_ = 0;
  int changes_at_rest_ = 0;
};

}  // namespace threewe::health
