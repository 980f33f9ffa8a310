#include "hardware/parameters.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

// Of the profile 3we_standard_v2, in SI units.
constexpr double kSize = 0.11;
constexpr double kSpeed = 0.5;
constexpr double kTurnRate = 1.0;
constexpr double kBraking = 4.0;
constexpr Duration kReaction = 90ms;
constexpr double kNoise = 0.01;
constexpr double kBias = 0.03;
constexpr Duration kScan = 100ms;
constexpr int kBeams = 360;

// Half of the least width of the outline. Of a convex polygon, the least width is square to one of its sides.
double size_of(const Footprint& footprint) {
  const std::vector<Vec2>& corners = footprint.corners();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 from = corners[i];
    const Vec2 side = corners[(i + 1) % corners.size()] - from;
    double width = 0.0;
    for (const Vec2& corner : corners) width = std::max(width, cross(side, corner - from));
    least = std::min(least, width / norm(side));
  }
  return 0.5 * least;
}

double stopping_distance(double speed, Duration reaction, double braking) {
  return speed * to_seconds(reaction) + 0.5 * speed * speed / braking;
}

double ratio(Duration a, Duration b) { return static_cast<double>(a.count()) / static_cast<double>(b.count()); }

// An override may change how much of something there is, not turn it into its opposite or switch it off.
bool is_alike(double value, double usual) {
  return usual > 0.0 ? value > 0.0 : usual < 0.0 ? value < 0.0 : value >= 0.0;
}

void set(const Parameter& parameter, const ParameterOverride& wanted) {
  const double usual = parameter.number();
  if (std::holds_alternative<int*>(parameter.value) && wanted.value != static_cast<int>(wanted.value))
    throw ConfigError(
        fmt::format("{}: expected a whole number, such as {}, got {}", wanted.place, usual, wanted.value));
  if (!is_alike(wanted.value, usual)) {
    const std::string_view side = usual > 0.0 ? "above" : usual < 0.0 ? "below" : "no less than";
    throw ConfigError(
        fmt::format("{}: expected a number {} 0, such as {}, got {}", wanted.place, side, usual, wanted.value));
  }
  parameter.set(wanted.value);
}

}  // namespace

Scales scales_of(const RobotProfile& profile) {
  const Limits& limits = profile.operating_limits;
  Scales scales;
  scales.size = size_of(profile.body.footprint) / kSize;
  scales.speed = limits.linear / kSpeed;
  scales.turn_rate = limits.angular / kTurnRate;
  scales.reaction = ratio(profile.reaction(), kReaction);
  scales.stopping = stopping_distance(limits.linear, profile.reaction(), limits.linear_braking) /
                    stopping_distance(kSpeed, kReaction, kBraking);
  if (!profile.lidar) return scales;
  if (profile.lidar->sigma > 0.0) scales.noise = profile.lidar->sigma / kNoise;
  if (profile.lidar->bias > 0.0) scales.bias = profile.lidar->bias / kBias;
  scales.scan = ratio(profile.lidar->turn, kScan);
  scales.beam = static_cast<double>(kBeams) / profile.lidar->beams;
  return scales;
}

void override_parameters(const Parameters& parameters, std::string_view module, const RobotProfile& profile) {
  for (const ParameterOverride& wanted : profile.autonomy) {
    if (wanted.module != module) continue;
    const auto found = std::ranges::find(parameters, wanted.name, &Parameter::name);
    if (found == parameters.end()) {
      std::vector<std::string> names;
      for (const Parameter& parameter : parameters) names.push_back(parameter.name);
      const std::string kind = fmt::format("parameter of {}", module);
      throw ConfigError(fmt::format("{}: {}", wanted.place, unknown_name(kind, wanted.name, names)));
    }
    set(*found, wanted);
  }
}

}  // namespace threewe
