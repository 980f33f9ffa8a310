// Link proposal: which of the topics that were discovered a robot's link would use, and why not the others.
#pragma once

#include <string>
#include <vector>

#include "ros2/endpoint.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::ros2 {

/// One topic of one type.
struct TopicUse {
  std::string topic;
  std::string type;
  std::string sensor;  ///< that it would be used for, or "command"; empty for none
  std::string reason;  ///< why it is not used; empty where it is
};

/// See `propose_link`.
struct LinkProposal {
  std::vector<TopicUse> topics;      ///< every topic of ROS 2, by name
  std::vector<std::string> missing;  ///< sensors without a topic, and "command"
  std::string yaml;                  ///< the `link:` section
};

/// For each of the profile's sensors the topic of a fitting type whose name is that of the profile's own link, else one
/// that has the sensor's name in its own, else the first. Who stops the robot no node says: that is the profile's own,
/// or left to be filled in, without which a profile is not read.
LinkProposal propose_link(const RobotProfile& profile, const std::vector<Endpoint>& endpoints);

}  // namespace threewe::ros2
