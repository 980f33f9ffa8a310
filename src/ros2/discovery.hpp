// Discovery options: with whom a node talks, as ROS 2 reads it from the environment, and Cyclone DDS's configuration
// for it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ros2/enclave.hpp"

namespace threewe::ros2 {

/// How far a node looks for others, as `ROS_AUTOMATIC_DISCOVERY_RANGE`.
enum class DiscoveryRange : std::uint8_t {
  off,             ///< it finds none
  localhost,       ///< this computer; nothing leaves it
  subnet,          ///< all nodes that multicast reaches
  system_default,  ///< what Cyclone DDS is configured for otherwise
};

/// With whom a node talks.
struct Discovery {
  int domain = 0;                                    ///< 0 to 232; other domains are other networks
  DiscoveryRange range = DiscoveryRange::localhost;  ///< farther where it is asked for
  std::vector<std::string> static_peers;             ///< addresses or names of computers to talk with besides
  std::optional<Enclave> enclave = {};               ///< empty: neither proves who it is, nor asks who others are
  friend bool operator==(const Discovery&, const Discovery&) = default;
};

/// The value of an environment variable; null where it is not set.
using Environment = std::function<const char*(const char* name)>;

/// As ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_STATIC_PEERS and ROS_LOCALHOST_ONLY say, with one difference to
/// ROS 2: where none of them asks for a network, nothing leaves this computer. Security is as `read_enclave` has it.
/// Throws ConfigError naming the variable.
Discovery read_discovery(const Environment& environment);

/// Cyclone DDS's configuration (version 0.10), as XML; empty where its own is to be used.
std::string cyclone_configuration(const Discovery& discovery);

}  // namespace threewe::ros2
