// Detector of wrong stamps and late samples.
#pragma once

#include "perception/params.hpp"
#include "threewe/core/time.hpp"
#include "threewe/perception/percepts.hpp"

namespace threewe::perception {

/// Learns how old readings are when they arrive, and notices when they are not. Plain data.
class StampCheck {
 public:
  explicit StampCheck(const Params::Stamps& params = {}) : params_(params) {}
  SensorFault check(Time measured, Time received);

 private:
  Params::Stamps params_;
  int arrivals_ = 0;  // of samples in order, up to those that are needed
  Time arrived_{};    // the newest of them
  Time newest_{};     // when it was measured
  Duration usual_age_{};
};

}  // namespace threewe::perception
