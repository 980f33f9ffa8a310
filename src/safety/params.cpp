#include "safety/params.hpp"

#include "hardware/parameters.hpp"

namespace threewe::safety {
namespace {

Parameters parameters_of(Params::Gate& p) {
  return {
      {"margin", &p.margin, "m", Scale::size, "kept free around the footprint, beyond the bias of the lidar"},
      {"sensor_timeout", &p.sensor_timeout, "s", Scale::scan, "without a scan, or sonar return: the robot stops"},
      {"sweep_step", &p.sweep_step, "m", Scale::size, "from pose to pose of an arc that is checked; less costs time"}};
}

Parameters parameters_of(Params::Creep& p) {
  return {{"margin", &p.margin, "m", Scale::size,
           "kept free of what the body passes in creep mode; navigators plan with more"},
          {"speed", &p.speed, "m/s", Scale::none, "of the base in creep mode"},
          {"corner_speed", &p.corner_speed, "m/s", Scale::none, "of any corner in creep mode: a touch does no harm"},
          {"sight", &p.sight, "m", Scale::size, "from the base, beyond which hits do not matter in creep mode"},
          {"flat", &p.flat, "m", Scale::size, "around each hit, surfaces are flat: noise is averaged over them"}};
}

Parameters parameters_of(Params::Unseen& p) {
  return {{"thin", &p.thin, "m", Scale::none, "what is thinner may stand undetected between two beams"},
          {"step", &p.step, "m", Scale::size, "along an invalid beam, from place to place that may be unobserved"}};
}

Parameters parameters_of(Params::Approach& p) {
  return {
      {"since", &p.since, "s", Scale::scan, "ago, the youngest scan to compare with: range noise is less than the way"},
      {"until", &p.until, "s", Scale::scan, "ago, the oldest scan to compare with: later is sooner noticed"},
      {"least_speed", &p.least_speed, "m/s", Scale::noise, "towards the robot; less is taken for noise"},
      {"fastest", &p.fastest, "m/s", Scale::none, "predicted: what crosses the way seems faster than it is"},
      {"bearing", &p.bearing, "rad", Scale::none, "to both sides of a hit where earlier scans looked farther, too"},
      {"together", &p.together, "", Scale::none, "neighbouring hits that come nearer; fewer are noise"}};
}

}  // namespace

Parameters parameters_of(Params& params) {
  Parameters all;
  append(all, "gate", parameters_of(params.gate));
  append(all, "creep", parameters_of(params.creep));
  append(all, "unseen", parameters_of(params.unseen));
  append(all, "approach", parameters_of(params.approach));
  return all;
}

double margin_of(const RobotProfile& profile) {
  return params_for<Params>(profile, "safety").gate.margin + (profile.lidar ? profile.lidar->bias : 0.0);
}

}  // namespace threewe::safety
