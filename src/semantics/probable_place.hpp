// Probable places: what a part of a building is called by what stands in it, such as a kitchen by its refrigerator and
// counter.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "semantics/semantic_map.hpp"

namespace threewe::semantics {

/// The part that is most probably a place of that name, as a point amid the things that say so, of origin `seen`.
/// Nothing where no things say so, or the name is none that things can say.
std::optional<Place> probable_place(const SemanticMap& map, std::string_view name);

/// A known thing that says that a thing of another kind stands near it, as both make the same place.
struct Hint {
  Vec2 around;         ///< [m]
  double share = 0.0;  ///< how much it says, 0 to 1
};
/// What the things of a map say of where one of a kind is; nothing for a kind that makes no place.
std::vector<Hint> hints(const SemanticMap& map, std::string_view kind);
/// How much they say that it stands at a point, 0 to 1: what the strongest one near it does.
double share_at(std::span<const Hint> hints, Vec2 point);

}  // namespace threewe::semantics
