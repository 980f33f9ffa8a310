// ROS 2 messages as they come from the wire: two bytes that choose type and layout, then a CDR payload. Where
// THREEWE_FUZZ_MESSAGE names a message, all are of its type.
#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "fuzz.hpp"
#include "ros2/message_types.hpp"

using namespace threewe;

THREEWE_FUZZER(message)(std::string_view input) {
  if (input.size() < 2) return;
  const auto types = ros2::message_types();
  static const char* const only = std::getenv("THREEWE_FUZZ_MESSAGE");
  const auto named = [](const ros2::MessageType& t) { return t.name.substr(t.name.rfind('/') + 1) == only; };
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  const ros2::MessageType& type =
      only == nullptr ? types[bytes[0] % types.size()] : *std::find_if(types.begin(), types.end(), named);
  const ros2::Distribution layout = ros2::kDistributions[bytes[1] % ros2::kDistributions.size()];
  const std::span payload = bytes.subspan(2);
  fuzz::read(
      input.substr(2), [&] { (void)type.recode(payload, layout); }, fuzz::kMessageMemory, fuzz::kMessageMemoryPerByte);
  // what was read is written as the same message
  const auto again = type.recode(payload, layout);
  if (again && type.recode(*again, layout) != again) std::abort();
}
