// Raw type: one DDS type for every ROS 2 message, whose samples are payloads that the CDR codec reads and writes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ros2/dds/library.hpp"

namespace threewe::ros2 {

/// A topic of a participant, whose DDS type has this name. What `dds_write` is given of it is a `Payload`.
dds_entity_t create_topic(dds_entity_t participant, const std::string& topic, const std::string& type);

/// What is written: bytes, with their encapsulation.
using Payload = std::vector<std::uint8_t>;

/// Names a request: who wrote it, and as which of all that it has written, from 1 on.
struct RequestId {
  std::array<std::uint8_t, 16> writer{};
  std::int64_t number = 0;
  friend bool operator==(const RequestId&, const RequestId&) = default;
};

/// Which request such a sample is the reply to, as its sender says; empty where it says nothing.
std::optional<RequestId> answered_by(const ddsi_serdata& sample);
/// Which of all that its writer has written such a sample is, from 1 on; 0 where that is not known.
std::int64_t number_of(const ddsi_serdata& sample);
/// The bytes of a sample that `dds_takecdr` gave of such a topic.
std::span<const std::uint8_t> payload_of(const ddsi_serdata& sample);

}  // namespace threewe::ros2
