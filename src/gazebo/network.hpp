// Discovery sockets: how nodes of Gazebo find each other, by small UDP messages to a multicast group.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "gazebo/messages.hpp"

namespace threewe::gazebo {

/// With whom a process talks, by the variables of Gazebo in its environment.
struct Settings {
  std::string partition;  ///< nodes of one do not find those of another; by default of this user on this computer
  std::string ip;         ///< of the interface to use alone; empty: of all
  std::string group = "239.255.0.7";
  std::uint16_t message_port = 10317;
  std::uint16_t service_port = 10318;
};

/// Looks each variable up by `get`, as `std::getenv` does: GZ_PARTITION, GZ_IP and GZ_DISCOVERY_..., or their former
/// names with IGN_. Throws ConfigError for a port that is none.
Settings read_settings(const std::function<const char*(const char*)>& get);

/// Sends to a group on every interface of this computer, and receives from it.
class Multicast {
 public:
  /// Throws ConnectionError where there is no interface to use.
  Multicast(const Settings& settings, std::uint16_t port);
  Multicast(const Multicast&) = delete;
  Multicast& operator=(const Multicast&) = delete;
  ~Multicast();

  /// Becomes readable when a message has arrived.
  int descriptor() const { return receiver_; }
  void send(const msgs::Discovery& message) const;
  /// The messages that have arrived. What is none, or of another version of the protocol, is left out.
  std::vector<msgs::Discovery> receive() const;

 private:
  std::string group_;
  std::uint16_t port_;
  int receiver_ = -1;
  std::vector<int> senders_;  // one for each interface
};

/// The address at which other nodes reach this one. Throws ConnectionError where this computer has none.
std::string own_address(const Settings& settings);

/// A name that no other has: 128 random bits, written as Gazebo writes them.
std::string unique_name();

}  // namespace threewe::gazebo
