#include "slam/params.hpp"

#include "threewe/map/occupancy_grid.hpp"

namespace threewe::slam {
namespace {

Parameters parameters_of(Params::DeadReckoning& p) {
  return {
      {"sample_age", &p.sample_age, "s", Scale::none,
       "for which a sample stands: then wheels tell turns, or all is guessed"},
      {"extrapolation", &p.extrapolation, "s", Scale::none, "beyond the newest odometry the pose is held"},
      {"disagreement", &p.disagreement, "rad", Scale::none, "of wheels and gyro from scan to scan that is usual"},
      {"turning_disagreement", &p.turning_disagreement, "rad/rad", Scale::none, "more of it as the robot turns"},
      {"standing_samples", &p.standing_samples, "", Scale::none, "of wheels at rest, after which the robot stands"},
  };
}

Parameters parameters_of(Params::Filter& p) {
  return {
      {"forward_slip", &p.forward_slip, "m^2/m", Scale::size,
       "variance along the way by wheels: more trusts scans more"},
      {"lateral_slip", &p.lateral_slip, "m^2/m", Scale::size, "variance across the way by wheels"},
      {"turn_slip", &p.turn_slip, "m/sqrt(rad)", Scale::size, "the base wanders while it turns"},
      {"gyro_scale", &p.gyro_scale, "rad/sqrt(rad)", Scale::none, "random error of a turn by gyro"},
      {"wheel_turn", &p.wheel_turn, "rad/sqrt(rad)", Scale::none, "random error of a turn by wheels alone"},
      {"scale_walk", &p.scale_walk, "1/sqrt(m)", Scale::none, "how fast wheels may change: more forgets calibration"},
      {"range_walk", &p.range_walk, "m^2/m", Scale::size, "how fast the lidar's bias may change"},
      {"scan_position", &p.scan_position, "m", Scale::size, "error of deskewing and stamps, with each scan"},
      {"scan_heading", &p.scan_heading, "rad", Scale::none, "the same of the heading"},
      {"bias_creep", &p.bias_creep, "rad/s", Scale::none, "of the gyro's bias, unnoticed while the robot drove"},
      {"bias_jump", &p.bias_jump, "", Scale::none, "standard deviations of a change that is a fault, and not learned"},
  };
}

Parameters parameters_of(Params::Matching& p) {
  return {
      {"residual", &p.residual, "m", Scale::noise, "distance of a hit from its surface: more trusts odometry more"},
      {"robust_width", &p.robust_width, "m", Scale::noise, "hits farther from their surface count little"},
      {"usual_noise", &p.usual_noise, "m", Scale::noise, "of a range; with a noisier lidar both grow in proportion"},
      {"reach", &p.reach, "", Scale::none,
       "times a range's standard deviation: so far from a hit its surface is looked for"},
      {"spot_size", &p.spot_size, "m", Scale::noise, "hits of less extent are a spot, not a line"},
      {"surface_distance", &p.surface_distance, "m", Scale::size, "a hit this near to a surface agrees with the map"},
      {"viewing_angle", &p.viewing_angle, "rad", Scale::none, "between views of a surface that tell the range bias"},
      {"observed", &p.observed, "", Scale::none,
       "times the noise of normals: a direction of less information is left to odometry, as along a corridor"},
      {"free_position", &p.free_position, "m", Scale::size, "prior of a scan that decides alone"},
      {"free_heading", &p.free_heading, "rad", Scale::none, "the same of its heading"},
      {"free_bias", &p.free_bias, "m", Scale::bias, "the same of its range bias"},
  };
}

Parameters parameters_of(Params::Registration& p) {
  return {
      {"poor_agreement", &p.poor_agreement, "", Scale::none, "below this share of hits the surroundings are searched"},
      {"good_agreement", &p.good_agreement, "", Scale::none, "from this share on a scan confirms a pose by itself"},
      {"least_agreement", &p.least_agreement, "", Scale::none, "below this share a scan is a misfit"},
      {"few_hits", &p.few_hits, "", Scale::none, "in known space: fewer tell nothing"},
      {"known_share", &p.known_share, "", Scale::none, "of hits in known space that can confirm a pose"},
      {"few_known_share", &p.few_known_share, "", Scale::none, "with fewer, beams through walls make a misfit"},
      {"through_walls", &p.through_walls, "", Scale::none, "share of beams through walls that makes it one"},
      {"before_wall", &p.before_wall, "m", Scale::size, "a beam that ends so near behind a wall has hit it"},
      {"search_position", &p.search_position, "m", Scale::size, "searched to each side of the prediction"},
      {"search_heading", &p.search_heading, "rad", Scale::none, "the same of the heading"},
      {"widest_position", &p.widest_position, "m", Scale::size, "searched where lost or guessed: costs its square"},
      {"widest_heading", &p.widest_heading, "rad", Scale::none, "the same of the heading"},
      {"unsure_heading", &p.unsure_heading, "rad", Scale::none, "standard deviation from which on it is searched"},
      {"better_poor", &p.better_poor, "", Scale::none,
       "agreement by which a pose or motion must be better than the estimated one"},
      {"better", &p.better, "", Scale::none, "the same where only the heading is unsure"},
      {"pushed", &p.pushed, "m", Scale::size,
       "off the pose of a robot at rest, that a scan must fit before it counts as pushed"},
      {"pushed_turn", &p.pushed_turn, "rad", Scale::none, "the same of its heading"},
      {"fading", &p.fading, "", Scale::none, "of the agreement that is expected at rest, a scan"},
      {"poor_lidar", &p.poor_lidar, "", Scale::none, "times its data sheet a lidar may be noisy without more bias"},
      {"least_noise", &p.least_noise, "m", Scale::noise, "taken for what a data sheet that promises less says"},
  };
}

Parameters parameters_of(Params::Mapping& p) {
  return {
      {"distance", &p.distance, "m", Scale::size, "the map takes a scan after so much motion: less costs time"},
      {"turn", &p.turn, "rad", Scale::none, "or turning"},
      {"age", &p.age, "s", Scale::none, "or time, in which things move"},
      {"free_range", &p.free_range, "m", Scale::size, "beams clear nothing beyond: less costs less"},
  };
}

Parameters parameters_of(Params::Localization& p) {
  return {
      {"blind_after", &p.blind_after, "s", Scale::scan, "without a scan, wheels and gyro go on alone"},
      {"start", &p.start, "s", Scale::none, "standing, after which the gyro's bias is known"},
      {"lost_after", &p.lost_after, "s", Scale::scan, "without a scan that fits, the robot is lost"},
      {"lost_at_once_after", &p.lost_at_once_after, "s", Scale::scan, "the same if none even resembles the map"},
      {"lost_agreement", &p.lost_agreement, "", Scale::none, "share of hits below which a scan does not"},
      {"doubtful_prior", &p.doubtful_prior, "", Scale::none, "agreement with a prior map below which it is doubted"},
      {"certain_prior", &p.certain_prior, "", Scale::none, "agreement with it above which it no longer is"},
      {"doubt_share", &p.doubt_share, "", Scale::none, "of one scan in these: more doubts sooner"},
      {"initial_position", &p.initial_position, "m", Scale::size, "standard deviation of an initial pose"},
      {"initial_heading", &p.initial_heading, "rad", Scale::none, "the same of its heading"},
      {"found_position", &p.found_position, "m", Scale::size, "standard deviation of a pose found by search"},
      {"found_heading", &p.found_heading, "rad", Scale::none, "the same of its heading"},
      {"redrawn_position", &p.redrawn_position, "m", Scale::size, "standard deviation of the pose in a redrawn map"},
      {"redrawn_heading", &p.redrawn_heading, "rad", Scale::none, "the same of its heading"},
      {"prior_position", &p.prior_position, "m", Scale::size, "standard deviation of a prior map against the world"},
      {"prior_heading", &p.prior_heading, "rad", Scale::none, "the same of its heading"},
  };
}

Parameters parameters_of(Params::OdometryCheck& p) {
  return {
      {"jump", &p.jump, "m", Scale::size, "a step of the odometry that changes by more is doubted"},
      {"turn_jump", &p.turn_jump, "rad", Scale::none, "the same of a turn"},
      {"most_speed", &p.most_speed, "m/s", Scale::speed, "no robot between walls is faster"},
      {"most_turn_rate", &p.most_turn_rate, "rad/s", Scale::turn_rate, "no robot between walls turns faster"},
      {"shortest_interval", &p.shortest_interval, "s", Scale::none, "stamps of old logs come in bursts"},
      {"most_extrapolation", &p.most_extrapolation, "", Scale::none,
       "times the interval before: afterwards the motion is unknown"},
      {"steady_distance", &p.steady_distance, "m", Scale::size, "by which a guessed step may be off"},
      {"steady_turn", &p.steady_turn, "rad", Scale::none, "the same of a turn"},
      {"steady_share", &p.steady_share, "", Scale::none, "and this share of either"},
      {"moved", &p.moved, "m", Scale::size, "by scans alone, while odometry stands: it has stopped"},
      {"turned", &p.turned, "rad", Scale::none, "the same of a turn"},
      {"moved_chi", &p.moved_chi, "", Scale::none, "and so many variances of what the scan says"},
      {"frozen_distance", &p.frozen_distance, "m", Scale::size, "by odometry, while scans repeat: the lidar froze"},
      {"frozen_turn", &p.frozen_turn, "rad", Scale::none, "the same of a turn"},
      {"usual_share", &p.usual_share, "", Scale::none, "more: gets used to worse scans sooner"},
      {"least_of_usual", &p.least_of_usual, "", Scale::none, "more: calls scans sooner that agree less than usual"},
      {"compared_distance", &p.compared_distance, "m", Scale::size, "of steps that are compared with scans' at once"},
      {"scale_distance", &p.scale_distance, "m", Scale::size, "after which odometry may be called scaled"},
      {"scaled", &p.scaled, "", Scale::none, "more: odometry is called scaled where it is farther off"},
      {"most_misfits", &p.most_misfits, "", Scale::none, "scans in a row, after which the track is lost"},
  };
}

Parameters parameters_of(Params::LocalMap& p) {
  return {
      {"length", &p.length, "m", Scale::size, "driven, after which a local map is given up"},
      {"overlap", &p.overlap, "m", Scale::size, "driven before that, when the next one begins"},
  };
}

Parameters parameters_of(Params::Beams& p) {
  return {
      {"free_no_return", &p.free_no_return, "m", Scale::size,
       "cleared by a beam without return: the dark returns none"},
      {"narrow", &p.narrow, "m", Scale::size, "what stands free and is no wider is thin, such as a leg"},
      {"behind", &p.behind, "m", Scale::size, "on both sides of it beams go on by so much"},
      {"in_front", &p.in_front, "m", Scale::size, "and none ends so much before it"},
      {"most_spacing", &p.most_spacing, "m", Scale::size, "between hits of one flat surface that is filled in"},
      {"flat", &p.flat, "m", Scale::size, "by which its hits may be off a line"},
  };
}

Parameters parameters_of(Params::OnlineMap& p) {
  return {
      {"redraw_distance", &p.redraw_distance, "m", Scale::size, "a closed loop redraws a map that is off by more"},
      {"redraw_arm", &p.redraw_arm, "m", Scale::size, "away are the things that a turned keyframe moves"},
  };
}

Parameters parameters_of(Params::MapUncertainty& p) {
  return {
      {"propagated", &p.propagated, "", Scale::none, "times the error of one scan's fit that passes into the map"},
      {"position", &p.position, "m", Scale::noise, "standard deviation of the pose in the map, from metre to metre"},
      {"heading", &p.heading, "rad", Scale::none, "the same of its heading"},
      {"stretch", &p.stretch, "", Scale::none, "of the map, by what is left of the range bias"},
      {"first_view", &p.first_view, "m", Scale::size, "from the start, within which all scans draw one view"},
      {"usual_noise", &p.usual_noise, "m", Scale::noise, "of ranges; all that grows in proportion with more"},
      {"least_noise", &p.least_noise, "", Scale::none, "share of it that other errors make up"},
      {"motion_position", &p.motion_position, "m", Scale::size, "standard deviation by motion, where scans tell none"},
      {"motion_heading", &p.motion_heading, "rad", Scale::none, "the same of the heading"},
      {"apart", &p.apart, "m", Scale::size, "between places that are remembered"},
      {"near", &p.near, "m", Scale::size, "a place is known as well as one so near"},
      {"way", &p.way, "m", Scale::size, "driven since, before it counts as coming back"},
  };
}

Parameters parameters_of(Params::Graph& p) {
  return {
      {"drift", &p.drift, "m^2/m", Scale::size,
       "variance of the front end: with less, loops are searched for too near"},
      {"turn_drift", &p.turn_drift, "rad/sqrt(m)", Scale::none, "the same of its heading"},
      {"least_drift", &p.least_drift, "m", Scale::size, "from one keyframe to the next"},
      {"least_turn_drift", &p.least_turn_drift, "rad", Scale::none, "the same of its heading"},
      {"keyframe_distance", &p.keyframe_distance, "m", Scale::size, "between keyframes: less bends better, costs more"},
      {"keyframe_turn", &p.keyframe_turn, "rad", Scale::none, "or so much turning"},
      {"turning", &p.turning, "m/rad", Scale::size, "of driving, that turning counts for"},
      {"scan_distance", &p.scan_distance, "m", Scale::size, "between scans that are kept: less takes memory"},
      {"scan_turn", &p.scan_turn, "rad", Scale::none, "or so much turning"},
      {"submap_length", &p.submap_length, "m", Scale::size,
       "driven, of which one map is made, and after which it may be met again"},
      {"free_range", &p.free_range, "m", Scale::size, "beams of local maps and submaps clear nothing beyond"},
      {"resumed_position", &p.resumed_position, "m", Scale::size, "by which a robot may be off that resumes a map"},
      {"resumed_heading", &p.resumed_heading, "rad", Scale::none, "the same of its heading"},
      {"solve_distance", &p.solve_distance, "m", Scale::size, "driven, after which closures are solved for"},
      {"solve_chi", &p.solve_chi, "", Scale::none, "variances off, from which on one is at once"},
      {"same_way", &p.same_way, "m", Scale::size, "ways no farther apart are one way"},
      {"same_way_heading", &p.same_way_heading, "rad", Scale::none,
       "as are ways that differ by no more: some see ahead"},
      {"ways", &p.ways, "", Scale::none, "along one way are kept: more takes memory"},
  };
}

Parameters parameters_of(Params::Loops& p) {
  return {
      {"near", &p.near, "m", Scale::size, "from a submap, beyond the standard deviation, where it is searched"},
      {"far", &p.far, "m", Scale::size, "and never farther"},
      {"try_again", &p.try_again, "m", Scale::size, "driven, before the same submap is searched again"},
      {"view_length", &p.view_length, "m", Scale::size,
       "of the way, whose scans are searched for together, also in a whole map"},
      {"view_distance", &p.view_distance, "m", Scale::size, "between these scans"},
      {"unsure", &p.unsure, "m", Scale::size, "standard deviation above which a second closure must confirm"},
      {"same_position", &p.same_position, "m", Scale::size, "by which that may be off the first"},
      {"same_heading", &p.same_heading, "rad", Scale::none, "the same of its heading"},
      {"found_position", &p.found_position, "m", Scale::size,
       "standard deviation of a pose found in another component"},
      {"found_heading", &p.found_heading, "rad", Scale::none, "the same of its heading"},
  };
}

Parameters parameters_of(Params::LoopCloser& p) {
  return {
      {"least_reach", &p.least_reach, "m", Scale::size, "but no less than this"},
      {"most_reach", &p.most_reach, "m", Scale::size, "and no more: costs its square"},
      {"least_turn", &p.least_turn, "rad", Scale::none, "no less than this to each side"},
      {"least_score", &p.least_score, "", Scale::none, "of the search: less finds more wrong loops to refuse"},
      {"distinct", &p.distinct, "", Scale::none, "share of the score that no other pose may reach"},
      {"agreement", &p.agreement, "", Scale::none, "share of hits on surfaces: less closes wrong loops"},
      {"known_hits", &p.known_hits, "", Scale::none, "and so many of each scan"},
      {"most_deviation", &p.most_deviation, "m", Scale::size, "of a closure: a corridor's walls alone leave more"},
      {"most_chi", &p.most_chi, "", Scale::none, "off the belief, of three numbers: once in 900 times by chance"},
      {"floor", &p.floor, "m", Scale::size, "standard deviation of a closure, since both maps are bent"},
      {"turn_floor", &p.turn_floor, "rad", Scale::none, "the same of its heading"},
  };
}

Parameters parameters_of(Params::GlobalSearch& p) {
  return {
      {"view_distance", &p.view_distance, "m", Scale::size, "between scans that are searched for together"},
      {"view_turn", &p.view_turn, "rad", Scale::none, "or so much turning"},
      {"good_score", &p.good_score, "", Scale::none, "that most poses reach: searching for it is quick"},
      {"least_score", &p.least_score, "", Scale::none, "that one must reach in a place that has changed"},
      {"lead", &p.lead, "", Scale::none, "of its score over all others elsewhere: less claims wrong poses"},
      {"elsewhere_position", &p.elsewhere_position, "m", Scale::size,
       "from another pose, from which on it is elsewhere"},
      {"elsewhere_heading", &p.elsewhere_heading, "rad", Scale::none, "or turned by so much"},
      {"confirm_position", &p.confirm_position, "m", Scale::size, "around a found pose, where later scans must fit"},
      {"confirm_heading", &p.confirm_heading, "rad", Scale::none, "the same of its heading"},
      {"confirmations", &p.confirmations, "", Scale::none, "scans in a row that fit there: more claims later"},
      {"period", &p.period, "s", Scale::scan, "between searches while there are new things to see"},
      {"longest_pause", &p.longest_pause, "s", Scale::scan, "between searches where there are none"},
  };
}

Parameters parameters_of(Params::Obstacles& p) {
  return {
      {"blur", &p.blur, "m", Scale::bias, "around its least range the lidar sees some things and not others"},
      {"neighbourhood", &p.neighbourhood, "m", Scale::size, "hits so near to one another are smoothed"},
      {"same", &p.same, "m", Scale::size, "points nearer to each other are one"},
  };
}

}  // namespace

Parameters parameters_of(Params& p) {
  Parameters all;
  all.push_back(
      {"map_resolution", &p.map_resolution, "m", Scale::size, "a cell of the map: 0.05 times a power of two"});
  append(all, "dead_reckoning", parameters_of(p.dead_reckoning));
  append(all, "filter", parameters_of(p.filter));
  append(all, "matching", parameters_of(p.matching));
  append(all, "registration", parameters_of(p.registration));
  append(all, "mapping", parameters_of(p.mapping));
  append(all, "odometry_check", parameters_of(p.odometry_check));
  append(all, "local_map", parameters_of(p.local_map));
  append(all, "localization", parameters_of(p.localization));
  append(all, "beams", parameters_of(p.beams));
  append(all, "online_map", parameters_of(p.online_map));
  append(all, "map_uncertainty", parameters_of(p.map_uncertainty));
  append(all, "graph", parameters_of(p.graph));
  append(all, "loops", parameters_of(p.loops));
  append(all, "loop_closer", parameters_of(p.loop_closer));
  append(all, "global_search", parameters_of(p.global_search));
  append(all, "obstacles", parameters_of(p.obstacles));
  return all;
}

double rounded_resolution(double resolution) {
  double rounded = Params{}.map_resolution;
  while (resolution >= 4.0 / 3.0 * rounded && 2.0 * rounded <= map::kCoarsestResolution) rounded *= 2.0;
  while (resolution < 2.0 / 3.0 * rounded && 0.5 * rounded >= map::kFinestResolution) rounded *= 0.5;
  return rounded;
}

SharedParams reference_params() {
  static const SharedParams params = std::make_shared<const Params>();
  return params;
}

}  // namespace threewe::slam
