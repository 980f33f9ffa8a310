// Change log of a map: the regions that changed, version by version.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "map/region.hpp"

namespace threewe::map {

/// The smallest rectangle that holds both.
Region united(const Region& a, const Region& b);

/// Remembers the changes of the newest versions of a map. Regions are in cells of the map's raster, counted from the
/// cell whose lower left corner is at (0, 0) m, so that they mean the same when the map has grown.
class ChangeLog {
 public:
  /// Versions are noted one by one, each the one before plus one.
  void note(std::uint64_t version, const Region& changed);
  /// What may differ between a version and the newest; nothing where that is too long ago to tell. Empty where nothing
  /// differs.
  std::optional<Region> since(std::uint64_t version) const;

 private:
  static constexpr std::size_t kKept = 64;
  std::array<Region, kKept> changed_{};  // by version, modulo kKept
  std::uint64_t newest_ = 0;
};

}  // namespace threewe::map
