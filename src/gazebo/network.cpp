#include "gazebo/network.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <random>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <pwd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "threewe/core/errors.hpp"

namespace threewe::gazebo {
namespace {

constexpr std::uint32_t kVersion = 10;   // of the protocol, from Fortress (transport 11) to Ionic (14)
constexpr std::size_t kLongest = 65507;  // bytes of a UDP message

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
}

std::string user_name() {
  const passwd* user = ::getpwuid(::getuid());
  return user != nullptr ? user->pw_name : "unknown";
}

std::uint16_t to_port(std::string_view text, std::string_view name) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error == std::errc{} && end == text.data() + text.size() && port > 0) return port;
  throw ConfigError(fmt::format("{} is '{}'; it must be a port from 1 to 65535", name, text));
}

/// The IPv4 addresses of interfaces that are up.
std::vector<std::string> interfaces(const Settings& settings) {
  if (!settings.ip.empty()) return {settings.ip};
  std::vector<std::string> found;
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return found;
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET || (one->ifa_flags & IFF_UP) == 0) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    ::inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    found.emplace_back(text.data());
  }
  ::freeifaddrs(first);
  return found;
}

in_addr to_address(const std::string& ip) {
  in_addr address{};
  if (::inet_pton(AF_INET, ip.c_str(), &address) != 1) {
    throw ConfigError(
        fmt::format("'{}' is no IPv4 address such as 192.0.2.1: is GZ_IP, or "
                    "GZ_DISCOVERY_MULTICAST_IP, right?",
                    ip));
  }
  return address;
}

sockaddr_in endpoint(in_addr address, std::uint16_t port) {
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_addr = address;
  there.sin_port = htons(port);
  return there;
}

}  // namespace

Settings read_settings(const std::function<const char*(const char*)>& get) {
  const auto value = [&](const char* name) -> std::string {
    for (const char* prefix : {"GZ_", "IGN_"}) {
      if (const char* text = get(fmt::format("{}{}", prefix, name).c_str()); text != nullptr && *text != '\0') {
        return text;
      }
    }
    return "";
  };
  Settings settings;
  settings.partition = value("PARTITION");
  if (settings.partition.empty()) settings.partition = host_name() + ":" + user_name();
  settings.ip = value("IP");
  if (auto group = value("DISCOVERY_MULTICAST_IP"); !group.empty()) settings.group = group;
  if (auto port = value("DISCOVERY_MSG_PORT"); !port.empty()) {
    settings.message_port = to_port(port, "GZ_DISCOVERY_MSG_PORT");
  }
  if (auto port = value("DISCOVERY_SRV_PORT"); !port.empty()) {
    settings.service_port = to_port(port, "GZ_DISCOVERY_SRV_PORT");
  }
  if (!settings.ip.empty()) (void)to_address(settings.ip);
  (void)to_address(settings.group);
  return settings;
}

std::string own_address(const Settings& settings) {
  const std::vector<std::string> all = interfaces(settings);
  if (all.empty()) throw ConnectionError("backend 'gazebo': this computer has no network interface that is up");
  const auto outside = std::ranges::find_if(all, [](const std::string& ip) { return !ip.starts_with("127."); });
  return outside != all.end() ? *outside : all.front();
}

Multicast::Multicast(const Settings& settings, std::uint16_t port) : group_(settings.group), port_(port) {
  const in_addr group = to_address(group_);
  receiver_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;  // other nodes of this computer listen to the same port
  ::setsockopt(receiver_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  ::setsockopt(receiver_, SOL_SOCKET, SO_REUSEPORT, &yes, sizeof yes);
  const sockaddr_in here = endpoint({INADDR_ANY}, port);
  if (::bind(receiver_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) {
    ::close(receiver_);
    throw ConnectionError(fmt::format("backend 'gazebo': UDP port {} cannot be listened to", port));
  }
  for (const std::string& ip : interfaces(settings)) {
    const ip_mreq membership{group, to_address(ip)};
    if (::setsockopt(receiver_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) continue;
    const int sender = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ::setsockopt(sender, IPPROTO_IP, IP_MULTICAST_IF, &membership.imr_interface, sizeof membership.imr_interface);
    senders_.push_back(sender);
  }
  if (senders_.empty()) {
    ::close(receiver_);
    throw ConnectionError(fmt::format("backend 'gazebo': no network interface can multicast{}",
                                      settings.ip.empty() ? "" : " with GZ_IP=" + settings.ip));
  }
}

Multicast::~Multicast() {
  ::close(receiver_);
  for (const int sender : senders_) ::close(sender);
}

void Multicast::send(const msgs::Discovery& message) const {
  msgs::Discovery versioned = message;
  versioned.version = kVersion;
  const Bytes body = encode(versioned);
  Bytes packet{static_cast<std::uint8_t>(body.size()), static_cast<std::uint8_t>(body.size() >> 8U)};
  packet.insert(packet.end(), body.begin(), body.end());
  const sockaddr_in there = endpoint(to_address(group_), port_);
  for (const int sender : senders_) {
    // one that is lost is said again with the next heartbeat
    (void)::sendto(sender, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&there), sizeof there);
  }
}

std::vector<msgs::Discovery> Multicast::receive() const {
  std::vector<msgs::Discovery> messages;
  std::array<std::uint8_t, kLongest> packet{};
  for (;;) {
    const ssize_t size = ::recv(receiver_, packet.data(), packet.size(), 0);
    if (size < 0) return messages;
    const auto length = static_cast<std::size_t>(size);
    const std::size_t stated = std::size_t{packet[0]} | std::size_t{packet[1]} << 8U;
    if (length < 2 || stated > length - 2) continue;
    auto message = decode<msgs::Discovery>(ByteView(packet).subspan(2, stated));
    // one that asks to be forwarded is for relays, which Gazebo itself has
    const bool forwarded = message && message->flags && message->flags->relay;
    if (message && message->version == kVersion && !forwarded) messages.push_back(std::move(*message));
  }
}

std::string unique_name() {
  std::random_device random;
  return fmt::format("{:08x}-{:04x}-{:04x}-{:04x}-{:08x}{:04x}", random(), random() & 0xFFFFU, random() & 0xFFFFU,
                     random() & 0xFFFFU, random(), random() & 0xFFFFU);
}

}  // namespace threewe::gazebo
