// Whether instructions can be followed by their text: verify_instructions SEED SCENE COUNT.
//
// COUNT episodes of VLN are drawn in a scene: one of assets/scenes, or one that is generated from the seed. Somebody
// who is given a text, a start and a map made of the scene anew follows it; then the text of another episode, and its
// own with left and right swapped. Then comes an independent parser, which shares no code with the generator. Printed
// are the texts, then how many ended within a metre of the path's end.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "independent_parser.hpp"
#include "number.hpp"
#include "scene/scene_tables.hpp"
#include "task/interpreter.hpp"
#include "task/vln.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/scene/generator.hpp"

using namespace threewe;

namespace {

std::shared_ptr<const scene::SceneTables> tables_of(const std::string& name, std::uint64_t seed) {
  const RobotProfile robot = load_profile("3we_standard_v2");
  const double difficulty = static_cast<double>(seed % 101) / 100.0;
  auto scene = std::make_shared<const scene::Scene>(
      name == "generated" ? scene::generate(seed, {.difficulty = difficulty}) : scene::Scene::load(name));
  return std::make_shared<const scene::SceneTables>(scene, robot.body.footprint, robot.body.height);
}

std::string with_sides_swapped(const std::string& text) {
  std::string swapped;
  for (const std::string& word : language::words_of(text)) {
    if (!swapped.empty()) swapped += ' ';
    swapped += word == "left" ? "right" : word == "right" ? "left" : word;
  }
  return swapped;
}

// Knows a map and what it is told; where it ends up is judged by the task.
class Follower {
 public:
  Follower(const std::string& scene, std::uint64_t seed)
      : tables_(tables_of(scene, seed)), map_(*tables_, language::Language::load()) {}

  bool succeeds(const std::string& text, const task::Vln& vln, const task::VlnEpisode& episode) const {
    const auto reading = task::follow(text, map_, episode.start);
    return reading && vln.distance(episode.ending, reading->end) <= task::kPathEndReach;
  }

 private:
  std::shared_ptr<const scene::SceneTables> tables_;
  task::SemanticMap map_;
};

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 4 ? argv[1] : "");
  const auto count = parse_number(argc == 4 ? argv[3] : "");
  if (!seed || !count) {
    std::fputs("usage: verify_instructions SEED SCENE COUNT\n", stderr);
    return 2;
  }
  const std::string scene = argv[2];
  const task::Vln vln(tables_of(scene, *seed));
  const Follower follower(scene, *seed);
  std::vector<task::VlnEpisode> episodes;
  for (std::uint32_t i = 0; i < *count; ++i) episodes.push_back(vln.sample(*seed, i));

  const auto own_tables = tables_of(scene, *seed);
  const language::Language language = language::Language::load();
  IndependentParser parser(*own_tables, language);
  int by_independent_parser = 0;
  int followed = 0;
  int shuffled = 0;
  int with_sides = 0;
  int swapped = 0;
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    const task::VlnEpisode& episode = episodes[i];
    const std::string& other = episodes[(i + 1) % episodes.size()].instruction;
    const std::string mirrored = with_sides_swapped(episode.instruction);
    const bool names_sides = language::words_of(mirrored) != language::words_of(episode.instruction);
    std::printf("text %s\n", episode.instruction.c_str());
    followed += follower.succeeds(episode.instruction, vln, episode) ? 1 : 0;
    const auto end = parser.follow(episode.instruction, episode.start);
    const bool arrived = end && vln.distance(episode.ending, *end) <= task::kPathEndReach;
    by_independent_parser += arrived ? 1 : 0;
    if (!arrived) std::printf("lost %s\n", episode.instruction.c_str());
    shuffled += follower.succeeds(other, vln, episode) ? 1 : 0;
    with_sides += names_sides ? 1 : 0;
    swapped += names_sides && follower.succeeds(mirrored, vln, episode) ? 1 : 0;
  }
  std::printf("instructions %zu\nfollowed %d\nby_independent_parser %d\nshuffled %d\nwith_sides %d\nswapped %d\n",
              episodes.size(), followed, by_independent_parser, shuffled, with_sides, swapped);
}
