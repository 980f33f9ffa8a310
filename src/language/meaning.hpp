// Meanings: the steps that a clause asks for.
#pragma once

#include <optional>
#include <vector>

#include "language/chart.hpp"

namespace threewe::language {

/// The steps of a clause. `last` is the thing that was spoken of before it, for "it". Empty where they make no sense.
std::vector<Step> steps_of(Meaning meaning, const Slots& slots, const std::optional<ThingPhrase>& last);

/// What may go on without its verb after what: "turn around, then left".
Meaning family_of(Meaning meaning);

}  // namespace threewe::language
