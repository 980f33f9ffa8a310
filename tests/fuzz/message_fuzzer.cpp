// ROS 2 messages as they come from the wire: two bytes that choose type and layout, then a CDR payload.
#include <cstdlib>

#include "fuzz.hpp"
#include "ros2/message_types.hpp"

using namespace threewe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const auto types = ros2::message_types();
  const ros2::MessageType& type = types[data[0] % types.size()];
  const ros2::Distribution layout = ros2::kDistributions[data[1] % ros2::kDistributions.size()];
  const std::span payload(data + 2, size - 2);
  fuzz::read({reinterpret_cast<const char*>(payload.data()), payload.size()}, [&] {
    const auto again = type.recode(payload, layout);
    // what was read is written as the same message
    if (again && type.recode(*again, layout) != again) std::abort();
  });
  return 0;
}
