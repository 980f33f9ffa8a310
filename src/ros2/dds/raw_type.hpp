// Raw type: one DDS type for every ROS 2 message, whose samples are payloads that the CDR codec reads and writes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ros2/dds/library.hpp"

namespace threewe::ros2 {

/// A topic of a participant, whose DDS type has this name. What `dds_write` is given of it is a `Payload`.
dds_entity_t create_topic(dds_entity_t participant, const std::string& topic, const std::string& type);

/// What is written: bytes, with their encapsulation.
using Payload = std::vector<std::uint8_t>;

/// The bytes of a sample that `dds_takecdr` gave of such a topic.
std::span<const std::uint8_t> payload_of(const ddsi_serdata& sample);

}  // namespace threewe::ros2
