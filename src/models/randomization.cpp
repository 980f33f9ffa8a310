#include "threewe/models/randomization.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "core/config.hpp"
#include "core/exact.hpp"
#include "core/names.hpp"
#include "core/rng.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::models {
namespace {

// A knob, and the bounds beyond which a simulation makes no sense; they catch wrong units.
struct Knob {
  const char* name;
  double Variation::* number;  // null: part of the camera's offset
  double low;
  double high;
  bool steady = false;  // for a whole episode
};

// A new one goes to the end: draws follow from the place.
constexpr std::array kKnobs{
    Knob{"mass", &Variation::mass, 0.2, 5.0},
    Knob{"friction", &Variation::friction, 0.05, 5.0},
    Knob{"motor_lag", &Variation::motor_lag, 0.1, 10.0},
    Knob{"motor_noise", &Variation::motor_noise, 0.0, 1.0},
    Knob{"battery_charge", &Variation::battery_charge, 0.0, 1.0, true},
    Knob{"battery_resistance", &Variation::battery_resistance, 0.0, 10.0},
    Knob{"lidar_noise", &Variation::lidar_noise, 0.0, 10.0},
    Knob{"lidar_dropout", &Variation::lidar_dropout, 0.0, 50.0},
    Knob{"imu_noise", &Variation::imu_noise, 0.0, 10.0},
    Knob{"camera_noise", &Variation::camera_noise, 0.0, 10.0},
    Knob{"odometry_slip", &Variation::odometry_slip, 0.0, 10.0, true},
    Knob{"command_latency", &Variation::command_latency, 0.0, kMostLatency, true},
    Knob{"sensor_latency", &Variation::sensor_latency, 0.0, kMostLatency, true},
    Knob{"light", &Variation::light, 0.0, 5.0},
    Knob{"exposure", &Variation::exposure, 0.0, 5.0},
    Knob{"color_jitter", &Variation::color_jitter, 0.0, 1.0},
    Knob{"texture", &Variation::texture, 0.0, 1e6, true},
    Knob{"camera_x", nullptr, -0.2, 0.2, true},
    Knob{"camera_y", nullptr, -0.2, 0.2, true},
    Knob{"camera_yaw", nullptr, -0.5, 0.5, true},
    Knob{"camera_height", &Variation::camera_height, -0.2, 0.5, true},
    Knob{"detail", &Variation::detail, 0.0, 1.0, true},
};

// What is drawn at the three events are different samples of one stream; an environment's startup is no episode.
constexpr std::uint32_t kStartup = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kIntervals = 1U << 20U;  // samples of their lengths begin here
constexpr std::uint32_t kLanes = 4;              // for each knob

std::size_t find_knob(const ConfigNode& node, const std::string& name) {
  const auto& names = knob_names();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) node.fail(unknown_name("knob", name, names));
  return static_cast<std::size_t>(found - names.begin());
}

// A number; [low, high]; or one of the other distributions by its name.
Distribution read_distribution(ConfigNode node, const Knob& knob) {
  using Kind = Distribution::Kind;
  const auto pair = [&](const ConfigNode& list, Kind kind) {
    const auto items = list.items(2);
    if (items.size() != 2) list.fail("two numbers are needed");
    const bool is_normal = kind == Kind::normal;
    const double a = items[0].number_in(knob.low, knob.high);
    const double b = is_normal ? items[1].number_in(0.0, knob.high - knob.low) : items[1].number_in(a, knob.high);
    if (kind == Kind::log_uniform && a <= 0.0) list.fail("log_uniform needs a lower bound above 0");
    if (kind == Kind::integer && (a != std::floor(a) || b != std::floor(b))) list.fail("integer needs whole numbers");
    return Distribution{kind, a, b};
  };
  if (node.is_number()) {
    const double value = node.number_in(knob.low, knob.high);
    return {Kind::constant, value, value};
  }
  if (node.is_list()) return pair(node, Kind::uniform);
  Distribution distribution;
  for (const auto& [name, kind] : {std::pair{"uniform", Kind::uniform}, std::pair{"log_uniform", Kind::log_uniform},
                                   std::pair{"normal", Kind::normal}, std::pair{"integer", Kind::integer}}) {
    if (node.has(name)) distribution = pair(node.at(name), kind);
  }
  node.finish();
  if (distribution.kind == Kind::constant) {
    node.fail("a number, [low, high], or one of uniform, log_uniform, normal and integer is needed");
  }
  return distribution;
}

std::vector<RandomizedKnob> read_event(const ConfigNode& node, bool during_episodes = false) {
  std::vector<RandomizedKnob> knobs;
  for (const auto& [name, value] : node.fields()) {
    if (name == "every") continue;
    const std::size_t place = find_knob(value, name);
    if (during_episodes && kKnobs[place].steady) {
      value.fail("stays as it is for an episode: draw it at startup or at reset");
    }
    knobs.push_back({place, read_distribution(value, kKnobs[place])});
  }
  return knobs;
}

Randomization read(ConfigNode root, const std::string& name) {
  constexpr double kLongest = 3600.0;  // [s]
  Randomization randomization;
  randomization.name = name;
  randomization.description = root.text("description", "");
  if (root.has("startup")) randomization.startup = read_event(root.at("startup"));
  if (root.has("reset")) randomization.reset = read_event(root.at("reset"));
  if (root.has("interval")) {
    ConfigNode interval = root.at("interval");
    randomization.interval = read_event(interval, true);
    const auto every = interval.at("every").items(2);
    if (every.size() != 2) interval.fail("every: [shortest, longest] [s] is needed");
    const double shortest = every[0].number_in(to_seconds(kControlPeriod), kLongest);
    randomization.shortest_interval = from_seconds(shortest);
    randomization.longest_interval = from_seconds(every[1].number_in(shortest, kLongest));
  }
  root.finish();
  return randomization;
}

double draw(const RandomizedKnob& drawn, const RngKey& key, std::uint64_t sample) {
  const Knob& knob = kKnobs[drawn.knob];
  const auto lane = static_cast<std::uint32_t>(drawn.knob) * kLanes;
  const auto& [kind, a, b] = drawn.distribution;
  switch (kind) {
    case Distribution::Kind::constant: return a;
    case Distribution::Kind::uniform: return uniform(key, sample, lane, a, b);
    case Distribution::Kind::log_uniform: return exact::exp(uniform(key, sample, lane, exact::log(a), exact::log(b)));
    case Distribution::Kind::normal: return std::clamp(a + b * normal(key, sample, lane), knob.low, knob.high);
    case Distribution::Kind::integer: return std::floor(uniform(key, sample, lane, a, b + 1.0));
  }
  return a;
}

void draw_all(std::span<const RandomizedKnob> knobs, const RngKey& key, std::uint64_t sample, Variation& variation) {
  for (const RandomizedKnob& drawn : knobs) knob(variation, drawn.knob) = draw(drawn, key, sample);
}

}  // namespace

const std::vector<std::string>& knob_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Knob& knob : kKnobs) all.emplace_back(knob.name);
    return all;
  }();
  return names;
}

double& knob(Variation& variation, std::size_t place) {
  if (const auto number = kKnobs[place].number) return variation.*number;
  const std::string& name = knob_names()[place];
  if (name == "camera_x") return variation.camera_offset.x;
  return name == "camera_y" ? variation.camera_offset.y : variation.camera_offset.theta;
}

double knob(const Variation& variation, std::size_t place) {
  Variation copy = variation;
  return knob(copy, place);
}

Randomization load_randomization(std::string_view name) {
  const auto file = find_asset("randomization", name);
  return read(ConfigNode::load(file), file.stem().string());
}

Randomization parse_randomization(const std::string& text, const std::string& name) {
  return read(ConfigNode::parse(text, name), name);
}

std::vector<std::string> randomization_names() { return asset_names("randomization"); }

Variation draw_variation(const Randomization& randomization, std::uint64_t seed, std::uint32_t episode,
                         std::size_t robot, std::uint64_t draw) {
  RngKey key{.seed = seed, .robot = static_cast<std::uint16_t>(robot), .stream = Stream::randomization};
  Variation variation;
  key.episode = kStartup;
  draw_all(randomization.startup, key, 0, variation);
  key.episode = episode;
  draw_all(randomization.reset, key, 0, variation);
  if (draw > 0) draw_all(randomization.interval, key, draw, variation);
  return variation;
}

Duration draw_interval(const Randomization& randomization, std::uint64_t seed, std::uint32_t episode,
                       std::uint64_t draw) {
  if (randomization.interval.empty()) return Duration::zero();
  const RngKey key{.seed = seed, .episode = episode, .stream = Stream::randomization};
  const double seconds = uniform(key, kIntervals + draw, 0, to_seconds(randomization.shortest_interval),
                                 to_seconds(randomization.longest_interval));
  const Duration exact = from_seconds(seconds);
  return std::max(exact - exact % kControlPeriod, kControlPeriod);
}

}  // namespace threewe::models
