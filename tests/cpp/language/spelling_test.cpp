// One edit apart, against the whole matrix of distances.
#include "language/spelling.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "draw.hpp"

namespace threewe::language {
namespace {

// Optimal string alignment distance, row by row.
std::size_t distance(const std::u32string& a, const std::u32string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

TEST_CASE("one edit apart is distance 1") {
  int apart = 0;
  for (std::uint64_t seed = 0; seed < cases(20000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const auto word = [&draw] {
      std::u32string letters;
      for (int i = draw.whole(0, 5); i > 0; --i) letters += static_cast<char32_t>(draw.whole('a', 'c'));
      return letters;
    };
    const std::u32string a = word();
    const std::u32string b = word();
    CHECK(is_one_edit_apart(a, b) == (distance(a, b) == 1));
    apart += is_one_edit_apart(a, b) ? 1 : 0;
  }
  CHECK(apart > static_cast<int>(cases(20000)) / 20);
}

TEST_CASE("forms of one word count once") {
  Spelling spelling;
  spelling.add("plant", "plant");
  spelling.add("plants", "plant");
  spelling.add("plane", "plane");
  CHECK(spelling.mended(U"plante").empty());  // plant or plane
  CHECK(spelling.mended(U"plantt") == "plant");
  CHECK(spelling.mended(U"pla").empty());
  CHECK(spelling.mended(U"plnats") == "plants");
}

}  // namespace
}  // namespace threewe::language
