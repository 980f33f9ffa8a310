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
  return {{"margin", &p.margin, "m", Scale::noise, "kept free around the footprint in creep mode"},
          {"speed", &p.speed, "m/s", Scale::none, "of the base in creep mode"},
          {"corner_speed", &p.corner_speed, "m/s", Scale::none, "of any corner in creep mode: a touch does no harm"},
          {"sight", &p.sight, "m", Scale::size, "from the base, beyond which hits do not matter in creep mode"}};
}

Parameters parameters_of(Params::Unseen& p) {
  return {{"thin", &p.thin, "m", Scale::none, "what is thinner may stand undetected between two beams"},
          {"step", &p.step, "m", Scale::size, "along an invalid beam, from place to place that may be unobserved"}};
}

}  // namespace

Parameters parameters_of(Params& params) {
  Parameters all;
  append(all, "gate", parameters_of(params.gate));
  append(all, "creep", parameters_of(params.creep));
  append(all, "unseen", parameters_of(params.unseen));
  return all;
}

double margin_of(const RobotProfile& profile) {
  return params_for<Params>(profile, "safety").gate.margin + (profile.lidar ? profile.lidar->bias : 0.0);
}

}  // namespace threewe::safety
