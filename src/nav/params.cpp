#include "nav/params.hpp"

namespace threewe::nav {

Parameters parameters_of(Params::Creep& p) {
  return {{"speed", &p.speed, "m/s", Scale::size, "more: quicker through bottlenecks, harder where it touches"},
          {"corner_speed", &p.corner_speed, "m/s", Scale::size, "more: turns quicker where it is tight"},
          {"margin", &p.margin, "m", Scale::noise, "less: fits through narrower bottlenecks, and touches more"},
          {"free_speed", &p.free_speed, "m/s", Scale::size, "more: quicker before and after bottlenecks"},
          {"free_turn_rate", &p.free_turn_rate, "rad/s", Scale::turn_rate, "more: turns quicker in tight places"},
          {"progress", &p.progress, "m", Scale::size, "more: backs out sooner where it hardly moves"},
          {"encroachment", &p.encroachment, "m", Scale::noise, "less: stops more often next to what is near already"}};
}

Parameters parameters_of(Params::Clearance& p) {
  return {{"spare", &p.spare, "m", Scale::size, "more: avoids narrow doors, and touches less"},
          {"caution", &p.caution, "m", Scale::size, "more: paths keep to the middle of wider places"},
          {"weight", &p.weight, "", Scale::none, "more: longer ways round to keep away from walls"}};
}

Parameters parameters_of(Params::Route& p) {
  return {
      {"unknown_weight", &p.unknown_weight, "", Scale::none, "more: longer ways through what is known"},
      {"sight", &p.sight, "", Scale::none, "less: follows the walls of large rooms at less distance"},
      {"blind_weight", &p.blind_weight, "", Scale::none, "more: longer ways along the walls of large rooms"},
      {"waypoint", &p.waypoint, "m", Scale::size, "more: cuts the corners of a drawn path"},
      {"horizon", &p.horizon, "m", Scale::size, "more: aims farther beyond its map at far goals"},
      {"better", &p.better, "", Scale::none, "less: keeps to a path that has become the longer one"},
      {"driven_spacing", &p.driven_spacing, "m", Scale::size, "more: gives up no place near to where it has been"},
      {"mover_distance", &p.mover_distance, "m", Scale::size, "more: blames people and robots that are farther away"},
      {"ahead", &p.ahead, "m", Scale::size, "more: avoids what is farther ahead of where it got stuck"},
      {"entrance", &p.entrance, "m", Scale::size, "more: gives up unknown space farther behind a failure"},
      {"attempts", &p.attempts, "", Scale::none, "more: tries a place longer before it is given up"},
      {"retry", &p.retry, "s", Scale::scan, "less: drives on sooner once there is a way, at more work"},
      {"replan", &p.replan, "s", Scale::travel, "less: sees better ways sooner, at more work"},
      {"explore", &p.explore, "s", Scale::travel, "less: turns to better frontiers sooner, at more work"},
      {"near_frontier", &p.near_frontier, "m", Scale::size, "more: leaves a frontier sooner for the next"},
  };
}

Parameters parameters_of(Params::Frontier& p) {
  return {
      {"least_length", &p.least_length, "m", Scale::size, "less: maps smaller corners, and takes longer"},
      {"gain", &p.gain, "", Scale::none, "more: drives farther for what shows more"},
      {"longest", &p.longest, "m", Scale::size, "more: prefers large open rooms"},
      {"stay", &p.stay, "m", Scale::size, "less: turns to other frontiers on its way"},
      {"claimed", &p.claimed, "m", Scale::size, "less: follows other robots to what they explore"},
      {"claim", &p.claim, "m", Scale::size, "more: leaves more room to other robots"},
      {"same", &p.same, "m", Scale::size, "more: keeps to frontiers that shift"},
      {"strip", &p.strip, "m", Scale::size, "less: drives farther for the last corners, unless it is thorough"},
      {"view", &p.view, "", Scale::none, "more: drives farther for what is behind narrow openings"},
      {"slit", &p.slit, "m", Scale::size, "less: takes slits between beams for something to see"},
  };
}

Parameters parameters_of(Params::Bottleneck& p) {
  return {
      {"coarseness", &p.coarseness, "m", Scale::size, "more: tries bottlenecks that turn out to be too narrow"},
      {"straight", &p.straight, "m", Scale::size, "more: takes bends for a straight bottleneck"},
      {"shortest", &p.shortest, "m", Scale::size, "more: lines up farther away"},
      {"patience", &p.patience, "s", Scale::travel, "more: says later that there is no path"},
      {"first_patience", &p.first_patience, "s", Scale::travel, "more: tries the same bottleneck longer"},
      {"ahead", &p.ahead, "m", Scale::size, "more: enters creep mode where it got stuck, farther before a bottleneck"},
      {"hesitation", &p.hesitation, "s", Scale::travel, "less: lines up sooner for what it might have driven through"},
      {"passing", &p.passing, "s", Scale::travel, "less: prefers bottlenecks to shorter ways round"},
      {"sight", &p.sight, "m", Scale::size, "more: sees bottlenecks from farther away, at more work"},
      {"flat", &p.flat, "m", Scale::size, "more: rounds off the corners of narrow bottlenecks"},
      {"before", &p.before, "m", Scale::size, "more: begins to line up farther from the place for it"},
  };
}

Parameters parameters_of(Params::Progress& p) {
  return {{"nearer", &p.nearer, "m", Scale::size, "less: wavers longer before it says that it is blocked"},
          {"patience", &p.patience, "s", Scale::travel, "more: says later that it makes no progress"},
          {"detour", &p.detour, "", Scale::none, "more: the same on long ways"},
          {"mean_speed", &p.mean_speed, "", Scale::none, "less: the same on long ways"}};
}

Parameters parameters_of(Params::Motion& p) {
  return {
      {"spare", &p.spare, "m", Scale::noise, "less: slowed down by the gate next to walls"},
      {"tight_for", &p.tight_for, "s", Scale::travel, "more: nearer to walls for longer after it got stuck"},
      {"arrived", &p.arrived, "m", Scale::size, "less: nearer to goals, and longer about it"},
      {"path_end", &p.path_end, "m", Scale::size, "less: the same where a goal itself cannot be reached"},
      {"turned", &p.turned, "rad", Scale::none, "less: nearer to headings, and longer about it"},
      {"last", &p.last, "m", Scale::size, "more: follows longer ends of paths without sampled plans"},
      {"stuck_after", &p.stuck_after, "s", Scale::travel, "less: backs off sooner where something stands in its way"},
      {"moved", &p.moved, "m", Scale::size, "more: calls it being stuck that it hardly moves"},
      {"moved_turn", &p.moved_turn, "rad", Scale::none, "more: calls it being stuck that it hardly turns"},
      {"proof", &p.proof, "s", Scale::scan, "less: says sooner, and wrongly, that there is no path"},
      {"lost_patience", &p.lost_patience, "s", Scale::none, "less: says sooner that it is lost"},
      {"courtesy", &p.courtesy, "s", Scale::none, "less: says sooner that a person stands in the only way"},
      {"map_patience", &p.map_patience, "s", Scale::scan, "less: calls a lidar that starts slowly a fault"},
      {"creep_after", &p.creep_after, "", Scale::none, "more: avoids tight places before it tries them in creep mode"},
      {"person_radius", &p.person_radius, "m", Scale::none, "more: keeps farther from people"},
      {"zone_reaction", &p.zone_reaction, "s", Scale::reaction, "less: enters slow zones too fast"},
      {"border_sight", &p.border_sight, "m", Scale::size, "less: sees zones to keep out of later"},
      {"sweep_angle", &p.sweep_angle, "rad", Scale::none, "more: without a lidar, detects more and drives slower"},
      {"sweep_period", &p.sweep_period, "s", Scale::none, "more: without a lidar, detects things later"},
      {"prior_time", &p.prior_time, "s", Scale::travel, "more: foretells the time left more evenly, and later"},
      {"expected_speed", &p.expected_speed, "", Scale::none, "more: foretells shorter times at first"},
  };
}

Parameters parameters_of(Params::Follower& p) {
  return {
      {"reaction", &p.reaction, "s", Scale::reaction, "more: drives slower towards obstacles and goals"},
      {"horizon", &p.horizon, "s", Scale::travel, "less: brakes later and harder"},
      {"step", &p.step, "m", Scale::size, "more: sees contacts less exactly, at less work"},
      {"thinning", &p.thinning, "m", Scale::size, "more: less work, and touches more"},
      {"faced", &p.faced, "m", Scale::size, "more: a differential base turns less before it drives"},
      {"turn_first", &p.turn_first, "rad", Scale::none, "less: a differential base turns on the spot more often"},
      {"turn_done", &p.turn_done, "rad", Scale::none, "less: it turns longer before it drives"},
      {"turn_blocked", &p.turn_blocked, "", Scale::none, "more: turns the long way round more often"},
      {"lookahead", &p.lookahead, "m", Scale::size, "more: smoother, and cuts corners, without a lidar"},
      {"position_gain", &p.position_gain, "1/s", Scale::none,
       "more: back on its line, and at ends, sooner, and swings"},
      {"heading_gain", &p.heading_gain, "1/s", Scale::none, "more: faces along its path sooner, and swings"},
      {"line_convergence", &p.line_convergence, "m", Scale::size, "less: the same of a differential base"},
      {"blind_speed", &p.blind_speed, "m/s", Scale::speed, "more: faster without a lidar, and touches more"},
      {"escape_speed", &p.escape_speed, "", Scale::none, "more: backs off faster"},
      {"least_speed", &p.least_speed, "", Scale::none, "less: crawls on before obstacles instead of stopping"},
      {"least_turn_rate", &p.least_turn_rate, "rad/s", Scale::turn_rate, "less: takes longer to end a turn"},
      {"braking", &p.braking, "", Scale::none, "more: drives faster towards obstacles"},
      {"gentle_braking", &p.gentle_braking, "", Scale::none, "more: brakes later before goals"},
      {"gentle_turn_braking", &p.gentle_turn_braking, "", Scale::none, "more: the same of turns"},
  };
}

Parameters parameters_of(Params::Recovery& p) {
  return {
      {"same_place", &p.same_place, "m", Scale::size, "more: gives up sooner where it wavers"},
      {"attempts", &p.attempts, "", Scale::none, "more: gives up later"},
      {"look_from", &p.look_from, "", Scale::none, "more: turns to look later"},
      {"clearing", &p.clearing, "s", Scale::scan, "less: backs off from what has gone already"},
      {"backing_off", &p.backing_off, "s", Scale::travel, "more: backs off longer where it is slow"},
      {"arc_escape", &p.arc_escape, "s", Scale::travel, "more: tries longer to get out of tight places"},
      {"looking", &p.looking, "s", Scale::none, "less: turns to look less far where it turns slowly"},
      {"backing_distance", &p.backing_distance, "m", Scale::size, "more: backs off farther"},
      {"more_each_time", &p.more_each_time, "m", Scale::size, "more: backs off farther each time"},
      {"look", &p.look, "rad", Scale::none, "more: searches farther to both sides"},
      {"looked", &p.looked, "rad", Scale::none, "more: searches less far, and is done sooner"},
      {"backtrack_spacing", &p.backtrack_spacing, "m", Scale::size, "more: remembers a longer way back, less exactly"},
      {"backtrack_passed", &p.backtrack_passed, "m", Scale::size, "more: cuts corners as it backs off"},
  };
}

Parameters parameters_of(Params::NarrowPassage& p) {
  return {
      {"offset", &p.offset, "m", Scale::size, "more: finds bottlenecks farther from where the map shows them"},
      {"sight", &p.sight, "m", Scale::size, "more: measures wider ways"},
      {"turn", &p.turn, "rad", Scale::none, "more: finds bottlenecks at other angles than the map shows"},
      {"gain", &p.gain, "", Scale::none, "more: follows what it sees, and its noise, quicker"},
      {"least_spare", &p.least_spare, "m", Scale::noise, "less: enters bottlenecks in which it gets stuck"},
      {"most_spare", &p.most_spare, "m", Scale::size, "more: in creep mode through what it could drive through"},
      {"measuring", &p.measuring, "s", Scale::scan, "less: judges bottlenecks sooner, and less exactly"},
      {"patience", &p.patience, "s", Scale::travel, "less: backs out sooner where it hardly moves"},
      {"attempts", &p.attempts, "", Scale::none, "more: tries longer before it calls a bottleneck closed"},
      {"in_line", &p.in_line, "m", Scale::noise, "less: lines up longer, and touches less"},
      {"aligned", &p.aligned, "rad", Scale::none, "the same of its heading"},
      {"askew", &p.askew, "rad", Scale::none, "more: enters where it could not line up"},
      {"room_to_turn", &p.room_to_turn, "m", Scale::size, "more: lines up farther before the bottleneck"},
      {"room_before", &p.room_before, "m", Scale::size, "more: in creep mode from farther before the bottleneck"},
      {"convergence", &p.convergence, "m", Scale::size, "less: a differential base returns sooner, and swings"},
  };
}

Parameters parameters_of(Params::Arcs& p) {
  return {
      {"radius", &p.radius, "m", Scale::size, "less: turns in less room, with more steps"},
      {"reach", &p.reach, "m", Scale::size, "more: searches farther for room, at more work"},
      {"room", &p.room, "m", Scale::noise, "more: the same"},
      {"encroachment", &p.encroachment, "m", Scale::noise, "less: finds fewer ways out, and touches less"},
      {"haste", &p.haste, "", Scale::none, "more: less work for slower ways"},
      {"change", &p.change, "s", Scale::travel, "more: goes to and fro less often"},
      {"plans", &p.plans, "", Scale::none, "more: tries longer"},
      {"replan", &p.replan, "s", Scale::scan, "less: tries more often while there is no way, at more work"},
      {"tolerance_step", &p.tolerance_step, "m", Scale::noise, "more: dares to leave sooner, and touches more"},
      {"patience", &p.patience, "s", Scale::travel, "less: plans anew sooner where it hardly moves"},
      {"turned", &p.turned, "rad", Scale::none, "more: the same of turns"},
      {"convergence", &p.convergence, "m", Scale::size, "less: keeps to its arcs better, and swings"},
  };
}

Parameters parameters_of(Params::Mppi& p) {
  Parameters all = {
      {"samples", &p.samples, "", Scale::none, "more: smoother, at more work"},
      {"step", &p.step, "s", Scale::none, "more: searches farther ahead, less exactly"},
      {"periods", &p.periods, "", Scale::none, "more: reacts later, at less work"},
      {"temperature", &p.temperature, "", Scale::none, "more: smoother, and farther from the best way"},
      {"control_cost", &p.control_cost, "", Scale::none, "more: keeps to the plan before"},
      {"linear_noise", &p.linear_noise, "m/s", Scale::speed, "more: tries speeds that differ more"},
      {"angular_noise", &p.angular_noise, "rad/s", Scale::turn_rate, "more: tries turns that differ more"},
      {"sideways_free", &p.sideways_free, "m/s", Scale::speed, "more: drives sideways faster"},
      {"backward_speed", &p.backward_speed, "", Scale::none, "more: a differential base drives backwards faster"},
      {"obstacle_reach", &p.obstacle_reach, "m", Scale::size, "more: slower next to walls"},
      {"people_reach", &p.people_reach, "m", Scale::none, "more: slower next to people, and farther from them"},
      {"people_blur", &p.people_blur, "m", Scale::none, "less: takes the rim of people for walls"},
      {"stray", &p.stray, "m", Scale::size, "less: leads around things less well, at less work"},
  };
  append(all, "weights", parameters_of(p.weights));
  return all;
}

Parameters parameters_of(Params::Mppi::Weights& p) {
  return {
      {"unit_of_length", &p.unit_of_length, "m", Scale::size, "more: cuts corners more"},
      {"unit_of_speed", &p.unit_of_speed, "m/s", Scale::speed, "more: slower"},
      {"path_left", &p.path_left, "", Scale::none, "more: faster, and nearer to what is in the way"},
      {"path_offset", &p.path_offset, "", Scale::none, "more: keeps to the path"},
      {"goal_speed", &p.goal_speed, "", Scale::none, "more: slower to the goal"},
      {"obstacle_contact", &p.obstacle_contact, "", Scale::none, "more: waits rather than touches"},
      {"obstacle_depth", &p.obstacle_depth, "", Scale::none, "more: leaves the margin of walls sooner"},
      {"obstacle_close", &p.obstacle_close, "", Scale::none, "more: keeps away from walls"},
      {"obstacle_braking", &p.obstacle_braking, "", Scale::none, "more: slower next to walls"},
      {"heading_along", &p.heading_along, "", Scale::none, "more: faces along its path sooner"},
      {"heading_sideways", &p.heading_sideways, "", Scale::none, "more: drives sideways less"},
      {"heading_backward", &p.heading_backward, "", Scale::none, "more: drives backwards less"},
      {"heading_turn", &p.heading_turn, "1/rad", Scale::none, "more: turns on the spot quicker"},
      {"smooth_linear", &p.smooth_linear, "", Scale::none, "more: smoother, and reacts later"},
      {"smooth_angular", &p.smooth_angular, "s^2/rad^2", Scale::none, "more: the same of turns"},
      {"people_contact", &p.people_contact, "", Scale::none, "more: waits for people rather than touches them"},
      {"people_close", &p.people_close, "", Scale::none, "more: slower next to people"},
  };
}

Parameters parameters_of(Params& p) {
  Parameters all;
  append(all, "creep", parameters_of(p.creep));
  append(all, "clearance", parameters_of(p.clearance));
  append(all, "sonar_clearance", parameters_of(p.sonar_clearance));
  append(all, "route", parameters_of(p.route));
  append(all, "frontier", parameters_of(p.frontier));
  append(all, "bottleneck", parameters_of(p.bottleneck));
  append(all, "progress", parameters_of(p.progress));
  append(all, "motion", parameters_of(p.motion));
  append(all, "follower", parameters_of(p.follower));
  append(all, "recovery", parameters_of(p.recovery));
  append(all, "narrow_passage", parameters_of(p.narrow_passage));
  append(all, "arcs", parameters_of(p.arcs));
  append(all, "mppi", parameters_of(p.mppi));
  return all;
}

}  // namespace threewe::nav
