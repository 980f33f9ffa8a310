// The table of ROS 2 messages, for tests and for the command line.
#include <nanobind/stl/unique_ptr.h>

#include "autonomous_world.hpp"
#include "bindings.hpp"
#include "ros2/link_proposal.hpp"
#include "ros2/message_types.hpp"
#include "ros2/real.hpp"
#include "ros2/serve.hpp"
#include "threewe/backend/registry.hpp"

using namespace threewe;

namespace {

ros2::Distribution distribution_named(std::string_view name) {
  for (const ros2::Distribution one : ros2::kDistributions) {
    if (to_string(one) == name) return one;
  }
  throw ConfigError(fmt::format("unknown distribution '{}'; known: humble, jazzy, kilted", name));
}

nb::bytes recode(std::string_view type, std::string_view distribution, const nb::bytes& payload) {
  const std::span bytes(static_cast<const std::uint8_t*>(payload.data()), payload.size());
  const auto again = ros2::message_type(type).recode(bytes, distribution_named(distribution));
  if (!again) throw ContractError(again.error());
  return nb::bytes(again->data(), again->size());
}

}  // namespace

void init_ros2(nb::module_& m) {
  nb::class_<ros2::Server>(m, "Ros2Server", "Simulated robots as nodes of ROS 2.")
      .def(
          "run", [](ros2::Server& self, double wall) { self.run(seconds("wall", wall)); }, "wall"_a, WithoutGil(),
          "Serves for a time [wall s].")
      .def_prop_ro("now", &ros2::Server::now, "Robot time [s].");
  m.def(
      "ros2_serve",
      [](const std::string& scene, std::vector<std::string> robots, std::vector<std::string> namespaces,
         const std::string& noise, std::uint64_t seed, double speed, bool lockstep, bool map, bool autonomy) {
        backend::WorldOptions options;
        options.scene = scene;
        options.robots = std::move(robots);
        options.noise = noise_level(noise);
        options.seed = seed;
        std::unique_ptr<backend::World> world = backend::make_world("mock", options);
        ros2::ServeOptions served{std::move(namespaces), speed, lockstep, map};
        if (autonomy) {
          auto autonomous = std::make_unique<AutonomousWorld>(std::move(world));
          served.autonomies = autonomous->autonomies();
          world = std::move(autonomous);
        }
        return ros2::serve(std::move(world), served);
      },
      nb::kw_only(), "scene"_a, "robots"_a, "namespaces"_a, "noise"_a = "realistic", "seed"_a = 0, "speed"_a = 1.0,
      "lockstep"_a = false, "map"_a = false, "autonomy"_a = false, WithoutGil(),
      "Makes a simulated world and serves its robots, each in a namespace such as `/robot_1`; empty for none.");
  using ros2::Endpoint;
  nb::class_<Endpoint>(m, "Ros2Endpoint", "One publisher or subscription of the ROS 2 graph.")
      .def_ro("publishes", &Endpoint::publishes, "Or subscribes.")
      .def_ro("topic", &Endpoint::topic)
      .def_ro("type", &Endpoint::type, "Empty where it is none of ROS 2.")
      .def_ro("hash", &Endpoint::hash, "`RIHS01_...`; empty where it has none, as in Humble and on micro-ROS.")
      .def_prop_ro("reliable", [](const Endpoint& endpoint) { return endpoint.qos.reliable; })
      .def_prop_ro("transient_local", [](const Endpoint& endpoint) { return endpoint.qos.transient_local; })
      .def_ro("rate", &Endpoint::rate,
              "[Hz] of its topic's messages; 0 where fewer than two came, or their type is not known.")
      .def_ro("node", &Endpoint::node, "`/namespace/name`; empty where it has not been said.")
      .def("__repr__", [](const Endpoint& endpoint) {
        return fmt::format("Ros2Endpoint('{}', '{}')", endpoint.topic, endpoint.type);
      });
  nb::class_<ros2::Graph>(m, "Ros2Graph", "The ROS 2 graph as it was found.")
      .def_ro("endpoints", &ros2::Graph::endpoints)
      .def_ro("silence", &ros2::Graph::silence, "What was seen, and what to try, where there is no endpoint.");
  m.def(
      "ros2_discover", [](double wall) { return ros2::discover(seconds("wall", wall)); }, "wall"_a, WithoutGil(),
      "Every endpoint of the ROS 2 graph that is found within a time [wall s].");
  nb::class_<ros2::TopicUse>(m, "Ros2TopicUse", "What a robot's link would use of a topic.")
      .def_ro("topic", &ros2::TopicUse::topic)
      .def_ro("type", &ros2::TopicUse::type)
      .def_ro("sensor", &ros2::TopicUse::sensor, "That it would be used for, or `command`; empty for none.")
      .def_ro("reason", &ros2::TopicUse::reason, "Why it is not used.");
  nb::class_<ros2::LinkProposal>(m, "Ros2LinkProposal", "A `link:` section made of topics that were discovered.")
      .def_ro("topics", &ros2::LinkProposal::topics)
      .def_ro("missing", &ros2::LinkProposal::missing, "Sensors without a topic, and `command`.")
      .def_ro("yaml", &ros2::LinkProposal::yaml);
  m.def(
      "ros2_propose_link",
      [](const RobotProfile& profile, const std::vector<Endpoint>& endpoints) {
        return ros2::propose_link(profile, endpoints);
      },
      "profile"_a, "endpoints"_a, "Which topics a robot of a profile would use.");
  m.def(
      "ros2_distributions_with",
      [](std::string_view type, std::string_view hash) {
        std::vector<std::string> names;
        for (const auto one : ros2::distributions_with(type, hash)) names.emplace_back(to_string(one));
        return names;
      },
      "type"_a, "hash"_a, "The distributions in which a type has this hash.");
  m.def(
      "ros2_message_types",
      [] {
        std::vector<std::string> names;
        for (const ros2::MessageType& type : ros2::message_types()) names.emplace_back(type.name);
        return names;
      },
      "The names of all ROS 2 messages that we know.");
  m.def(
      "ros2_type_hash",
      [](std::string_view type, std::string_view distribution) {
        return ros2::message_type(type).hash(distribution_named(distribution));
      },
      "type"_a, "distribution"_a, "The hash of a message's type, `RIHS01_...`, as a distribution has it.");
  m.def("ros2_recode", &recode, "type"_a, "distribution"_a, "payload"_a,
        "Reads a message from CDR and writes it again, little-endian. Raises ContractError where it cannot be read.");
}
