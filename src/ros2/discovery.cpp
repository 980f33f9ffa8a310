#include "ros2/discovery.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

constexpr int kLastDomain = 232;  // the ports of later ones do not exist

std::string_view text_of(const Environment& environment, const char* name) {
  const char* value = environment(name);
  return value == nullptr ? std::string_view() : value;
}

int read_domain(std::string_view text) {
  if (text.empty()) return 0;
  int domain = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
  if (error == std::errc() && end == text.data() + text.size() && domain >= 0 && domain <= kLastDomain) return domain;
  throw ConfigError(fmt::format("ROS_DOMAIN_ID is '{}'; it must be a whole number from 0 to {}", text, kLastDomain));
}

DiscoveryRange read_range(std::string_view text) {
  if (text.empty() || text == "LOCALHOST") return DiscoveryRange::localhost;
  if (text == "OFF") return DiscoveryRange::off;
  if (text == "SUBNET") return DiscoveryRange::subnet;
  if (text == "SYSTEM_DEFAULT") return DiscoveryRange::system_default;
  const std::vector<std::string> known = {"OFF", "LOCALHOST", "SUBNET", "SYSTEM_DEFAULT"};
  throw ConfigError(unknown_name("ROS_AUTOMATIC_DISCOVERY_RANGE", text, known));
}

// Into XML: what a name or an address may be made of.
std::string read_peer(std::string_view peer) {
  constexpr std::string_view kMarks = ".:-_%[]";
  const bool clean = std::ranges::all_of(peer, [&](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           kMarks.find(c) != std::string_view::npos;
  });
  if (clean) return std::string(peer);
  throw ConfigError(
      fmt::format("ROS_STATIC_PEERS has '{}'; it must be addresses or names of computers, with ; in between", peer));
}

std::vector<std::string> read_peers(std::string_view text) {
  std::vector<std::string> peers;
  while (!text.empty()) {
    const std::string_view peer = text.substr(0, text.find(';'));
    if (!peer.empty()) peers.push_back(read_peer(peer));
    text.remove_prefix(std::min(text.size(), peer.size() + 1));
  }
  return peers;
}

}  // namespace

Discovery read_discovery(const Environment& environment) {
  Discovery discovery;
  discovery.domain = read_domain(text_of(environment, "ROS_DOMAIN_ID"));
  discovery.range = read_range(text_of(environment, "ROS_AUTOMATIC_DISCOVERY_RANGE"));
  discovery.static_peers = read_peers(text_of(environment, "ROS_STATIC_PEERS"));
  if (text_of(environment, "ROS_LOCALHOST_ONLY") == "1") {  // older than the others, and above them
    discovery.range = DiscoveryRange::localhost;
    discovery.static_peers.clear();
  }
  if (discovery.range == DiscoveryRange::off) discovery.static_peers.clear();
  discovery.enclave = read_enclave(environment);
  return discovery;
}

std::string cyclone_configuration(const Discovery& discovery) {
  if (discovery.range == DiscoveryRange::system_default) return "";
  const bool local = discovery.range == DiscoveryRange::localhost || discovery.range == DiscoveryRange::off;

  // without multicast a node is announced to its peers alone. It keeps to the computer's usual interface: other nodes
  // here, of Fast DDS at least, name the addresses of that one and not the loopback's
  const std::string general = local ? "<AllowMulticast>false</AllowMulticast>" : "";

  std::string peers;
  if (local) peers += R"(<Peer address="localhost"/>)";
  for (const std::string& peer : discovery.static_peers) peers += fmt::format(R"(<Peer address="{}"/>)", peer);
  // found by peers without multicast are those whose index is low: Fast DDS looks up to 32 as well
  std::string search = "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>";
  search += "<SPDPInterval>1s</SPDPInterval>";  // a robot that is started again is found soon
  if (!peers.empty()) search += fmt::format("<Peers>{}</Peers>", peers);
  if (discovery.range == DiscoveryRange::off) search += "<Tag>threewe_alone</Tag>";

  // an image comes as one burst, which the kernel's usual buffer cannot hold; what it does not grant is gone without.
  // By the key hash Fast DDS learns that an endpoint is gone; else it waits until the lease of 10 s ends.
  const std::string internal =
      R"(<Internal><SocketReceiveBufferSize max="8MB"/><GenerateKeyhash>true</GenerateKeyhash></Internal>)";
  return fmt::format("<CycloneDDS><Domain><General>{}</General><Discovery>{}</Discovery>{}</Domain></CycloneDDS>",
                     general, search, internal);
}

}  // namespace threewe::ros2
