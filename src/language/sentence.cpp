#include "language/sentence.hpp"

#include <algorithm>
#include <utility>

namespace threewe::language {

Sentence::Sentence(std::string_view text, const Lexicon::Tables& lexicon, std::span<const std::string> places)
    : text_(text), lexicon_(lexicon) {
  for (const std::string& place : places) {
    std::vector<Token> name = tokens_of(place);
    if (name.size() > 1 && name.front().text == "the") name.erase(name.begin());  // said or not
    places_.push_back({place, std::move(name)});
  }
  read_words(text);
  find_edges();
  find_polite();
}

void Sentence::read_words(std::string_view text) {
  Spelling spelling;
  for (const auto& [word, base] : lexicon_.vocabulary) spelling.add(word, base, !lexicon_.rare.contains(word));
  for (const PlaceName& place : places_) {
    for (const Token& word : place.words) {
      if (word.kind == Token::Kind::word) spelling.add(word.text, word.text);
    }
  }
  for (Token& token : tokens_of(text)) {
    const auto contraction = lexicon_.contractions.find(token.text);
    if (contraction == lexicon_.contractions.end()) {
      add_word(std::move(token), spelling);
      continue;
    }
    for (const std::string& word : contraction->second) {
      Token part = token;
      part.text = word;
      add_word(std::move(part), spelling);
    }
  }
}

void Sentence::add_word(Token token, const Spelling& spelling) {
  Word word;
  word.read = token.text;
  if (token.kind == Token::Kind::word && !spelling.knows(token.text)) {
    if (const std::string mended = spelling.mended(token.letters); !mended.empty()) word.read = mended;
  }
  const auto form = lexicon_.forms.find(word.read);
  if (form != lexicon_.forms.end()) word.base = form->second;
  word.token = std::move(token);
  words_.push_back(std::move(word));
}

void Sentence::find_edges() {
  edges_.resize(words_.size() + 1);
  for (std::size_t from = 0; from < words_.size(); ++from) follow(from, 0, from);
}

// Every way down the trie; a word goes as it is read, and as what it is a form of.
void Sentence::follow(std::size_t from, std::size_t node, std::size_t at) {
  for (const Phrase& phrase : lexicon_.trie[node].phrases) edges_[from].push_back({at, &phrase});
  if (at == words_.size()) return;
  const auto& next = lexicon_.trie[node].next;
  for (const std::string* word : {&words_[at].read, &words_[at].base}) {
    if (word->empty()) continue;
    if (const auto found = next.find(*word); found != next.end()) follow(from, found->second, at + 1);
  }
}

void Sentence::find_polite() {
  behind_polite_.resize(words_.size() + 1);
  for (std::size_t at = words_.size() + 1; at-- > 0;) {
    const std::size_t begin = is_mark(at, ",") ? at + 1 : at;
    const std::size_t end = longest(begin, Group::polite);
    behind_polite_[at] = at;
    if (end == begin) continue;
    const std::size_t behind = behind_polite_[end];
    behind_polite_[at] = behind == end && is_mark(end, ",") ? end + 1 : behind;
  }
}

bool Sentence::is_mark(std::size_t at, std::string_view marks) const {
  if (at >= words_.size() || words_[at].token.kind != Token::Kind::mark) return false;
  return marks.find(words_[at].token.text) != std::string_view::npos;
}

bool Sentence::is_number(std::size_t at) const {
  return at < words_.size() && words_[at].token.kind == Token::Kind::number;
}

bool Sentence::is_word(std::size_t at, std::string_view word) const {
  return at < words_.size() && (words_[at].read == word || words_[at].base == word);
}

std::size_t Sentence::longest(std::size_t at, Group group) const {
  std::size_t end = at;
  if (at >= words_.size()) return end;
  for (const Edge& edge : edges_[at]) {
    if (edge.phrase->group == index_of(group)) end = std::max(end, edge.end);
  }
  return end;
}

std::string Sentence::slice(std::size_t begin, std::size_t end) const {
  std::string slice;
  if (begin >= end) return slice;
  for (const char c : text_.substr(words_[begin].token.begin, words_[end - 1].token.end - words_[begin].token.begin)) {
    const bool space = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!space) slice += c;
    if (space && slice.back() != ' ') slice += ' ';
  }
  return slice;
}

}  // namespace threewe::language
