// Metrics that ObjectNav and VLN share.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "task/stop_task.hpp"
#include "threewe/task/task.hpp"

namespace threewe::task {

/// How an episode has gone so far.
struct StopTrip {
  double driven = 0.0;   ///< [m]
  double contact = 0.0;  ///< [m/s], the fastest
  bool stopped = false;
  bool success = false;
};

inline std::vector<std::string> stop_metric_names() {
  return {"success", "spl", "distance_to_goal", "shortest_path", "path_length", "collision_speed", "stopped"};
}

inline std::array<double, 7> stop_metrics(const StopTrip& trip, double shortest, double left) {
  return {trip.success ? 1.0 : 0.0,
          success_weighted_by_path_length(trip.success, shortest, trip.driven),
          left,
          shortest,
          trip.driven,
          trip.contact,
          trip.stopped ? 1.0 : 0.0};
}

/// A moment's action as it was asked for.
inline std::array<float, 3> asked(const TaskState& moment) {
  return {static_cast<float>(moment.action.vx), static_cast<float>(moment.action.vy),
          static_cast<float>(moment.action.omega)};
}

}  // namespace threewe::task
