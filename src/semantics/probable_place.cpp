#include "semantics/probable_place.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string>

namespace threewe::semantics {
namespace {

constexpr double kTogether = 2.5;     // [m] from one thing to the others that say the same
constexpr double kConvincing = 1.25;  // sum of weights times probabilities
constexpr double kLeastShare = 0.2;   // of a hint: weights times probability

// How much a thing of a kind says that a place has a name; a second of the kind says less.
struct Sign {
  std::string_view place;
  std::string_view kind;
  double weight = 0.0;
};

// By the furniture of dwellings and offices: one kind alone says it only of beds and shelves.
constexpr std::array kSigns = {
    Sign{"kitchen", "refrigerator", 1.0}, Sign{"kitchen", "counter", 0.9},    Sign{"kitchen", "cup", 0.2},
    Sign{"bedroom", "bed", 1.6},          Sign{"bedroom", "cabinet", 0.3},    Sign{"office", "desk", 1.0},
    Sign{"office", "monitor", 0.7},       Sign{"office", "chair", 0.5},       Sign{"study", "desk", 0.9},
    Sign{"study", "shelf", 0.8},          Sign{"living room", "couch", 1.1},  Sign{"living room", "table", 0.6},
    Sign{"lounge", "couch", 1.1},         Sign{"lounge", "table", 0.6},       Sign{"meeting room", "table", 0.8},
    Sign{"meeting room", "chair", 1.0},   Sign{"storage room", "shelf", 1.0}, Sign{"storage room", "box", 0.8},
    Sign{"storage", "shelf", 1.0},        Sign{"storage", "box", 0.8},
};

// What the things around a point say: of each kind, the most probable one.
struct Evidence {
  double sum = 0.0;
  Vec2 middle;
};

Evidence evidence(const SemanticMap& map, std::span<const MappedThing> things, std::string_view name, Vec2 around) {
  Evidence found;
  for (const Sign& sign : kSigns) {
    const auto kind = std::ranges::find(map.labels(), sign.kind);
    if (sign.place != name || kind == map.labels().end()) continue;
    const auto k = static_cast<std::size_t>(kind - map.labels().begin());
    const MappedThing* best = nullptr;
    for (const MappedThing& thing : things) {
      if (norm(thing.position - around) <= kTogether && (best == nullptr || thing.kinds[k] > best->kinds[k]))
        best = &thing;
    }
    if (best == nullptr) continue;
    const double says = sign.weight * best->kinds[k];
    found.sum += says;
    found.middle = found.middle + says * best->position;
  }
  if (found.sum > 0.0) found.middle = (1.0 / found.sum) * found.middle;
  return found;
}

}  // namespace

std::optional<Place> probable_place(const SemanticMap& map, std::string_view name) {
  const std::vector<MappedThing> things = map.things();
  Evidence best;
  for (const MappedThing& thing : things) {
    const Evidence here = evidence(map, things, name, thing.position);
    if (here.sum > best.sum) best = here;
  }
  if (best.sum < kConvincing) return {};
  return Place{.name = std::string(name), .polygon = {best.middle}, .origin = std::string(kSeen)};
}

std::vector<Hint> hints(const SemanticMap& map, std::string_view kind) {
  std::vector<Hint> found;
  const std::vector<MappedThing> things = map.things();
  for (const Sign& sought : kSigns) {
    if (sought.kind != kind) continue;
    for (const Sign& other : kSigns) {
      const auto label = std::ranges::find(map.labels(), other.kind);
      if (other.place != sought.place || other.kind == kind || label == map.labels().end()) continue;
      const auto k = static_cast<std::size_t>(label - map.labels().begin());
      for (const MappedThing& thing : things) {
        const double share = std::min(1.0, sought.weight * other.weight) * thing.kinds[k];
        if (share >= kLeastShare) found.push_back({thing.position, share});
      }
    }
  }
  return found;
}

double share_at(std::span<const Hint> hints, Vec2 point) {
  double most = 0.0;
  for (const Hint& hint : hints) {
    if (norm(hint.around - point) <= kTogether) most = std::max(most, hint.share);
  }
  return most;
}

}  // namespace threewe::semantics
