// Detector of frozen sensors: the same reading again and again.
#pragma once

#include <optional>

#include "perception/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::perception {

/// What is known about the robot's motion, by whichever sensor.
struct Motion {
  bool moving = false;  ///< some sensor says so
  bool driven = false;  ///< it has been commanded to for some time
  bool still = false;   ///< no sensor says otherwise
  Velocity velocity{};  ///< by the wheels, in the frame of the sensor
};

/// Notices a frozen sensor. A reading that is the same is no fault where the robot stands, nor where a sensor without
/// noise looks at what does not change; so it matters whether readings have been seen to change while nothing else did,
/// and whether they have been seen to repeat themselves and go on.
class RepeatCheck {
 public:
  explicit RepeatCheck(const Params::Repeats& params = {}) : params_(params) {}
  /// True when this reading repeats those before and should not.
  bool is_frozen(const SampleData& data, const Motion& motion);

 private:
  bool is_suspect(const SampleData& data, const Motion& motion);
  bool should_have_changed(const SampleData& data, const Motion& motion) const;
  void note_change(const Motion& motion);

  Params::Repeats params_;
  std::optional<SampleData> before_;
  bool frozen_ = false;  // the newest reading
  int repeats_ = 0;      // in a row, while the robot moved
  int in_a_row_ = 0;     // whether it moved or not
  int changes_ = 0;
  int changes_at_rest_ = 0;
  bool quiet_ = false;  // readings repeat themselves where all is in order: there is no noise
};

}  // namespace threewe::perception
