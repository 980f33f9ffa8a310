// Which solids may be seen in a picture, and the nearest walls that hide others.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/aligned_vector.hpp"
#include "sim/renderer/intersect.hpp"
#include "sim/renderer/view.hpp"

namespace threewe::sim::view {

/// A solid that may be in the picture.
struct Candidate {
  Candidate() {}  // NOLINT(modernize-use-equals-default): a defaulted one would clear the lines that are written anyway

  const VisibleSolid* visible = nullptr;
  const Sides* sides = nullptr;
  int solid = -1;          // index of one that stands in the scene
  std::size_t number = 0;  // among all candidates, walls first
  int first_block = 0;     // of columns
  int last_block = 0;
  double nearest = 0.0;  // no point of it has a greater inverse depth
  double low = 0.0;      // heights relative to the eye [m]
  double high = 0.0;
  Outline outline;
};

/// Working memory of a picture. Arrays by column reach to the end of the last block.
struct Candidates {
  std::vector<Candidate> walls;   // from floor to ceiling
  std::vector<Candidate> others;  // what may be seen before them
  std::vector<Sides> moving;      // of the solids that move
  struct Entry {
    double nearest = 0.0;  // the candidate's own, close at hand
    std::int32_t candidate = 0;
  };
  std::vector<Entry> order;                // `walls`, nearest first
  std::vector<std::vector<Entry>> blocks;  // `others`, by block
  std::vector<double> farthest;            // by block: no wall in it has a smaller inverse depth

  std::vector<std::uint32_t> groups;  // that may be in the picture
  std::size_t floor = 0;              // the region that the eye is over, or beyond the last

  AlignedVector<double> slopes;        // by column
  AlignedVector<double> wall_inverse;  // by column: of the nearest wall; infinity beyond the picture
  std::vector<std::int32_t> wall;      // which one that is, or -1
  std::vector<std::int32_t> wall_face;
};

void find_candidates(const Place& place, const View& view, std::span<const VisibleSolid> moving,
                     Candidates& candidates);

}  // namespace threewe::sim::view
