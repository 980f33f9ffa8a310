#include "threewe/models/localization.hpp"

#include <array>
#include <cstddef>
#include <limits>

#include "core/config.hpp"
#include "core/exact.hpp"
#include "models/localization_error.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::models {
namespace {

// Bounds that no robot indoors leaves: they catch wrong units, such as millimetres or degrees.
constexpr double kMaxError = 1.0;         // [m], [rad] or [m/m]
constexpr double kShortestLength = 0.01;  // [m]
constexpr double kMaxHours = 1e6;
constexpr int kMaxEpisodes = 1'000'000;

LocalizationSpec::Map read_map(ConfigNode node) {
  LocalizationSpec::Map map;
  map.turn = node.number_in("turn", 0.0, kMaxError);
  map.stretch = node.number_in("stretch", 0.0, kMaxError);
  map.heading = node.number_in("heading", 0.0, kMaxError);
  map.length = node.number_in("length", kShortestLength, kFarthest);
  node.finish();
  return map;
}

LocalizationSpec::Local read_local(ConfigNode node) {
  LocalizationSpec::Local local;
  local.position = node.number_in("position", 0.0, kMaxError);
  local.length = node.number_in("length", kShortestLength, kFarthest);
  node.finish();
  return local;
}

LocalizationSpec::Noise read_noise(ConfigNode node) {
  LocalizationSpec::Noise scatter;
  scatter.position = node.number_in("position", 0.0, kMaxError);
  scatter.heading = node.number_in("heading", 0.0, kMaxError);
  node.finish();
  return scatter;
}

LocalizationSpec::Measurement read_measurement(ConfigNode node) {
  LocalizationSpec::Measurement measured;
  measured.commit = node.text("commit");
  measured.hardware = node.text("hardware");
  measured.noise = node.text("noise");
  for (const ConfigNode& scene : node.at("scenes").items()) measured.scenes.push_back(scene.text());
  measured.seed = static_cast<std::uint64_t>(node.number_in("seed", 0.0, std::numeric_limits<std::uint32_t>::max()));
  measured.episodes = node.integer_in("episodes", 1, kMaxEpisodes);
  measured.hours = node.number_in("hours", 0.0, kMaxHours);
  measured.kilometres = node.number_in("kilometres", 0.0, kMaxHours);
  node.finish();
  return measured;
}

// The draws of one correction; the order is part of the recorded format.
enum Draw : std::uint8_t { kTurn, kStretch, kHeading, kLocalX, kLocalY, kScatterX, kScatterY, kScatterHeading, kDraws };

// Nearly normal with deviation 1: the sum of four bytes. What is slow adds up many of them.
double bell(std::uint32_t bits) {
  const std::uint32_t pairs = (bits & 0x00FF00FFU) + (bits >> 8 & 0x00FF00FFU);
  const auto sum = static_cast<double>((pairs & 0xFFFFU) + (pairs >> 16));
  constexpr double kMean = 510.0;
  constexpr double kPerDeviation = 0.006765875086793227;  // 1 / sqrt(4 * (256^2 - 1) / 12)
  return (sum - kMean) * kPerDeviation;
}

std::array<double, kDraws> draw(const RngKey& key, std::uint64_t correction) {
  static_assert(kDraws % 4 == 0, "a block of random bits is four draws");
  std::array<double, kDraws> draws{};
  std::size_t count = 0;
  for (std::uint32_t block = 0; count < kDraws; ++block) {
    for (const std::uint32_t bits : random_bits(key, correction, block)) draws[count++] = bell(bits);
  }
  return draws;
}

// A Gauss-Markov process over distance: how much of its value stays, and how much of its deviation comes anew.
struct Step {
  double kept;
  double fresh;
};

Step step_over(double moved, double length) {
  // exp(-x), for small steps by its series, within 3e-7
  const double x = moved / length;
  const double kept = x < 0.125 ? 1.0 - x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0))) : exact::exp(-x);
  return {kept, exact::sqrt(1.0 - kept * kept)};
}

}  // namespace

LocalizationSpec load_localization(std::string_view name) {
  const auto file = find_asset("localization", name);
  ConfigNode root = ConfigNode::load(file);
  LocalizationSpec spec;
  spec.name = file.stem().string();
  spec.description = root.text("description");
  spec.period = from_seconds(root.number_in("period", 0.001, 10.0));
  spec.delay = from_seconds(root.number_in("delay", 0.0, 10.0));
  spec.map = read_map(root.at("map"));
  spec.local = read_local(root.at("local"));
  spec.noise = read_noise(root.at("noise"));
  spec.measured = read_measurement(root.at("measured"));
  root.finish();
  return spec;
}

std::vector<std::string> localization_names() { return asset_names("localization"); }

void correct_localization(const LocalizationSpec& spec, const RngKey& key, std::uint64_t correction,
                          const Pose2D& truth, const Pose2D& odom_from_base, LocalizationState& state) {
  const std::array<double, kDraws> draws = draw(key, correction);

  // the slow part changes with what the robot has moved
  const double moved = distance(truth.position(), state.position);
  const Step map = step_over(moved, spec.map.length);
  const Step local = step_over(moved, spec.local.length);
  state.turn = map.kept * state.turn + spec.map.turn * map.fresh * draws[kTurn];
  state.stretch = map.kept * state.stretch + spec.map.stretch * map.fresh * draws[kStretch];
  state.heading = map.kept * state.heading + spec.map.heading * map.fresh * draws[kHeading];
  state.local = {local.kept * state.local.x + spec.local.position * local.fresh * draws[kLocalX],
                 local.kept * state.local.y + spec.local.position * local.fresh * draws[kLocalY]};
  state.position = truth.position();

  // turned and stretched by little, about the start
  const double along = state.stretch * truth.x - state.turn * truth.y;
  const double across = state.turn * truth.x + state.stretch * truth.y;
  state.map_from_base.x = truth.x + (along + state.local.x + spec.noise.position * draws[kScatterX]);
  state.map_from_base.y = truth.y + (across + state.local.y + spec.noise.position * draws[kScatterY]);
  state.map_from_base.theta =
      wrap_angle(truth.theta + (state.turn + state.heading + spec.noise.heading * draws[kScatterHeading]));
  state.odom_from_base = odom_from_base;
  state.map_from_odom = exact::sincos(state.map_from_base.theta - odom_from_base.theta);
}

Pose2D localized_pose(const LocalizationState& state, const Pose2D& odom_from_base) {
  // the same as map_from_odom * odom_from_base, without rounding where the odometer has not moved
  const auto [s, c] = state.map_from_odom;
  const Vec2 way = odom_from_base.position() - state.odom_from_base.position();
  const Vec2 moved{c * way.x - s * way.y, s * way.x + c * way.y};
  return {state.map_from_base.x + moved.x, state.map_from_base.y + moved.y,
          wrap_angle(state.map_from_base.theta + (odom_from_base.theta - state.odom_from_base.theta))};
}

}  // namespace threewe::models
