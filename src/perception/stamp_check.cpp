#include "perception/stamp_check.hpp"

#include <algorithm>

namespace threewe::perception {
namespace {

constexpr Duration kYounger = 50ms;  // than usual: no sensor measures before it has measured
constexpr Duration kOlder = 200ms;   // than usual: what has changed since may matter
constexpr int kSlowly = 32;          // samples over which the usual age follows
constexpr int kFew = 5;              // arrivals; some may have waited for somebody to ask: the youngest counts

}  // namespace

SensorFault StampCheck::check(Time measured, Time received) {
  if (measured > received) return SensorFault::wrong_stamps;
  const Duration age = received - measured;
  if (arrivals_ > 0 && measured <= newest_) return SensorFault::wrong_stamps;
  if (arrivals_ < kFew) {
    usual_age_ = arrivals_ == 0 ? age : std::min(usual_age_, age);
    if (arrivals_ == 0 || received != arrived_) ++arrivals_;
    arrived_ = received;
    newest_ = measured;
    return SensorFault::none;
  }
  if (age < usual_age_ - kYounger) return SensorFault::wrong_stamps;
  newest_ = measured;
  if (age > usual_age_ + kOlder) return SensorFault::late;
  usual_age_ += (age - usual_age_) / kSlowly;
  return SensorFault::none;
}

}  // namespace threewe::perception
