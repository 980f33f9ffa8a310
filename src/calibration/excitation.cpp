#include "calibration/excitation.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "core/rng.hpp"
#include "hardware/limits.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/time.hpp"

namespace threewe::calibration {
namespace {

constexpr std::size_t kHalfSecond = 500ms / kControlPeriod;
constexpr double kHallsWall = 12.0;  // [m] from the start, ahead

using Legs = std::vector<Velocity>;  // each for half a second

// What the limits of a pace make of it.
std::vector<Velocity> commands_of(const RobotProfile& profile, const Legs& legs, VelocityProfile velocity_profile) {
  const Limits& limits =
      velocity_profile == VelocityProfile::operating ? profile.operating_limits : profile.hardware_limits;
  std::vector<Velocity> commands;
  Velocity last;
  for (const Velocity& leg : legs) {
    const Velocity target = within_limits(limits, leg);
    for (std::size_t i = 0; i < kHalfSecond; ++i) {
      last = velocity_profile == VelocityProfile::abrupt ? target : within_acceleration(limits, last, target);
      commands.push_back(last);
    }
  }
  return commands;
}

// The way back: all of it the other way round.
Legs and_back(Legs legs) {
  legs.emplace_back();
  for (std::size_t i = legs.size() - 1; i-- > 0;) legs.push_back({-legs[i].vx, -legs[i].vy, -legs[i].omega});
  legs.emplace_back();
  return legs;
}

// Commands that a robot of these kinematics can follow, as shares of its operating limits.
Velocity share(const RobotProfile& profile, double vx, double vy, double omega) {
  const Limits& most = profile.operating_limits;
  const double sideways = profile.kinematics() == Kinematics::holonomic ? vy * most.linear : 0.0;
  return {vx * most.linear, sideways, omega * most.angular};
}

Legs medley(const RobotProfile& profile, std::uint64_t seed, std::size_t count) {
  Legs legs;
  for (std::size_t i = 0; i < count; ++i) {
    const auto draw = [&](std::uint32_t lane) { return uniform({.seed = seed}, i, lane, -1.0, 1.0); };
    legs.push_back(share(profile, draw(0), draw(1), draw(2)));
  }
  return legs;
}

struct Named {
  const char* name;
  Legs legs;
};

std::vector<Named> plans(const RobotProfile& profile) {
  const auto at = [&](double vx, double vy, double omega) { return share(profile, vx, vy, omega); };
  std::vector<Named> plans = {
      {"step ahead", {at(1, 0, 0), at(1, 0, 0)}},
      {"ramp", {at(0.25, 0, 0), at(0.5, 0, 0), at(0.75, 0, 0), at(1, 0, 0)}},
      {"reversal", {at(0.8, 0, 0), at(-0.8, 0, 0), at(0.8, 0, 0)}},
      {"spin", {at(0, 0, 1), at(0, 0, 1), at(0, 0, -1), at(0, 0, 0.3)}},
      {"circle", {at(0.6, 0, 1), at(0.6, 0, 1), at(0.6, 0, 1), at(0.6, 0, 1)}},
      {"slalom", {at(0.8, 0, 0.8), at(0.8, 0, -0.8), at(0.8, 0, 0.8)}},
  };
  if (profile.kinematics() == Kinematics::holonomic) {
    plans.push_back({"strafe", {at(0, 0.6, 0), at(0, 0.6, 0), at(0, -0.6, 0)}});
    plans.push_back({"diagonal", {at(0.6, 0.6, 0), at(-0.6, 0.6, 0), at(0.6, 0, 0)}});
    plans.push_back({"strafing circle", {at(0, 0.6, 0.8), at(0, 0.6, 0.8), at(0, -0.6, 0.8)}});
  }
  constexpr std::uint64_t kMedleys = 8;
  for (std::uint64_t seed = 0; seed < kMedleys; ++seed) plans.push_back({"medley", medley(profile, seed, 8)});
  return plans;
}

}  // namespace

std::string test_arena() { return (asset_directories().front() / "calibration" / "test_arena.yaml").string(); }

std::vector<ExcitationSequence> standard_excitation(const RobotProfile& profile, bool with_wall) {
  // a robot that stands on casters rears up when its command changes at once
  std::vector<VelocityProfile> velocity_profiles = {VelocityProfile::operating, VelocityProfile::hardware};
  if (profile.body.casters.empty()) velocity_profiles.push_back(VelocityProfile::abrupt);
  std::vector<ExcitationSequence> sequences;
  for (const VelocityProfile velocity_profile : velocity_profiles) {
    constexpr std::array kVelocityProfiles = {"gently", "firmly", "abruptly"};
    const char* how = kVelocityProfiles[static_cast<std::size_t>(velocity_profile)];
    for (const auto& [name, legs] : plans(profile)) {
      sequences.push_back(
          {fmt::format("{}, {}", name, how), {}, commands_of(profile, and_back(legs), velocity_profile)});
    }
    if (!with_wall) continue;
    const double near = kHallsWall - 0.3 - profile.body.footprint.circumscribed_radius();
    const Legs legs(4, share(profile, 0.6, 0, 0));
    sequences.push_back({fmt::format("push, {}", how), {near, 0, 0}, commands_of(profile, legs, velocity_profile)});
  }
  return sequences;
}

std::vector<ExcitationSequence> random_sequences(const RobotProfile& profile, std::uint64_t seed, std::size_t count,
                                                 VelocityProfile velocity_profile) {
  constexpr std::size_t kLegs = 20;
  const bool sideways = profile.kinematics() == Kinematics::holonomic;
  std::vector<ExcitationSequence> sequences;
  for (std::size_t s = 0; s < count; ++s) {
    Legs legs;
    for (std::size_t i = 0; i < kLegs; ++i) {
      const auto draw = [&](std::uint32_t lane, double most) {
        return uniform({.seed = seed}, s * kLegs + i, lane, -most, most);
      };
      legs.push_back({draw(0, 0.5), sideways ? draw(1, 0.3) : 0.0, draw(2, 1.0)});
    }
    sequences.push_back({fmt::format("random {}/{}", seed, s), {}, commands_of(profile, legs, velocity_profile)});
  }
  return sequences;
}

}  // namespace threewe::calibration
