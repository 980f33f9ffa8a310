#include "task/vln.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/rng.hpp"
#include "narrator.hpp"
#include "scene/episodes.hpp"
#include "task/interpreter.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

using scene::GeodesicField;

constexpr std::uint64_t kTries = 4096;  // starts and endings, until a path can be put into words
constexpr double kSameEnd = 0.6;        // [m] between the ends of the readings of a good instruction, and of its path

// Every way in which an instruction could end.
std::vector<Ending> all_endings(const SemanticMap& map) {
  std::vector<Ending> endings;
  const auto add = [&](Clause::Kind kind, std::size_t room, std::size_t landmark, std::optional<std::size_t> opening,
                       std::optional<Vec2> place) {
    if (place) endings.push_back({kind, room, landmark, opening, *place});
  };
  for (std::size_t room = 0; room < map.rooms().size(); ++room) {
    add(Clause::Kind::stop_in_middle, room, 0, std::nullopt, map.middle_of(room));
    for (std::size_t i = 0; i < map.openings().size(); ++i) {
      if (!map.openings()[i].joins(room)) continue;
      if (map.openings()[i].is_door) add(Clause::Kind::stop_inside, room, 0, i, map.just_inside(room, i));
      for (std::size_t k = 0; k < map.landmarks().size(); ++k) {
        if (map.landmarks()[k].room != room) continue;
        // wherever a wide border is crossed, one stops at about the same place
        const Opening& o = map.openings()[i];
        const auto place = map.place_at(k, o.middle());
        const bool clear = place && distance(*place, *map.place_at(k, o.crossing(o.a))) <= kSameEnd &&
                           distance(*place, *map.place_at(k, o.crossing(o.b))) <= kSameEnd;
        if (clear) add(Clause::Kind::stop_at, room, k, i, place);
      }
    }
  }
  return endings;
}

// The first `count` of them after shuffling: the same on every machine.
void choose(std::vector<Ending>& endings, std::size_t count) {
  const RngKey key{.sensor = 4, .stream = Stream::sampler};
  for (std::size_t i = 0; i + 1 < endings.size() && i < count; ++i) {
    const auto left = static_cast<double>(endings.size() - i);
    std::swap(endings[i], endings[i + static_cast<std::size_t>(uniform(key, i) * left)]);
  }
  if (endings.size() > count) endings.resize(count);
}

}  // namespace

struct Vln::Endings {
  std::vector<Ending> all;
  std::vector<GeodesicField> fields;  // to each
};

Vln::Vln(std::shared_ptr<const scene::SceneTables> tables, int endings)
    : tables_(std::move(tables)), language_(language::Language::load()), map_(*tables_, language_) {
  auto made = std::make_unique<Endings>();
  made->all = all_endings(map_);
  choose(made->all, static_cast<std::size_t>(std::max(endings, 1)));
  for (const Ending& ending : made->all) made->fields.push_back(tables_->geodesic_field(ending.place, kLongestVlnPath));
  endings_ = std::move(made);
  sample(0, 0);  // throws where there is nowhere to go
}

Vln::~Vln() = default;
Vln::Vln(Vln&&) noexcept = default;
Vln& Vln::operator=(Vln&&) noexcept = default;

VlnEpisode Vln::sample(std::uint64_t seed, std::uint32_t index) const {
  const RngKey key{.seed = seed, .episode = index, .sensor = 3, .stream = Stream::sampler};
  const RngKey words{.seed = seed, .episode = index, .sensor = 5, .stream = Stream::sampler};
  VlnEpisode episode;
  const auto bits = random_bits(key, 0);
  episode.seed = std::uint64_t{bits[0]} << 32 | bits[1];
  const std::size_t count = endings_->all.size();
  for (std::uint64_t attempt = 1; attempt <= kTries && count > 0; ++attempt) {
    // a start and an ending
    episode.ending = static_cast<std::size_t>(uniform(key, attempt, 2) * static_cast<double>(count));
    const Ending& ending = endings_->all[episode.ending];
    const GeodesicField& field = endings_->fields[episode.ending];
    episode.start = scene::sample_roomy_pose(*tables_, key, attempt);
    episode.end = ending.place;
    episode.geodesic = field.length_from(episode.start.position());
    if (episode.geodesic < kShortestVlnPath || episode.geodesic > kLongestVlnPath) continue;

    // words for the way from the one to the other
    const std::vector<Vec2> corners = field.path_from(episode.start.position());
    RngKey wording = words;
    wording.robot = static_cast<std::uint16_t>(attempt);
    const auto said = describe(map_, episode.start, corners, ending, wording);
    if (!said) continue;
    wording.sensor = 6;
    episode.instruction = to_text(*said, wording);
    if (language::words_of(episode.instruction).size() > language::kMostTokens) continue;

    // that lead there, however they are understood
    const std::vector<Reading> found = readings(parse(episode.instruction, map_), map_, episode.start);
    const bool clear = !found.empty() && std::ranges::all_of(found, [&](const Reading& reading) {
      return field.length_from(reading.end) <= kSameEnd;
    });
    episode.path = points_along(corners, kPathSpacing);
    if (clear && episode.path.size() <= kMostPathPoints) return episode;
  }
  throw ConfigError(
      fmt::format("scene '{}' has no instructions: named rooms, ways between them and paths of {} to {} m "
                  "are needed",
                  tables_->scene().name, kShortestVlnPath, kLongestVlnPath));
}

double Vln::distance(std::size_t ending, Vec2 base) const { return endings_->fields[ending].length_from(base); }

VlnState Vln::begin(const VlnEpisode& episode) const {
  return {.stop = {.stop = {}, .distance = episode.geodesic},
          .score = begin_score(episode.path, episode.start.position())};
}

StopTaskStep Vln::step(const VlnEpisode& episode, VlnState& state, Vec2 base, std::span<const float, 3> action,
                       Duration period) const {
  advance(state.score, episode.path, base);
  return advance(state.stop, action, period, distance(episode.ending, base),
                 [&] { return state.stop.distance <= kPathEndReach; });
}

}  // namespace threewe::task
