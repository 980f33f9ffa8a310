#include "language/vocabulary.hpp"

#include <algorithm>

#include "core/config.hpp"
#include "core/exact.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::language {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Bytes beyond ASCII are letters of other languages.
bool is_in_word(char c) {
  return is_digit(c) || is_lower(lower(c)) || c == '\'' || static_cast<unsigned char>(c) >= 128;
}

std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

// A name in a scene as people say it.
std::string spoken(std::string_view name) {
  std::string text(name);
  std::ranges::replace(text, '_', ' ');
  return text;
}

}  // namespace

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  bool in_word = false;
  for (const char c : text) {
    const bool belongs = is_in_word(c);
    if (belongs && !in_word) words.emplace_back();
    if (belongs) words.back() += lower(c);
    in_word = belongs;
  }
  return words;
}

std::array<float, kEmbeddingSize> embedding_of(std::string_view text) {
  std::array<double, kEmbeddingSize> sums{};
  const auto add = [&sums](std::string_view gram) {
    const std::uint64_t hash = fnv1a(gram);
    sums.at(hash % kEmbeddingSize) += (hash >> 32U & 1U) != 0 ? -1.0 : 1.0;
  };
  const std::vector<std::string> words = words_of(text);
  for (std::size_t i = 0; i < words.size(); ++i) {
    add(words[i]);
    if (i > 0) add(words[i - 1] + ' ' + words[i]);
  }
  double squares = 0.0;
  for (const double sum : sums) squares += sum * sum;
  std::array<float, kEmbeddingSize> embedding{};
  if (squares == 0.0) return embedding;
  const double length = exact::sqrt(squares);
  for (std::size_t i = 0; i < sums.size(); ++i) embedding[i] = static_cast<float>(sums[i] / length);
  return embedding;
}

Language Language::load(std::string_view name) {
  ConfigNode root = ConfigNode::load(find_asset("languages", name));
  Language language;
  language.version_ = root.integer_in("version", 1, 1000);
  for (const auto& [room, spoken_name] : root.at("rooms").fields()) language.rooms_[room] = spoken_name.text();
  for (const auto& [category, shapes] : root.at("nouns").fields()) {
    for (const auto& [shape, noun] : shapes.fields()) language.nouns_[{category, shape}] = noun.text();
  }
  for (const ConfigNode& node : root.at("words").items()) {
    const std::string word = node.text();
    const auto token = static_cast<std::int32_t>(language.words_.size()) + kUnknownWord + 1;
    if (!language.tokens_.emplace(word, token).second) node.fail("the word '" + word + "' stands here twice");
    language.words_.push_back(word);
  }
  root.finish();
  return language;
}

std::int32_t Language::token(std::string_view word) const {
  const auto found = tokens_.find(word);
  return found == tokens_.end() ? kUnknownWord : found->second;
}

std::array<std::int32_t, kMostTokens> Language::tokens(std::string_view text) const {
  std::array<std::int32_t, kMostTokens> numbers{};
  const std::vector<std::string> words = words_of(text);
  for (std::size_t i = 0; i < std::min(words.size(), kMostTokens); ++i) numbers.at(i) = token(words[i]);
  return numbers;
}

std::string Language::room(std::string_view name) const {
  // "office_2" is an office with a number
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  const bool numbered = digits > 1 && digits < name.size() && name[digits - 1] == '_';
  const std::string_view kind = numbered ? name.substr(0, digits - 1) : name;
  const auto found = rooms_.find(kind);
  const std::string called = found == rooms_.end() ? spoken(kind) : found->second;
  return numbered ? called + " " + std::string(name.substr(digits)) : called;
}

std::string Language::thing(std::string_view category) const { return spoken(category); }

std::string Language::thing(std::string_view category, std::string_view shape) const {
  const auto found = nouns_.find({std::string(category), std::string(shape)});
  return found == nouns_.end() ? thing(category) : found->second;
}

}  // namespace threewe::language
