// Diagnosis of a robot that cannot be reached: what its link expects that the ROS 2 graph does not have.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ros2/discovery.hpp"
#include "ros2/endpoint.hpp"
#include "ros2/messages/system_msgs.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::ros2 {

/// What keeps us from a topic, and what would help: none publishes it, another type, an offer of less than is asked
/// for, a type of another hash. Empty where nothing does.
std::string diagnose(const TopicSpec& topic, bool we_publish, const std::vector<Endpoint>& endpoints);

/// Whether its type has a hash that no distribution has which we know.
bool has_unknown_hash(const Endpoint& endpoint);

/// The type of the robot's velocities: the profile's, or the other one of Twist and TwistStamped where that is the one
/// that is subscribed to.
std::string command_type(const TopicSpec& command, const std::vector<Endpoint>& endpoints);

/// Which other nodes publish velocities, as two that command one robot take turns. Empty where none does.
std::string diagnose_drivers(const TopicSpec& command, const std::vector<Endpoint>& endpoints);

/// That messages of one sensor come from two publishers.
std::string diagnose_rivals(const TopicSpec& topic, const std::vector<Endpoint>& endpoints);

/// Why images of a topic are lost, or none comes, where the kernel grants a receive buffer of so many bytes at most,
/// and what would help.
std::string explain_lost_images(std::size_t most_granted);

/// How nodes were looked for.
struct Search {
  Duration lasted{};                    ///< wall time
  std::size_t participants = 0;         ///< of DDS that were found, without an endpoint
  std::vector<std::string> interfaces;  ///< of this computer
};

/// What was seen, and what to try, where no endpoint was found.
std::string diagnose_silence(const Discovery& discovery, const Search& search);
/// "(interfaces: ...)".
std::string describe_interfaces(const std::vector<std::string>& interfaces);

/// How long a sensor may be silent.
Duration patience_with(const SensorInfo& sensor);
/// How a part of a robot is, as /diagnostics has it: an error where there is a mistake, stale where its newest message
/// is older than `patience`, or none has come.
diagnostic_msgs::DiagnosticStatus to_status(const RobotProfile& profile, std::string_view part, std::string mistake,
                                            std::optional<Duration> age = Duration::zero(), Duration patience = 1s);

}  // namespace threewe::ros2
