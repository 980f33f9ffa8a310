// One step of a drive, written once for a number and for a vector of them. For kernels, after highway-inl.hpp, or after
// <hwy/highway.h> for the plain form. What each function means stands in drive.hpp and battery.hpp.
#if defined(THREEWE_MODELS_DRIVE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_MODELS_DRIVE_INL
#undef THREEWE_MODELS_DRIVE_INL
#else
#define THREEWE_MODELS_DRIVE_INL
#endif

#include "core/pose-inl.hpp"
#include "models/battery.hpp"
#include "models/drive.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::models::HWY_NAMESPACE {

namespace lanes = threewe::lanes::HWY_NAMESPACE;
using threewe::HWY_NAMESPACE::VelocityOf;

template <class V>
struct WheelsOf {
  V at[4];
};

template <class V>
struct ChargeOf {
  V voltage;
  V current;
  V charge;
};

/// `wheel_speeds`, by what is worked out beforehand.
template <class V>
HWY_INLINE WheelsOf<V> roll_at(const DriveOf<V>& drive, const VelocityOf<V>& velocity) {
  const V turn = drive.turn_arm * velocity.omega;
  const V side = drive.sideways * velocity.vy;
  const V rear = drive.sideways * drive.turns_per_metre;
  return {{(velocity.vx - side - turn) * drive.turns_per_metre, (velocity.vx + side + turn) * drive.turns_per_metre,
           (velocity.vx + side - turn) * rear, (velocity.vx - side + turn) * rear}};
}

/// `body_velocity`, likewise.
template <class V>
HWY_INLINE VelocityOf<V> rolling_velocity(V roll, V roll_turn, V sideways, const WheelsOf<V>& speeds) {
  const auto& [a, b, c, d] = speeds.at;
  const V left = a + c;
  const V right = b + d;
  const V zero = lanes::number<V>(0.0);
  return {roll * (left + right), lanes::where(sideways == zero, zero, roll * ((b + c) - (a + d))),
          roll_turn * (right - left)};
}

template <class V>
HWY_INLINE V drive_motor(V per_no_load_speed, V response, V stall_change, V speed, V setpoint, V supply, V share) {
  const V one = lanes::number<V>(1.0);
  const V minus_one = lanes::number<V>(-1.0);
  const V wanted = response * (setpoint - speed);
  // the torque-speed line, either way; beyond the speed that its supply gives a motor brakes, and the driver's
  // current limit caps all of it
  const V ratio = speed * per_no_load_speed;
  const V forwards = stall_change * lanes::clamp(supply - ratio, minus_one, one);
  const V backwards = stall_change * lanes::clamp(supply + ratio, minus_one, one);
  return speed + share * lanes::clamp(wanted, minus_one * backwards, forwards);
}

template <class V>
HWY_INLINE VelocityOf<V> limit_by_friction(V turn_weight, V given, const VelocityOf<V>& body,
                                           const VelocityOf<V>& rolling) {
  const VelocityOf<V> change{rolling.vx - body.vx, rolling.vy - body.vy, rolling.omega - body.omega};
  // a torque is measured by the force that it takes at the wheels
  const V turning = change.omega * turn_weight;
  const V needed = lanes::root(change.vx * change.vx + change.vy * change.vy + turning * turning);
  const auto holds = needed <= given;
  if (lanes::all<V>(holds)) return rolling;
  const V share = given / needed;
  return {lanes::where(holds, rolling.vx, body.vx + share * change.vx),
          lanes::where(holds, rolling.vy, body.vy + share * change.vy),
          lanes::where(holds, rolling.omega, body.omega + share * change.omega)};
}

template <class V>
HWY_INLINE V drive_power(const DriveOf<V>& drive, V mass, const VelocityOf<V>& before, const VelocityOf<V>& after,
                         const VelocityOf<V>& rolling) {
  const V accelerating = (after.vx - before.vx) * rolling.vx + (after.vy - before.vy) * rolling.vy +
                         drive.inertia_arm_squared * (after.omega - before.omega) * rolling.omega;
  const V resisting = drive.resistance * lanes::root(rolling.vx * rolling.vx + rolling.vy * rolling.vy);
  return mass * (accelerating * drive.per_step + resisting);
}

template <class V>
HWY_INLINE V supply_ratio(const BatteryOf<V>& battery, const ChargeOf<V>& state) {
  const V zero = lanes::number<V>(0.0);
  const V ratio = lanes::where(state.charge <= zero, zero, state.voltage * battery.per_nominal);
  return lanes::where(battery.present == zero, lanes::number<V>(1.0), ratio);
}

template <class V>
HWY_INLINE ChargeOf<V> drain_battery(const BatteryOf<V>& battery, V resistance, V drive_power, V seconds,
                                     const ChargeOf<V>& state) {
  const V zero = lanes::number<V>(0.0);
  const V half = lanes::number<V>(0.5);
  const V power = battery.idle_power + lanes::larger(drive_power, zero) * battery.per_efficiency;
  const V open_circuit = battery.voltage_empty + battery.voltage_span * state.charge;
  // the power fixes the product of current and voltage; the voltage of the step before is near enough to go on from
  V current = power / state.voltage;
  // beyond half its voltage a battery gives less power, not more
  const auto too_much = current * resistance > half * open_circuit;
  if (lanes::any<V>(too_much)) current = lanes::where(too_much, half * open_circuit / resistance, current);
  const V voltage = open_circuit - current * resistance;
  const V charge = lanes::larger(state.charge - open_circuit * current * seconds * battery.per_capacity, zero);

  const auto absent = battery.present == zero;
  return {lanes::where(absent, state.voltage, voltage), lanes::where(absent, state.current, current),
          lanes::where(absent, state.charge, charge)};
}

}  // namespace threewe::models::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
