#include "core/parameters.hpp"

#include <fmt/format.h>

namespace threewe {
std::string_view to_string(Scale scale) {
  switch (scale) {
    case Scale::none: return "none";
    case Scale::size: return "size";
    case Scale::speed: return "speed";
    case Scale::turn_rate: return "turn_rate";
    case Scale::travel: return "travel";
    case Scale::stopping: return "stopping";
    case Scale::reaction: return "reaction";
    case Scale::noise: return "noise";
    case Scale::bias: return "bias";
    case Scale::scan: return "scan";
    case Scale::beam: return "beam";
  }
  return "unknown";
}

double Scales::of(Scale scale) const {
  switch (scale) {
    case Scale::none: return 1.0;
    case Scale::size: return size;
    case Scale::speed: return speed;
    case Scale::turn_rate: return turn_rate;
    case Scale::travel: return size / speed;
    case Scale::stopping: return stopping;
    case Scale::reaction: return reaction;
    case Scale::noise: return noise;
    case Scale::bias: return bias;
    case Scale::scan: return scan;
    case Scale::beam: return beam;
  }
  return 1.0;
}

double Parameter::number() const {
  if (const auto* real = std::get_if<double*>(&value)) return **real;
  if (const auto* count = std::get_if<int*>(&value)) return **count;
  return to_seconds(*std::get<Duration*>(value));
}

void Parameter::set(double number) const {
  if (const auto* real = std::get_if<double*>(&value)) {
    **real = number;
  } else if (const auto* count = std::get_if<int*>(&value)) {
    **count = static_cast<int>(number + (number < 0.0 ? -0.5 : 0.5));
  } else {
    *std::get<Duration*>(value) = from_seconds(number);
  }
}

void append(Parameters& all, std::string_view part, const Parameters& fields) {
  for (Parameter field : fields) {
    field.name = fmt::format("{}.{}", part, field.name);
    all.push_back(std::move(field));
  }
}

void scale_parameters(const Parameters& parameters, const Scales& scales) {
  for (const Parameter& parameter : parameters) {
    const double scale = scales.of(parameter.scale);
    if (scale != 1.0) parameter.set(scale * parameter.number());
  }
}

}  // namespace threewe
