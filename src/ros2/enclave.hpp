// Security enclave of SROS2: the files by which a node proves who it is and what it may do.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace threewe::ros2 {

/// An enclave of a keystore, as `ros2 security create_enclave` makes it.
struct Enclave {
  std::string name;  ///< "/robot"
  std::filesystem::path folder;
  friend bool operator==(const Enclave&, const Enclave&) = default;
};

/// As ROS_SECURITY_ENABLE, ROS_SECURITY_KEYSTORE and ROS_SECURITY_ENCLAVE_OVERRIDE of the environment say; empty where
/// security is off. Where it is on, nothing is sent without it, whatever ROS_SECURITY_STRATEGY says. Throws ConfigError
/// naming the variable, or the file that is missing.
std::optional<Enclave> read_enclave(const std::function<const char*(const char* name)>& environment);

/// The properties of DDS security by which a participant of Cyclone DDS has it, names and values.
std::vector<std::pair<std::string, std::string>> security_properties(const Enclave& enclave);

}  // namespace threewe::ros2
