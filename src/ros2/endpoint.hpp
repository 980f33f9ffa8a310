// Endpoints of the ROS 2 graph: what a node publishes or subscribes to, and how.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace threewe::ros2 {

/// Quality of service, of what makes a difference to us.
struct Qos {
  bool reliable = true;          ///< lost samples are sent again
  bool transient_local = false;  ///< who comes later gets the last samples
  int depth = 10;                ///< samples that are kept
  friend bool operator==(const Qos&, const Qos&) = default;
};

/// One publisher or subscription that was discovered.
struct Endpoint {
  bool publishes = false;               ///< or subscribes
  std::string topic;                    ///< such as "/scan"; a DDS topic that is none of ROS keeps its name
  std::string type;                     ///< such as "sensor_msgs/msg/LaserScan"; empty where it is none of ROS
  std::string hash;                     ///< "RIHS01_..."; empty where it has none, as in Humble and on micro-ROS
  Qos qos;                              ///< the depth is not known of others, and 0
  std::array<std::uint8_t, 16> guid{};  ///< names it
  bool of_cyclone_service = false;      ///< requests and replies begin with who asked, as ROS 2 on Cyclone DDS has them
  double rate = 0.0;                    ///< [Hz] of its topic's messages, where they were counted
  std::string node;                     ///< "/namespace/name"; empty where it has not been said
};

}  // namespace threewe::ros2
