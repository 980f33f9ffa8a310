// A calibration finds what it is to find, where that is known; and where it is not told, it says so.
#include "threewe/calibration/calibrate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "calibration/fit.hpp"
#include "core/rng.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::calibration {
namespace {

std::shared_ptr<const scene::Scene> the_hall() {
  return std::make_shared<const scene::Scene>(scene::Scene::load(test_arena()));
}

/// The same robot, of which nobody knows how it really is.
RobotProfile other_than(const RobotProfile& profile) {
  RobotProfile other = profile;
  const bool mecanum = profile.kinematics() == Kinematics::holonomic;
  other.body.motor_lag = mecanum ? 40ms : 55ms;
  other.body.friction = mecanum ? 0.5 : 0.7;
  TractionSpec traction{.ahead = 0.98, .turning = 0.96, .turning_lag = 20ms, .mass_height = 0.06};
  if (mecanum) {
    traction.sideways = 0.94;
    traction.shift = 0.4;
    traction.shift_speed = 0.7;
  } else {
    traction.load = 0.65;
  }
  other.body.traction = traction;
  return other;
}

/// Noise as of an odometer, so that intervals have something to tell.
void add_noise(std::vector<Track>& tracks, std::uint64_t seed) {
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    for (std::size_t t = 0; t < tracks[i].velocities.size(); ++t) {
      Velocity& v = tracks[i].velocities[t];
      const auto draw = [&](std::uint32_t lane) { return 0.005 * normal({.seed = seed}, 10'000 * i + t, lane); };
      v = {v.vx + draw(0), v.vy + draw(1), v.omega + 3.0 * draw(2)};
    }
  }
}

RobotProfile loaded_from(const std::string& yaml) {
  const std::string file = (std::filesystem::temp_directory_path() / "threewe_fitted.yaml").string();
  std::ofstream(file) << yaml;
  RobotProfile profile = load_profile(file);
  std::filesystem::remove(file);
  return profile;
}

TEST_CASE("figures of a robot that is simulated as it is fitted are found, within their intervals") {
  for (const char* name : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(name);
    const RobotProfile profile = load_profile(name);
    const RobotProfile truly = other_than(profile);
    const Twin twin(the_hall(), Source::truth);
    auto sequences = standard_excitation(profile, true);
    std::size_t number = 0;  // a third of them will do
    std::erase_if(sequences, [&](const ExcitationSequence&) { return number++ % 3 != 0; });
    std::size_t outside = 0;
    std::size_t figures = 0;
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      CAPTURE(seed);
      std::vector<Track> tracks = twin.drive(truly, sequences);
      add_noise(tracks, seed);
      const Calibration found = fit(profile, twin, sequences, tracks, Source::truth);
      // what noise hid from it
      const auto held_out = random_sequences(profile, 1'000'000 + seed, 5, VelocityProfile::hardware);
      const auto reference = twin.drive(truly, held_out);
      CHECK(compare(profile, twin.drive(found.profile, held_out), reference).combined <
            0.2 * compare(profile, twin.drive(profile, held_out), reference).combined);
      CHECK(to_seconds(found.profile.body.motor_lag) ==
            doctest::Approx(to_seconds(truly.body.motor_lag)).epsilon(0.05));
      CHECK(found.profile.body.traction->ahead == doctest::Approx(0.98).epsilon(0.005));
      CHECK(found.profile.body.traction->turning == doctest::Approx(0.96).epsilon(0.005));
      if (profile.kinematics() == Kinematics::holonomic) {
        CHECK(found.profile.body.friction == doctest::Approx(truly.body.friction).epsilon(0.05));
        CHECK(found.profile.body.traction->shift == doctest::Approx(0.4).epsilon(0.1));
        const RobotProfile written = loaded_from(to_yaml(name, found));
        CHECK(written.body.traction->sideways == doctest::Approx(0.94).epsilon(0.01));
        CHECK(written.odometry.lateral_scale_min == 1.0);  // what is measured is not drawn as well
      }
      // a second fit from the truth itself says what each figure would be
      const Calibration from_truth = fit(truly, twin, sequences, tracks, Source::truth);
      for (std::size_t i = 0; i < found.figures.size(); ++i) {
        const double off = std::abs(found.figures[i].value - from_truth.figures[i].before);
        if (found.figures[i].identifiable && off > 2.0 * found.figures[i].spread) ++outside;
        ++figures;
      }
    }
    CHECK(outside <= figures / 6);  // of intervals twice as wide
  }
}

TEST_CASE("what wheels alone do not tell is said to be hardly told") {
  const RobotProfile profile = load_profile("turtlebot_like");
  const Twin twin(the_hall(), Source::sensors);
  // slow straight lines: no wheel slips, and nothing turns
  std::vector<ExcitationSequence> sequences = {{"straight", {}, std::vector<Velocity>(200, Velocity{0.05, 0.0, 0.0})}};
  std::vector<Track> tracks = twin.drive(other_than(profile), sequences);
  add_noise(tracks, 1);
  const Calibration found = fit(profile, twin, sequences, tracks, Source::sensors);
  for (const Figure& figure : found.figures) {
    CAPTURE(figure.name);
    if (figure.name == "traction.turning" || figure.name == "traction.turning_lag" || figure.name == "traction.load") {
      CHECK_FALSE(figure.identifiable);
      CHECK(figure.value == doctest::Approx(figure.before).epsilon(0.01));
    }
    if (figure.name == "motor_lag") CHECK(figure.identifiable);
  }
}

TEST_CASE("a calibration is a profile that loads, and drives as it was fitted") {
  const Calibration found = calibrate("mock", "turtlebot_like");
  CHECK(found.source == Source::truth);
  const RobotProfile loaded = loaded_from(to_yaml("turtlebot_like", found));
  REQUIRE(loaded.body.traction);
  CHECK(loaded.body.friction == doctest::Approx(found.profile.body.friction).epsilon(1e-4));
  CHECK(loaded.body.traction->load == doctest::Approx(found.profile.body.traction->load).epsilon(1e-4));
  CHECK(loaded.lidar->points_per_turn == 230);
  CHECK(loaded.body.casters.size() == 1);
  const std::vector<RobotProfile> profiles = {load_profile("turtlebot_like"), loaded};
  const auto apart = deviations("mock", "turtlebot_like", profiles, 1'000'000, 4, VelocityProfile::operating);
  CHECK(apart[0].combined < 1e-12);
  CHECK(apart[0].farthest_pose < 1e-12);
  CHECK(apart[1].combined < 0.05);
  CHECK(repeatability("mock", "turtlebot_like", 1'000'000, 2, VelocityProfile::abrupt).combined <
        0.03);  // its battery is emptier
}

TEST_CASE("commands keep to their pace") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  for (const auto& sequence : random_sequences(profile, 1'000'000, 50, VelocityProfile::operating)) {
    REQUIRE(sequence.commands.size() == 500);
    for (std::size_t t = 1; t < sequence.commands.size(); ++t) {
      const Velocity& a = sequence.commands[t - 1];
      const Velocity& b = sequence.commands[t];
      CHECK(std::hypot(b.vx - a.vx, b.vy - a.vy) <= 4.0 * 0.02 + 1e-9);
      CHECK(std::abs(b.omega - a.omega) <= 6.0 * 0.02 + 1e-9);
    }
  }
  CHECK_THROWS_AS(calibrate("mujco", "3we_standard_v2"), ConfigError);
}

}  // namespace
}  // namespace threewe::calibration
