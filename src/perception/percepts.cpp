#include "threewe/perception/percepts.hpp"

namespace threewe::perception {

std::string_view to_string(SensorFault fault) {
  switch (fault) {
    case SensorFault::none: return "none";
    case SensorFault::silent: return "silent";
    case SensorFault::frozen: return "frozen";
    case SensorFault::implausible: return "implausible";
    case SensorFault::wrong_stamps: return "stamped wrongly";
    case SensorFault::late: return "late";
    case SensorFault::noisy: return "noisy";
    case SensorFault::shifted: return "shifted";
    case SensorFault::blind: return "blind";
    case SensorFault::contradicted: return "contradicted";
  }
  return "unknown";
}

}  // namespace threewe::perception
