// A vector holds one quantity of as many robots as it has lanes. States and constants lie in memory robot by robot, and
// are taken over four numbers at a time: four of each robot become four vectors.
#include "sim/drive_kernel.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/drive_kernel.cpp"
#include "core/highway-inl.hpp"
//
#include "core/pose-inl.hpp"
#include "hardware/limits-inl.hpp"
#include "models/drive-inl.hpp"
#include "models/odometry-inl.hpp"
#include "models/traction-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::kernel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
namespace lanes = threewe::lanes::HWY_NAMESPACE;
namespace formulae = threewe::models::HWY_NAMESPACE;
using threewe::HWY_NAMESPACE::Pose2DOf;
using threewe::HWY_NAMESPACE::VelocityOf;

using Doubles = hn::CappedTag<double, 8>;
using V = hn::Vec<Doubles>;
constexpr std::size_t kLanes = hn::MaxLanes(Doubles());

// Four numbers in a row.
constexpr std::size_t kRow = 4 * sizeof(double);
// What begins with these rows in a state, see `RobotState`.
constexpr std::size_t kPose = offsetof(RobotState, pose);
constexpr std::size_t kLateral = offsetof(RobotState, wheel_errors) + offsetof(models::WheelErrors, lateral);
constexpr std::size_t kTraction = offsetof(RobotState, traction);
constexpr std::size_t kReading = offsetof(RobotState, odometry) + offsetof(models::OdometryState, reading);
constexpr std::size_t kRead = offsetof(RobotState, odometry) + offsetof(models::OdometryState, read);
constexpr std::size_t kNoise = kTraction + offsetof(models::Traction, motor_noise);

// Where something of each robot begins in memory.
using Places = std::array<std::byte*, kLanes>;

// The robots of one vector. Lanes without a robot of their own compute what the first does, and write it nowhere.
struct Group {
  std::array<const Driver*, kLanes> drivers;
  Places states;       // to read from
  Places next_states;  // to write to
  Places driven;
};

#if HWY_TARGET != HWY_SCALAR
using Pair = hn::Full128<double>;

// Pairs of every second robot from `robot` on, `first` bytes behind its place.
HWY_INLINE V load_pairs(const Places& places, std::size_t robot, std::size_t first) {
  const auto pair = [&](std::size_t i) {
    return hn::LoadU(Pair(), reinterpret_cast<const double*>(places[robot + 2 * i] + first));
  };
#if HWY_MAX_BYTES >= 64
  const hn::Half<Doubles> half;
  return hn::Combine(Doubles(), hn::Combine(half, pair(3), pair(2)), hn::Combine(half, pair(1), pair(0)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(Doubles(), pair(1), pair(0));
#else
  return pair(0);
#endif
}

HWY_INLINE void store_pairs(V pairs, const Places& places, std::size_t robot, std::size_t first) {
  const auto store = [&](hn::Vec<Pair> pair, std::size_t i) {
    hn::StoreU(pair, Pair(), reinterpret_cast<double*>(places[robot + 2 * i] + first));
  };
#if HWY_MAX_BYTES >= 64
  const hn::Half<Doubles> half;
  const auto low = hn::LowerHalf(half, pairs);
  const auto high = hn::UpperHalf(half, pairs);
  store(hn::LowerHalf(Pair(), low), 0);
  store(hn::UpperHalf(Pair(), low), 1);
  store(hn::LowerHalf(Pair(), high), 2);
  store(hn::UpperHalf(Pair(), high), 3);
#elif HWY_MAX_BYTES >= 32
  store(hn::LowerHalf(Pair(), pairs), 0);
  store(hn::UpperHalf(Pair(), pairs), 1);
#else
  store(pairs, 0);
#endif
}
#endif

// Four numbers of every robot, `first` bytes behind its place.
HWY_INLINE void gather(const Places& places, std::size_t first, V& a, V& b, V& c, V& d) {
#if HWY_TARGET == HWY_SCALAR
  const auto* row = reinterpret_cast<const double*>(places[0] + first);
  a = hn::LoadU(Doubles(), row);
  b = hn::LoadU(Doubles(), row + 1);
  c = hn::LoadU(Doubles(), row + 2);
  d = hn::LoadU(Doubles(), row + 3);
#else
  const V ab_even = load_pairs(places, 0, first);
  const V ab_odd = load_pairs(places, 1, first);
  const V cd_even = load_pairs(places, 0, first + kRow / 2);
  const V cd_odd = load_pairs(places, 1, first + kRow / 2);
  a = hn::InterleaveLower(Doubles(), ab_even, ab_odd);
  b = hn::InterleaveUpper(Doubles(), ab_even, ab_odd);
  c = hn::InterleaveLower(Doubles(), cd_even, cd_odd);
  d = hn::InterleaveUpper(Doubles(), cd_even, cd_odd);
#endif
}

// The way back.
HWY_INLINE void scatter(const Places& places, std::size_t first, V a, V b, V c, V d) {
#if HWY_TARGET == HWY_SCALAR
  auto* row = reinterpret_cast<double*>(places[0] + first);
  hn::StoreU(a, Doubles(), row);
  hn::StoreU(b, Doubles(), row + 1);
  hn::StoreU(c, Doubles(), row + 2);
  hn::StoreU(d, Doubles(), row + 3);
#else
  store_pairs(hn::InterleaveLower(Doubles(), a, b), places, 0, first);
  store_pairs(hn::InterleaveUpper(Doubles(), a, b), places, 1, first);
  store_pairs(hn::InterleaveLower(Doubles(), c, d), places, 0, first + kRow / 2);
  store_pairs(hn::InterleaveUpper(Doubles(), c, d), places, 1, first + kRow / 2);
#endif
}

// Of plain data; what is const is only read.
template <class T>
HWY_INLINE std::byte* bytes_of(const T& data) {
  return reinterpret_cast<std::byte*>(const_cast<T*>(&data));
}

// What stays the same from step to step.
struct Constants {
  models::DriveOf<V> drive;
  models::TractionModelOf<V> traction_model;
  bool pulls;  // whether any of them has a measured traction: only then is there a `traction_model`
  models::BatteryOf<V> battery;
};

HWY_INLINE Constants constants_of(const Group& group) {
  Constants constants;
  auto& [drive, traction_model, pulls, battery] = constants;
  V unused;
  Places drives;
  Places tractions;
  Places batteries;
  pulls = false;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const RobotModel& robot = *group.drivers[i]->robot;
    drives[i] = bytes_of(robot.drive);
    tractions[i] = bytes_of(robot.traction_model);
    batteries[i] = bytes_of(robot.battery);
    pulls = pulls || robot.traction_model.present != 0.0;
  }
  gather(drives, 0, drive.turns_per_metre, drive.turn_arm, drive.sideways, drive.roll);
  gather(drives, kRow, drive.roll_turn, drive.linear_limit, drive.angular_limit, drive.per_no_load_speed);
  gather(drives, 2 * kRow, drive.turn_weight, drive.inertia_arm_squared, drive.resistance, drive.per_step);
  gather(batteries, 0, battery.present, battery.voltage_empty, battery.voltage_span, battery.per_nominal);
  gather(batteries, offsetof(models::Battery, per_nominal), unused, battery.idle_power, battery.per_efficiency,
         battery.per_capacity);
  if (pulls) {
    gather(tractions, 0, traction_model.present, traction_model.ahead, traction_model.sideways, traction_model.turning);
    gather(tractions, kRow, traction_model.turn_inertia, traction_model.hold, traction_model.load,
           traction_model.shift);
    gather(tractions, 2 * kRow, traction_model.per_shift_speed, traction_model.pitch, traction_model.rear_pitch,
           traction_model.roll);
    gather(tractions, 3 * kRow, traction_model.wheel_share, unused, unused, unused);
  }
  return constants;
}

// What each motor gives of its torque.
HWY_INLINE formulae::WheelsOf<V> motor_shares(const Group& group, V noise) {
  const V one = lanes::number<V>(1.0);
  formulae::WheelsOf<V> shares{{one, one, one, one}};
  if (!lanes::any<V>(noise != lanes::number<V>(0.0))) return shares;
  std::array<std::array<double, 4>, kLanes> own;
  Places places;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const RobotState& state = *group.drivers[i]->state;
    own[i] = models::motor_shares(state.traction, state.key(Stream::motor), state.steps);
    places[i] = bytes_of(own[i]);
  }
  gather(places, 0, shares.at[0], shares.at[1], shares.at[2], shares.at[3]);
  return shares;
}

template <class Mask>
HWY_INLINE VelocityOf<V> where(Mask mask, const VelocityOf<V>& yes, const VelocityOf<V>& no) {
  return {lanes::where(mask, yes.vx, no.vx), lanes::where(mask, yes.vy, no.vy),
          lanes::where(mask, yes.omega, no.omega)};
}

// Of those whose wheels spin freely once they slip: what became of wheels and body, in place of what is there.
HWY_INLINE void pull_freely(const Constants& constants, const formulae::GivenOf<V>& given, V lateral,
                            const VelocityOf<V>& command, const VelocityOf<V>& carried, formulae::WheelsOf<V>& wheels,
                            VelocityOf<V>& rolling, VelocityOf<V>& after) {
  const auto& drive = constants.drive;
  const formulae::TractionStepOf<V> pulled =
      formulae::push_body(drive, constants.traction_model, given, lateral, command, carried);
  const auto own = constants.traction_model.present != lanes::number<V>(0.0);
  const VelocityOf<V> spun = formulae::rolling_velocity(drive.roll, drive.roll_turn, drive.sideways, pulled.wheels);
  for (std::size_t i = 0; i < 4; ++i) wheels.at[i] = lanes::where(own, pulled.wheels.at[i], wheels.at[i]);
  rolling = where(own, spun, rolling);
  after = where(own, pulled.body, after);
}

HWY_INLINE void drive_group(const Group& group, const Constants& constants) {
  const auto& [drive, traction_model, pulls, battery] = constants;
  const V seconds = lanes::number<V>(to_seconds(kStep));

  V unused;

  // the firmware takes a command within the hardware limits
  VelocityOf<V> command;
  Places commands;
  HWY_ALIGN double floors[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) {
    commands[i] = bytes_of(*group.drivers[i]->command);
    floors[i] = group.drivers[i]->floor;
  }
  gather(commands, 0, command.vx, command.vy, command.omega, unused);
  command = threewe::HWY_NAMESPACE::within_limits(drive.linear_limit, drive.angular_limit, command);

  // motors turn the wheels
  V lateral;
  V response;
  V stall_change;
  V friction_change;
  V mass;
  V noise;
  V turn_response;
  V resistance;
  formulae::ChargeOf<V> charge;
  formulae::WheelsOf<V> wheels;
  formulae::WheelsOf<V> angles;
  gather(group.states, kLateral, lateral, charge.voltage, charge.current, charge.charge);
  gather(group.states, kTraction, response, stall_change, friction_change, mass);
  gather(group.states, kNoise, noise, turn_response, resistance, unused);
  gather(group.states, offsetof(RobotState, wheel_speeds), wheels.at[0], wheels.at[1], wheels.at[2], wheels.at[3]);
  gather(group.states, offsetof(RobotState, wheel_angles), angles.at[0], angles.at[1], angles.at[2], angles.at[3]);
  const formulae::WheelsOf<V> setpoints = formulae::roll_at(drive, command);
  const formulae::WheelsOf<V> shares = motor_shares(group, noise);
  const V supply = formulae::supply_ratio(battery, charge);
  for (std::size_t i = 0; i < 4; ++i) {
    wheels.at[i] = formulae::drive_motor(drive.per_no_load_speed, response, stall_change, wheels.at[i], setpoints.at[i],
                                         supply, shares.at[i]);
  }

  // momentum keeps its direction while the body turns beneath it
  Pose2DOf<V> pose;
  VelocityOf<V> carried;
  V max_collision_speed;
  V distance_driven;
  gather(group.states, kPose, pose.x, pose.y, pose.theta, carried.vx);
  gather(group.states, kPose + kRow, carried.vy, carried.omega, max_collision_speed, distance_driven);
  const auto linear =
      threewe::HWY_NAMESPACE::rotate(carried.vx, carried.vy, lanes::number<V>(-to_seconds(kStep)) * carried.omega);
  carried = {linear.x, linear.y, carried.omega};

  // wheels pull the body
  const V given = hn::Load(Doubles(), floors) * friction_change;
  VelocityOf<V> rolling = formulae::rolling_velocity(drive.roll, drive.roll_turn, drive.sideways, wheels);
  rolling.vy = rolling.vy * lateral;
  VelocityOf<V> after = formulae::limit_by_friction(drive.turn_weight, given, carried, rolling);
  if (pulls) {
    pull_freely(constants, {response, turn_response, stall_change, given, supply, shares}, lateral, command, carried,
                wheels, rolling, after);
  }
  for (std::size_t i = 0; i < 4; ++i) angles.at[i] = angles.at[i] + seconds * wheels.at[i];
  scatter(group.next_states, offsetof(RobotState, wheel_speeds), wheels.at[0], wheels.at[1], wheels.at[2],
          wheels.at[3]);
  scatter(group.next_states, offsetof(RobotState, wheel_angles), angles.at[0], angles.at[1], angles.at[2],
          angles.at[3]);

  // and the battery pays
  const V power = formulae::drive_power(drive, mass, carried, after, rolling);
  charge = formulae::drain_battery(battery, resistance, power, seconds, charge);
  scatter(group.next_states, kLateral, lateral, charge.voltage, charge.current, charge.charge);

  const Pose2DOf<V> end = threewe::HWY_NAMESPACE::integrate(pose, after, seconds);
  const V dx = pose.x - end.x;
  const V dy = pose.y - end.y;
  distance_driven = distance_driven + lanes::root(dx * dx + dy * dy);
  scatter(group.driven, 0, end.x, end.y, end.theta, after.vx);
  scatter(group.driven, kRow, after.vy, after.omega, max_collision_speed, distance_driven);
  scatter(group.driven, 2 * kRow, carried.vx, carried.vy, carried.omega, lateral);
}

HWY_INLINE Group group_from(std::span<const Driver> drivers, std::span<Driven> driven, std::byte* nowhere) {
  Group group;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const bool own = i < drivers.size();
    group.drivers[i] = &drivers[own ? i : 0];
    group.states[i] = bytes_of(*group.drivers[i]->state);
    group.next_states[i] = own ? group.states[i] : nowhere;
    group.driven[i] = own && !driven.empty() ? bytes_of(driven[i]) : nowhere;
  }
  return group;
}

HWY_INLINE bool same_models(const Group& a, const Group& b) {
  bool same = true;
  for (std::size_t i = 0; i < kLanes; ++i) same = same && a.drivers[i]->robot == b.drivers[i]->robot;
  return same;
}

void drive_all(std::span<const Driver> drivers, std::span<Driven> driven) {
  if (drivers.empty()) return;
  std::array<std::byte, kLateral + kRow> nowhere;
  Group group = group_from(drivers, driven, nowhere.data());
  Constants constants = constants_of(group);
  drive_group(group, constants);
  for (std::size_t first = kLanes; first < drivers.size(); first += kLanes) {
    const Group before = group;
    group = group_from(drivers.subspan(first), driven.subspan(first), nowhere.data());
    if (!same_models(group, before)) constants = constants_of(group);
    drive_group(group, constants);
  }
}

HWY_INLINE void measure_group(const Group& group) {
  Places odometers;
  for (std::size_t i = 0; i < kLanes; ++i) odometers[i] = bytes_of(group.drivers[i]->robot->odometer);
  models::OdometerOf<V> odometer;
  V unused;
  gather(odometers, 0, odometer.count, odometer.counts_per_radian, odometer.per_period, odometer.roll);
  gather(odometers, kRow / 2, unused, odometer.roll, odometer.roll_turn, odometer.sideways);

  formulae::WheelsOf<V> angles;
  formulae::WheelsOf<V> scales;
  formulae::WheelsOf<V> read;
  gather(group.states, offsetof(RobotState, wheel_angles), angles.at[0], angles.at[1], angles.at[2], angles.at[3]);
  gather(group.states, offsetof(RobotState, wheel_errors), scales.at[0], scales.at[1], scales.at[2], scales.at[3]);
  gather(group.states, kRead, read.at[0], read.at[1], read.at[2], read.at[3]);
  formulae::WheelsOf<V> rolled;
  for (std::size_t i = 0; i < 4; ++i) {
    const V angle = formulae::encoder_angle(odometer, angles.at[i]);
    rolled.at[i] = scales.at[i] * (angle - read.at[i]);
    read.at[i] = angle;
  }

  Pose2DOf<V> pose;
  gather(group.states, kReading, pose.x, pose.y, pose.theta, unused);
  const VelocityOf<V> velocity = formulae::move_on(odometer, rolled, pose);
  scatter(group.next_states, kReading, pose.x, pose.y, pose.theta, velocity.vx);
  scatter(group.next_states, kReading + kRow, velocity.vy, velocity.omega, read.at[0], read.at[1]);
  scatter(group.next_states, kRead, read.at[0], read.at[1], read.at[2], read.at[3]);
}

void measure_all(std::span<const Driver> drivers) {
  std::array<std::byte, kRead + kRow> nowhere;
  for (std::size_t first = 0; first < drivers.size(); first += kLanes) {
    measure_group(group_from(drivers.subspan(first), {}, nowhere.data()));
  }
}

}  // namespace threewe::sim::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::kernel {

HWY_EXPORT(drive_all);
HWY_EXPORT(measure_all);

static_assert(offsetof(models::Traction, motor_noise) + 2 * sizeof(double) == sizeof(models::Traction) &&
                  offsetof(RobotState, battery_resistance) ==
                      offsetof(RobotState, traction) + sizeof(models::Traction) &&
                  offsetof(RobotState, battery) == offsetof(RobotState, wheel_errors) + sizeof(models::WheelErrors) &&
                  offsetof(RobotState, distance_driven) == offsetof(RobotState, pose) + 7 * sizeof(double) &&
                  offsetof(models::OdometryState, read) == 6 * sizeof(double) &&
                  sizeof(Driven) == 12 * sizeof(double) && sizeof(models::TractionModel) == 16 * sizeof(double),
              "the kernel takes over rows of four numbers, in this order");

void drive(std::span<const Driver> drivers, std::span<Driven> driven) {
  assert(drivers.size() == driven.size());
  HWY_DYNAMIC_DISPATCH(drive_all)(drivers, driven);
}

void measure_odometry(std::span<const Driver> drivers) { HWY_DYNAMIC_DISPATCH(measure_all)(drivers); }

}  // namespace threewe::sim::kernel
#endif
