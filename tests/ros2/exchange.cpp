// A message of each type from Cyclone DDS to Fast DDS and back, by the node that robots are driven with.
//
//   ros2_exchange DOMAIN CORPUS
//
// CORPUS holds a payload of each type, after two bytes, as the fuzzers have them. The other side is ros2_recorder with
// --echo and a topic /types/NAME for each. It prints how many came back as they were, and names those that did not.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "ros2/dds/node.hpp"
#include "ros2/message_types.hpp"

using namespace threewe;
using namespace threewe::ros2;
using namespace std::chrono_literals;

constexpr Distribution kLayout = Distribution::jazzy;

int main(int count, char** arguments) {
  if (count != 3) {
    std::fputs("usage: ros2_exchange DOMAIN CORPUS\n", stderr);
    return 2;
  }
  std::mutex mutex;
  std::map<std::string, Payload> returned;
  Discovery discovery = read_discovery([](const char* name) { return std::getenv(name); });
  discovery.domain = std::stoi(arguments[1]);
  Node node(discovery, "/", "exchange");
  std::map<std::string, Payload> sent;
  std::map<std::string, Node::Handle> publishers;
  std::vector<Node::Handle> all;
  for (const MessageType& type : message_types()) {
    const std::string name(type.name.substr(type.name.rfind('/') + 1));
    std::ifstream file(std::filesystem::path(arguments[2]) / name, std::ios::binary);
    const Payload bytes{std::istreambuf_iterator<char>(file), {}};
    // written by us, of what the other generator made
    const auto payload = type.recode(std::span(bytes).subspan(2), kLayout);
    if (!payload) {
      std::fprintf(stderr, "%s: %s\n", name.c_str(), payload.error().c_str());
      return 1;
    }
    sent[name] = *payload;
    publishers[name] = node.advertise("/types/" + name, type.name, {});
    all.push_back(publishers[name]);
    all.push_back(node.subscribe("/types/" + name + "/back", type.name, {}, [&, name](auto bytes_back, std::uint64_t) {
      const std::scoped_lock lock(mutex);
      returned[name].assign(bytes_back.begin(), bytes_back.end());
    }));
  }
  const auto lonely = [&] { return std::ranges::count_if(all, [&](auto handle) { return node.peers(handle) == 0; }); };
  for (int i = 0; i < 1500 && lonely() > 0; ++i) std::this_thread::sleep_for(10ms);
  if (lonely() > 0) std::printf("%td endpoints without another\n", lonely());
  std::this_thread::sleep_for(500ms);
  for (const auto& [name, publisher] : publishers) node.publish(publisher, sent[name]);
  for (int i = 0; i < 500; ++i) {
    {
      const std::scoped_lock lock(mutex);
      if (returned.size() == sent.size()) break;
    }
    std::this_thread::sleep_for(10ms);
  }
  const std::scoped_lock lock(mutex);
  std::size_t same = 0;
  for (const MessageType& type : message_types()) {
    const std::string name(type.name.substr(type.name.rfind('/') + 1));
    const auto again = type.recode(returned[name], kLayout);  // without what DDS pads it with
    if (again == sent[name]) {
      ++same;
    } else {
      std::printf("%s: %s\n", name.c_str(), again ? "another message came back" : again.error().c_str());
    }
  }
  std::printf("%zu of %zu types\n", same, sent.size());
  return same == sent.size() ? 0 : 1;
}
