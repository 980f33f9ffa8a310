#include "perception/stamp_check.hpp"

#include <algorithm>

namespace threewe::perception {
SensorFault StampCheck::check(Time measured, Time received) {
  if (measured > received) return SensorFault::wrong_stamps;
  const Duration age = received - measured;
  if (arrivals_ > 0 && measured <= newest_) return SensorFault::wrong_stamps;
  if (arrivals_ < params_.first) {
    usual_age_ = arrivals_ == 0 ? age : std::min(usual_age_, age);
    if (arrivals_ == 0 || received != arrived_) ++arrivals_;
    arrived_ = received;
    newest_ = measured;
    return SensorFault::none;
  }
  if (age < usual_age_ - params_.younger) return SensorFault::wrong_stamps;
  newest_ = measured;
  if (age > usual_age_ + params_.older) return SensorFault::late;
  usual_age_ += (age - usual_age_) / params_.follows;
  return SensorFault::none;
}

}  // namespace threewe::perception
