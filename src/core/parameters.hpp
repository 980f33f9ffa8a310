// Tuned parameters as data: fields of plain aggregates with name, unit, meaning, and what they grow with.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "threewe/core/time.hpp"

namespace threewe {

/// What a parameter is proportional to, from robot to robot. A default is that of the reference robot,
/// `3we_standard_v2`, of which each of these is 1.
enum class Scale {
  none,       ///< the same for every robot: shares, counts, what people and buildings are like
  size,       ///< half of the least width of the outline
  speed,      ///< linear operating limit
  turn_rate,  ///< angular operating limit
  travel,     ///< the time to drive one's own size: size / speed
  stopping,   ///< the way in which it stands still from full speed: reaction and braking
  reaction,   ///< from a command to its effect
  noise,      ///< standard deviation of the lidar's ranges
  bias,       ///< of the lidar's ranges
  scan,       ///< the time of a lidar's turn
  beam,       ///< the angle between two beams
};
/// Its name, such as "size".
std::string_view to_string(Scale scale);

/// How many times as large as the reference robot's each of them is.
struct Scales {
  double size = 1.0;       ///< see Scale
  double speed = 1.0;      ///< see Scale
  double turn_rate = 1.0;  ///< see Scale
  double stopping = 1.0;   ///< see Scale
  double reaction = 1.0;   ///< see Scale
  double noise = 1.0;      ///< see Scale
  double bias = 1.0;       ///< see Scale
  double scan = 1.0;       ///< see Scale
  double beam = 1.0;       ///< see Scale

  /// One of them; 1 for `none`.
  double of(Scale scale) const;
};

/// One field of an aggregate of parameters. It points into the aggregate.
struct Parameter {
  std::string name;                                ///< within its module, such as "recovery.same_place"
  std::variant<double*, int*, Duration*> value{};  ///< in its unit; of a duration, [s] wherever it is a number
  std::string_view unit;                           ///< such as "m"; empty for a share or a count
  Scale scale = Scale::none;                       ///< what it grows with
  std::string_view meaning;                        ///< what it does, in a line

  /// The value as a number.
  double number() const;
  /// Sets it; of a count the nearest whole one.
  void set(double number) const;
};

/// The fields of an aggregate, in order.
using Parameters = std::vector<Parameter>;

/// Appends the fields of a part of an aggregate, as "part.field".
void append(Parameters& all, std::string_view part, const Parameters& fields);

/// Turns the reference robot's values into those of a robot. With scales of 1 nothing changes, to the bit.
void scale_parameters(const Parameters& parameters, const Scales& scales);

}  // namespace threewe
