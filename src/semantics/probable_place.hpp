// Probable places: what a part of a building is called by what stands in it, such as a kitchen by its refrigerator and
// counter.
#pragma once

#include <optional>
#include <string_view>

#include "semantics/semantic_map.hpp"

namespace threewe::semantics {

/// The part that is most probably a place of that name, as a point amid the things that say so, of origin `seen`.
/// Nothing where no things say so, or the name is none that things can say.
std::optional<Place> probable_place(const SemanticMap& map, std::string_view name);

}  // namespace threewe::semantics
