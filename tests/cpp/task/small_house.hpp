// A corridor from west to east with rooms on both sides, and a map of it.
//
//     kitchen |  study  | bedroom
//     --- D ------ D ------- D ---     doors at x = 2, 6, 10
//       start ->      corridor
//     --- D ------------- D -------    doors at x = 3, 9
//       office 1   |   office 2
#pragma once

#include <memory>
#include <utility>

#include "scene/scene_tables.hpp"
#include "task/semantic_map.hpp"

namespace threewe::task {

inline scene::Scene small_house() {
  return scene::Scene::parse(R"(
name: house
description: a corridor and five rooms
starts: [[0.6, 5, 0]]
rooms:
  - {name: corridor, min: [0, 4], max: [12, 6], floor: wood, anchor: [6, 5]}
  - {name: kitchen, min: [0, 6], max: [4, 10], floor: wood, anchor: [2, 7]}
  - {name: study, min: [4, 6], max: [8, 10], floor: wood, anchor: [6, 7]}
  - {name: bedroom, min: [8, 6], max: [12, 10], floor: wood, anchor: [10, 7]}
  - {name: office_1, min: [0, 0], max: [6, 4], floor: wood, anchor: [3, 3]}
  - {name: office_2, min: [6, 0], max: [12, 4], floor: wood, anchor: [9, 3]}
walls:
  - {a: [0, 0], b: [12, 0]}
  - {a: [12, 0], b: [12, 10]}
  - {a: [12, 10], b: [0, 10]}
  - {a: [0, 10], b: [0, 0]}
  - a: [0, 6]
    b: [12, 6]
    doors: [{name: a, at: 2, width: 1}, {name: b, at: 6, width: 1}, {name: c, at: 10, width: 1}]
  - {a: [0, 4], b: [12, 4], doors: [{name: d, at: 3, width: 1}, {name: e, at: 9, width: 1}]}
  - {a: [4, 6], b: [4, 10]}
  - {a: [8, 6], b: [8, 10]}
  - {a: [6, 0], b: [6, 4]}
objects:
  - {category: plant, shape: fern, pose: [4.5, 4.4, 0]}
  - {category: plant, shape: fern, pose: [11.6, 4.4, 0]}
  - {category: refrigerator, shape: tall, pose: [0.5, 9.5, 0]}
  - {category: chair, shape: wooden, pose: [4.6, 9.5, 0]}
  - {category: chair, shape: wooden, pose: [7.4, 9.5, 0]}
  - {category: chair, shape: tub, pose: [7.4, 7.5, 3.14]}
  - {category: shelf, shape: tower, pose: [7.7, 8.9, 3.14]}
)",
                             "house.yaml");
}

/// Everything that a map needs, kept together.
struct MappedScene {
  std::shared_ptr<const scene::SceneTables> tables;
  SemanticMap map;

  explicit MappedScene(scene::Scene scene, const Footprint& footprint = Footprint::rectangle(0.25, 0.22),
                       double height = 0.15)
      : tables(std::make_shared<const scene::SceneTables>(std::make_shared<const scene::Scene>(std::move(scene)),
                                                          footprint, height)),
        map(*tables, language::Language::load()) {}
};

}  // namespace threewe::task
