#include "perception/params.hpp"

#include <doctest/doctest.h>

#include <set>
#include <string>

#include "hardware/parameters.hpp"
#include "perception/perception.hpp"

using namespace threewe;
using namespace threewe::perception;

TEST_CASE("every parameter of perception has a name of its own, and a meaning") {
  Params params;
  std::set<std::string> names;
  for (const Parameter& parameter : parameters_of(params)) {
    CAPTURE(parameter.name);
    CHECK(names.insert(parameter.name).second);
    CHECK_FALSE(parameter.meaning.empty());
  }
}

TEST_CASE("a profile sets how long a sensor may be silent") {
  const auto silent_after = [](const std::string& section) {
    const RobotProfile profile = parse_profile(load_profile("3we_standard_v2").yaml + section, "mine.yaml");
    const PerceptionModel model = make_perception_model(profile, {{"imu", SensorType::imu, 100.0}});
    Perception perception(model);
    perception.begin(model, 0ns);
    const slam::PoseEstimate pose;
    Time now{};
    while (perception.health().sensors()[0].ok() && now < Time{10s}) {
      now += kControlPeriod;
      perception.update(model, {.now = now, .samples = {}, .pose = pose, .hits = {}, .commanded = {}});
    }
    return now;
  };
  CHECK(silent_after("") == 1160ms);
  CHECK(silent_after("\nautonomy: {health: {monitor: {first_patience: 2.0}}}\n") == 2160ms);
}
