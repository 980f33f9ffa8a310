#include "language/spelling.hpp"

#include <algorithm>
#include <utility>

#include "language/text.hpp"

namespace threewe::language {
namespace {

constexpr std::size_t kShortestMended = 4;  // [letters] shorter words are one edit away from too many others

}  // namespace

bool is_one_edit_apart(std::u32string_view a, std::u32string_view b) {
  if (a.size() > b.size()) std::swap(a, b);
  if (b.size() - a.size() > 1) return false;
  const auto first = static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
  const std::u32string_view rest_a = a.substr(first);
  const std::u32string_view rest_b = b.substr(first);
  if (a.size() < b.size()) return rest_a == rest_b.substr(1);
  if (rest_a.empty()) return false;
  if (rest_a.substr(1) == rest_b.substr(1)) return true;
  return rest_a.size() > 1 && rest_a[0] == rest_b[1] && rest_a[1] == rest_b[0] && rest_a.substr(2) == rest_b.substr(2);
}

void Spelling::add(const std::string& word, const std::string& base, bool mends) {
  std::u32string letters;
  for (const Token& token : tokens_of(word)) letters += token.letters;
  words_.emplace(word, Known{base, letters, mends && letters.size() >= kShortestMended});
}

std::string Spelling::mended(std::u32string_view letters) const {
  if (letters.size() < kShortestMended) return {};
  std::string best;
  const std::string* base = nullptr;
  for (const auto& [word, known] : words_) {
    if (!known.mends || !is_one_edit_apart(letters, known.letters)) continue;
    if (base != nullptr && *base != known.base) return {};
    base = &known.base;
    if (best.empty() || word == known.base) best = word;
  }
  return best;
}

}  // namespace threewe::language
