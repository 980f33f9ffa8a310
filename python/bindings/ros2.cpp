// The table of ROS 2 messages, for tests and for the command line.
#include "bindings.hpp"
#include "ros2/message_types.hpp"

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
