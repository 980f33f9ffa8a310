// Shares of the basic color terms, as Python sees them.
#pragma once

#include <map>
#include <string>

#include <nanobind/stl/map.h>

#include "vision/detector.hpp"

namespace threewe {

/// By name, those that are there.
template <class Shares>
std::map<std::string, double> color_shares(const Shares& shares) {
  std::map<std::string, double> named;
  for (std::size_t term = 0; term < shares.size(); ++term) {
    if (shares[term] > 0) named.emplace(vision::color_names()[term], shares[term]);
  }
  return named;
}

}  // namespace threewe
