// Network interfaces of this computer.
#pragma once

#include <string>
#include <vector>

namespace threewe::ros2 {

/// Those that are up and have an address of IPv4, such as "eth0 192.168.7.2".
std::vector<std::string> network_interfaces();

}  // namespace threewe::ros2
