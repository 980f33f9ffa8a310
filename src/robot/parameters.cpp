#include "robot/parameters.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "hardware/parameters.hpp"
#include "nav/autonomy.hpp"
#include "nav/params.hpp"
#include "perception/params.hpp"
#include "safety/params.hpp"
#include "slam/params.hpp"

namespace threewe {
namespace {

std::string origin_of(const Parameter& parameter, std::string_view module, const RobotProfile& profile) {
  const auto is_this = [&](const ParameterOverride& one) { return one.module == module && one.name == parameter.name; };
  const auto found = std::ranges::find_if(profile.autonomy, is_this);
  if (found != profile.autonomy.end()) return found->place;
  const double scale = scales_of(profile).of(parameter.scale);
  return scale == 1.0 ? "default" : fmt::format("{} x {:.3g}", to_string(parameter.scale), scale);
}

template <typename Params>
void append_module(std::vector<AutonomyParameter>& all, std::string_view module, Params own,
                   const RobotProfile& profile) {
  Params reference;
  const Parameters usual = parameters_of(reference);
  const Parameters fields = parameters_of(own);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Parameter& field = fields[i];
    all.push_back({fmt::format("{}.{}", module, field.name), field.number(), std::string(field.unit), usual[i].number(),
                   field.scale, origin_of(field, module, profile), std::string(field.meaning),
                   std::holds_alternative<int*>(field.value)});
  }
}

}  // namespace

std::vector<AutonomyParameter> autonomy_parameters(const RobotProfile& profile) {
  std::vector<AutonomyParameter> all;
  append_module(all, "nav", params_for<nav::Params>(profile, "nav"), profile);
  append_module(all, "slam", *slam::params_for(profile), profile);
  append_module(all, "health", params_for<perception::Params>(profile, "health"), profile);
  append_module(all, "safety", params_for<safety::Params>(profile, "safety"), profile);
  return all;
}

}  // namespace threewe
