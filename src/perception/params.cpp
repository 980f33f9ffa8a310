#include "perception/params.hpp"

namespace threewe::perception {
namespace {

Parameters parameters_of(Params::Monitor& p) {
  return {
      {"least_patience", &p.least_patience, "s", Scale::none, "without a sample, however often a sensor delivers"},
      {"first_patience", &p.first_patience, "s", Scale::none, "more for the first sample after connecting"},
      {"ok_after", &p.ok_after, "s", Scale::none, "without a fault, after which a sensor is believed again"},
      {"first_penalty", &p.first_penalty, "s", Scale::none, "that a contradicted sensor is not believed"},
      {"longest_penalty", &p.longest_penalty, "s", Scale::none, "the same where it was contradicted again and again"},
      {"contradiction", &p.contradiction, "", Scale::none, "standard deviations by which wheels and gyro differ"},
      {"standing", &p.standing, "m/s", Scale::speed, "by the wheels, below which the robot stands"},
      {"standing_turn", &p.standing_turn, "rad/s", Scale::turn_rate, "the same of turning"},
      {"turning", &p.turning, "rad/s", Scale::none, "by the gyro, which its bias never reaches: the robot turns"}};
}

Parameters parameters_of(Params::Scan& p) {
  return {
      {"fewest_beams", &p.fewest_beams, "", Scale::none, "that hit something in both of two scans to compare"},
      {"noisy", &p.noisy, "", Scale::none, "times the usual noise, above which a scan is noisy"},
      {"follows", &p.follows, "", Scale::none, "share of each scan in the usual noise"},
      {"shift", &p.shift, "m", Scale::bias, "beyond the way driven, by which all ranges change at a fault"},
      {"agree", &p.agree, "m", Scale::noise, "by which beams may differ from a shift that they agree on"},
      {"most_beams", &p.most_beams, "", Scale::none, "share of the beams that agree on a shift, at least"},
      {"back", &p.back, "", Scale::none, "share of a shift that may be left where ranges jump back"},
      {"believed_after", &p.believed_after, "s", Scale::none, "of a shift: ranges are taken to be right after all"}};
}

Parameters parameters_of(Params::Blind& p) {
  return {
      {"near", &p.near, "m", Scale::size, "beyond what is too near to be measured: may be too near in the next scans"},
      {"bearing", &p.bearing, "rad", Scale::none, "to both sides of what is too near, where beams may be invalid"}};
}

Parameters parameters_of(Params::Stamps& p) {
  return {{"younger", &p.younger, "s", Scale::none, "than usual on arrival: a stamp is wrong"},
          {"older", &p.older, "s", Scale::none, "than usual on arrival: a sample is late"},
          {"follows", &p.follows, "", Scale::none, "samples over which the usual age follows"},
          {"first", &p.first, "", Scale::none, "arrivals that settle the usual age"}};
}

Parameters parameters_of(Params::Repeats& p) {
  return {
      {"lively", &p.lively, "", Scale::none, "changes at rest, after which readings are known to have noise"},
      {"lively_on_way", &p.lively_on_way, "", Scale::none, "changes of a sonar, at rest or not, with the same effect"},
      {"noise", &p.noise, "m", Scale::noise, "standard deviation of ranges, below which a lidar has no noise"},
      {"slope", &p.slope, "", Scale::none, "sine between surface and motion, above which ranges must change"},
      {"steep", &p.steep, "", Scale::none, "share of the beams that hit such surfaces, at least"},
      {"moves", &p.moves, "m/s", Scale::speed, "by the wheels, above which their pose must change"},
      {"turns", &p.turns, "rad/s", Scale::turn_rate, "above which poses and ranges must change"},
      {"quiet", &p.quiet, "", Scale::none, "equal readings in a row, then others: there is no noise"}};
}

Parameters parameters_of(Params::Turn& p) {
  return {{"window", &p.window, "s", Scale::none, "over which wheels and gyro are compared"},
          {"longest_step", &p.longest_step, "s", Scale::none, "that a sample stands for"},
          {"sigma", &p.sigma, "rad/s", Scale::none, "standard deviation of the difference where nothing changes"},
          {"turn_sigma", &p.turn_sigma, "", Scale::none, "more of it for each rad/s of turning: wheels slip"},
          {"jerk_sigma", &p.jerk_sigma, "", Scale::none, "more of it for each rad/s by which turning changes"},
          {"push_sigma", &p.push_sigma, "rad/m", Scale::none, "more of it for each m/s by which the speed changes"},
          {"walk", &p.walk, "rad^2/s^2", Scale::none, "by which the factors' variances grow in a window"},
          {"small", &p.small, "rad/s", Scale::turn_rate, "a difference that does no harm"},
          {"learnable", &p.learnable, "", Scale::none, "standard deviations, above which nothing is learned"},
          {"twice", &p.twice, "", Scale::none, "standard deviations that count for more in two windows in a row"},
          {"wear", &p.wear, "", Scale::none, "times the data sheet's errors of wheels and gyro: they are not new"},
          {"least_scale", &p.least_scale, "", Scale::none, "share of the radius by which a robot's tyres differ"},
          {"zero_offset", &p.zero_offset, "rad/s", Scale::none, "bias of a gyro that was not zeroed"},
          {"lag", &p.lag, "s", Scale::none, "of a gyro's filter, or of a wheel's"}};
}

Parameters parameters_of(Params::Drive& p) {
  return {{"speed_off", &p.speed_off, "m/s", Scale::speed, "from what was commanded, over half a second"},
          {"turn_off", &p.turn_off, "rad/s", Scale::turn_rate, "the same of turning"},
          {"share_off", &p.share_off, "", Scale::none, "more, as a share of the command: motors lag and slip"},
          {"latest", &p.latest, "", Scale::none, "delay at which a command may come about, in that of the data sheet"},
          {"settling", &p.settling, "", Scale::none, "periods after which a command has come about"},
          {"driving", &p.driving, "m/s", Scale::speed, "commanded, above which the robot must move"},
          {"driving_turn", &p.driving_turn, "rad/s", Scale::turn_rate, "the same of turning"},
          {"motor_limit", &p.motor_limit, "", Scale::none, "share of the no-load speed that a weak motor may be at"}};
}

Parameters parameters_of(Params::Slip& p) {
  return {{"least_way", &p.least_way, "m", Scale::noise, "between two corrections of the pose that are compared"},
          {"taken_back", &p.taken_back, "", Scale::none, "share of the way that the corrections take back"},
          {"added", &p.added, "", Scale::none, "share of the way that the corrections add"},
          {"significance", &p.significance, "", Scale::none, "standard deviations of the corrections' sum"}};
}

Parameters parameters_of(Params::People& p) {
  return {
      {"farthest", &p.farthest, "m", Scale::none, "beyond which legs are too few beams"},
      {"free_by", &p.free_by, "m", Scale::none, "that a scan looked farther where something has come since"},
      {"youngest_view", &p.youngest_view, "s", Scale::none, "before the newest scan but one, that looked through"},
      {"views_through", &p.views_through, "", Scale::none, "scans that looked through: thin legs are missed at times"},
      {"link", &p.link, "m", Scale::none, "between neighbouring hits of one blob"},
      {"link_beams", &p.link_beams, "", Scale::none, "more of it, in distances between two beams"},
      {"widest", &p.widest, "m", Scale::none, "a person"},
      {"leg_width", &p.leg_width, "m", Scale::none, "a leg, at most"},
      {"stride", &p.stride, "m", Scale::none, "between the middles of two legs, at most"},
      {"stands_free", &p.stands_free, "m", Scale::none, "by which what is next to a person is farther"},
      {"leg_radius", &p.leg_radius, "m", Scale::none, "from the surface of a leg to its middle"},
      {"sigma", &p.sigma, "m", Scale::none, "standard deviation of a blob's middle: at times one leg is seen"},
      {"acceleration", &p.acceleration, "m/s^2", Scale::none, "of people, standard deviation over a second"},
      {"first_speed", &p.first_speed, "m/s", Scale::none, "standard deviation of a velocity that is unknown"},
      {"gate", &p.gate, "", Scale::none, "of assignments: 99 % of a chi-square with two degrees of freedom"},
      {"unmoved_penalty", &p.unmoved_penalty, "", Scale::none, "of what has not moved, in the same measure"},
      {"largest_gate", &p.largest_gate, "m", Scale::none, "of assignments"},
      {"sightings", &p.sightings, "", Scale::none, "after which a track may be a person"},
      {"walked", &p.walked, "m", Scale::none, "after which a track may be a person"},
      {"slowest", &p.slowest, "m/s", Scale::none, "a person who walks"},
      {"misses", &p.misses, "", Scale::none, "in a row, which end a track that is no person yet"},
      {"unseen", &p.unseen, "s", Scale::none, "which ends the track of a person"},
      {"standing", &p.standing, "s", Scale::none, "after which a person is an obstacle like others"},
      {"same_place", &p.same_place, "m", Scale::none, "nearer than which tracks are one"}};
}

Parameters parameters_of(Params::Sonar& p) {
  return {{"trusted", &p.trusted, "m", Scale::none, "beyond which an arc is so wide that it would close doors"},
          {"middle", &p.middle, "", Scale::none, "share of the cone that a return shows to be free"},
          {"before_arc", &p.before_arc, "m", Scale::none, "that is left out before an arc: more than a cell"},
          {"arc_spacing", &p.arc_spacing, "m", Scale::size, "between the points of an arc that the gate sees"},
          {"hit", &p.hit, "", Scale::none, "evidence of a return, which makes an obstacle"},
          {"pass", &p.pass, "", Scale::none, "evidence of a return from beyond: two unmake an obstacle"},
          {"most", &p.most, "", Scale::none, "evidence of an obstacle"},
          {"least", &p.least, "", Scale::none, "evidence of free space"},
          {"explained", &p.explained, "m", Scale::none, "by which sonar and lidar may differ who see one thing"},
          {"explained_bearing", &p.explained_bearing, "rad", Scale::none, "the same beyond the cone"},
          {"far", &p.far, "m", Scale::stopping, "beyond which what sonar alone detects is not in the way yet"},
          {"near", &p.near, "m", Scale::stopping, "the same without a lidar"}};
}

Parameters parameters_of(Params::Bump& p) {
  return {{"push", &p.push, "m/s^2", Scale::none, "that no tyre gives on a hard floor"},
          {"outside", &p.outside, "m", Scale::size, "off the outline, where what was bumped into stands"},
          {"half_width", &p.half_width, "m", Scale::size, "of what was bumped into"}};
}

}  // namespace

Parameters parameters_of(Params& params) {
  Parameters all;
  append(all, "monitor", parameters_of(params.monitor));
  append(all, "scan", parameters_of(params.scan));
  append(all, "blind", parameters_of(params.blind));
  append(all, "stamps", parameters_of(params.stamps));
  append(all, "repeats", parameters_of(params.repeats));
  append(all, "turn", parameters_of(params.turn));
  append(all, "drive", parameters_of(params.drive));
  append(all, "slip", parameters_of(params.slip));
  append(all, "people", parameters_of(params.people));
  append(all, "sonar", parameters_of(params.sonar));
  append(all, "bump", parameters_of(params.bump));
  return all;
}

}  // namespace threewe::perception
