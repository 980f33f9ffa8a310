#include "threewe/calibration/calibrate.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "calibration/fit.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::calibration {
namespace {

// A backend's robot in the hall, connected.
std::unique_ptr<backend::World> connect(std::string_view backend, const std::string& hardware) {
  auto world = backend::make_world(backend, {.scene = test_arena(), .robots = {hardware}, .noise = NoiseLevel::ideal});
  world->robot(0).connect();
  return world;
}

Source source_of(backend::World& world) { return world.truth_service() != nullptr ? Source::truth : Source::sensors; }

Twin twin_of(backend::World& world) {
  return {std::make_shared<const scene::Scene>(scene::Scene::load(test_arena())), source_of(world)};
}

// "traction.load" is the field `load` of `traction`.
void set(YAML::Node body, const std::string& name, double value) {
  const std::string text = fmt::format("{:.5g}", value);
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos) {
    body[name] = text;
  } else {
    body[name.substr(0, dot)][name.substr(dot + 1)] = text;
  }
}

// Wheels alone do not tell how far a body slips aside.
bool measures_sideways(const Calibration& calibration) {
  return calibration.source == Source::truth && std::ranges::any_of(calibration.figures, [](const Figure& figure) {
           return figure.name == "traction.sideways" && figure.identifiable;
         });
}

}  // namespace

Calibration calibrate(std::string_view backend, const std::string& hardware) {
  const RobotProfile profile = load_profile(hardware);
  const auto world = connect(backend, hardware);
  const auto sequences = standard_excitation(profile, world->robot(0).features().can_reset);
  const std::vector<Track> tracks = drive(*world, sequences);
  return fit(profile, twin_of(*world), sequences, tracks, source_of(*world));
}

std::string to_yaml(const std::string& hardware, const Calibration& calibration) {
  YAML::Node root = YAML::LoadFile(find_asset("robots", hardware).string());
  YAML::Node body = root["body"];
  for (const Figure& figure : calibration.figures) set(body, figure.name, figure.value);
  if (!body["traction"]["load"]) set(body, "traction.load", 1.0);
  if (measures_sideways(calibration)) {
    // what stood for it before it was measured
    YAML::Node scale = root["sensors"]["odometry"]["lateral_scale"];
    scale[0] = "1.0";
    scale[1] = "1.0";
  }
  YAML::Emitter out;
  out << root;
  std::string text = fmt::format("# {} as `threewe calibrate` measured it, by {} of {:.0f} s:\n", hardware,
                                 to_string(calibration.source), calibration.seconds);
  for (const auto& [name, before, value, spread, identifiable] : calibration.figures) {
    text += fmt::format("#   {:22} {:8.5g} +- {:.2g}{}\n", name, value, spread,
                        identifiable ? "" : " (hardly identifiable)");
  }
  return text + out.c_str() + "\n";
}

std::vector<Deviation> deviations(std::string_view backend, const std::string& hardware,
                                  std::span<const RobotProfile> profiles, std::uint64_t seed, std::size_t count,
                                  VelocityProfile velocity_profile) {
  const auto world = connect(backend, hardware);
  const auto sequences = random_sequences(load_profile(hardware), seed, count, velocity_profile);
  const std::vector<Track> reference = drive(*world, sequences);
  const Twin twin = twin_of(*world);
  std::vector<Deviation> deviations;
  for (const RobotProfile& profile : profiles) {
    deviations.push_back(compare(profile, twin.drive(profile, sequences), reference));
  }
  return deviations;
}

Deviation repeatability(std::string_view backend, const std::string& hardware, std::uint64_t seed, std::size_t count,
                        VelocityProfile velocity_profile) {
  constexpr std::size_t kSecond = 1s / kControlPeriod;
  constexpr Velocity kCrawl{0.0237, 0.0, 0.0};  // so far that no roller of a mecanum wheel is where another was
  const RobotProfile profile = load_profile(hardware);
  const auto world = connect(backend, hardware);
  const auto sequences = random_sequences(profile, seed, count, velocity_profile);
  auto later = sequences;
  for (ExcitationSequence& sequence : later) {
    sequence.commands.insert(sequence.commands.begin(), kSecond, Velocity{});
    sequence.commands.insert(sequence.commands.begin(), kSecond, kCrawl);
  }
  const std::vector<Track> tracks = drive(*world, sequences);
  std::vector<Track> again = drive(*world, later);
  for (Track& track : again) {
    track.poses.clear();
    track.velocities.erase(track.velocities.begin(), track.velocities.begin() + 2 * kSecond);
  }
  return compare(profile, again, tracks);
}

}  // namespace threewe::calibration
