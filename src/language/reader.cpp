// Reads whole texts: clauses one after the other, every way to read them kept, until one plan or several are left.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "language/meaning.hpp"
#include "language/sentence.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::language {
namespace {

constexpr std::size_t kMostReadings = 16;   // of the words up to one; more than one is ambiguous anyhow
constexpr std::size_t kLongestPlace = 200;  // [bytes]
constexpr std::string_view kMarks = ".,;:!?-";
constexpr std::string_view kSentenceEnds = ".;!?";

// What has been read up to a word.
struct Progress {
  std::vector<Step> steps;
  std::vector<Step> deferred;        // of "before you ...", which come at the end of the sentence
  std::vector<std::string> choices;  // places that are meant, where one was said that may be several
  std::optional<Meaning> last;       // of the clause before
  std::optional<ThingPhrase> thing;  // that was spoken of last
  bool separated = true;             // from the clause before, so that another may begin
  bool first = true;                 // nothing of the sentence has been read
  bool defers = false;               // the next clause is to be done later
  friend bool operator==(const Progress&, const Progress&) = default;
};

// A clause that begins at some word.
struct ClauseMatch {
  Meaning meaning{};
  Match match;
};

class Reader {
 public:
  explicit Reader(const Sentence& sentence) : sentence_(sentence), chart_(sentence) {}

  Reading read() {
    if (const std::optional<RefusalRule> rule = refusal()) return {.outcome = ReadingOutcome::refused, .rule = rule};
    std::map<std::string, Progress> plans = read_all(false);
    if (plans.size() == 1) return understood(plans.begin()->second);
    if (plans.size() > 1) return ambiguous(plans);
    if (!read_all(true).empty()) return route();
    return {.outcome = ReadingOutcome::not_understood, .word = word_not_read()};
  }

 private:
  // A refusal anywhere refuses the whole text; "do not ..." is none.
  std::optional<RefusalRule> refusal() {
    chart_.watch(false);
    std::optional<RefusalRule> found;
    const std::size_t negation = sentence_.lexicon().group("not");
    std::set<std::size_t> negated;
    for (std::size_t at = 0; at < sentence_.size() && !found; ++at) {
      for (const std::size_t end : chart_.ends(at, negation)) negated.insert(end);
      if (negated.contains(at)) continue;
      for (const auto& [rule, pattern] : sentence_.lexicon().refusals) {
        if (!chart_.match(pattern, at).empty()) found = rule;
        if (found) break;
      }
    }
    chart_.watch(true);
    return found;
  }

  // The plans of the whole text by their canonical texts.
  std::map<std::string, Progress> read_all(bool as_route) {
    progress_.assign(sentence_.size() + 1, {});
    progress_[0].push_back({});
    for (std::size_t at = 0; at < sentence_.size(); ++at) {
      const std::vector<Progress> here = std::move(progress_[at]);
      const bool may_begin = std::ranges::any_of(here, &Progress::separated);
      std::vector<ClauseMatch> begun;
      std::vector<ClauseMatch> continued;
      if (may_begin && as_route) begun = routes(at);
      if (may_begin && !as_route) begun = clauses(at, sentence_.lexicon().clauses);
      const bool may_go_on =
          !as_route && std::ranges::any_of(here, [](const Progress& one) { return one.last.has_value(); });
      if (may_begin && may_go_on) continued = clauses(at, sentence_.lexicon().continued);
      if (!here.empty()) chart_.reach(at);
      for (const Progress& so_far : here) {
        skip(so_far, at);
        if (!so_far.separated) continue;
        for (const ClauseMatch& one : begun) add_clause(so_far, one);
        if (!so_far.last) continue;
        for (const ClauseMatch& one : continued) {
          if (family_of(one.meaning) == family_of(*so_far.last)) add_clause(so_far, one);
        }
      }
    }
    std::map<std::string, Progress> plans;
    for (Progress& one : progress_.back()) {
      if (one.defers || !one.last) continue;
      end_sentence(one);
      std::string text = to_text({.outcome = ReadingOutcome::understood, .steps = one.steps});
      plans.emplace(std::move(text), std::move(one));
    }
    return plans;
  }

  // Marks, polite words, and what joins clauses.
  void skip(const Progress& so_far, std::size_t at) {
    Progress next = so_far;
    next.separated = true;
    if (sentence_.is_mark(at, kMarks)) {
      if (sentence_.is_mark(at, kSentenceEnds)) end_sentence(next);
      add(at + 1, std::move(next));
      return;
    }
    const std::size_t noun_phrase = sentence_.longest(at, Group::next_to);
    const std::vector<std::size_t> before = chart_.ends(at, index_of(Group::before));
    for (const Edge& edge : sentence_.edges(at)) {
      const std::size_t group = edge.phrase->group;
      const bool deferring = so_far.first && std::ranges::find(before, edge.end) != before.end();
      const bool joins = group == index_of(Group::join) && noun_phrase < edge.end + 1 && !deferring;
      if (group == index_of(Group::polite) || joins) add(edge.end, next);
      if (!so_far.first) continue;
      if (group == index_of(Group::after)) add(edge.end, next);
      if (group == index_of(Group::before) && so_far.deferred.empty()) {
        Progress later = next;
        later.defers = true;
        add(edge.end, std::move(later));
      }
    }
  }

  static void end_sentence(Progress& progress) {
    std::ranges::move(progress.deferred, std::back_inserter(progress.steps));
    progress.deferred.clear();
    progress.first = true;
  }

  std::vector<ClauseMatch> clauses(std::size_t at, const std::vector<Lexicon::Tables::Clause>& patterns) {
    std::vector<ClauseMatch> all;
    for (const auto& [meaning, pattern] : patterns) {
      for (Match& match : chart_.match(pattern, at)) all.push_back({meaning, std::move(match)});
    }
    return all;
  }

  std::vector<ClauseMatch> routes(std::size_t at) {
    std::vector<ClauseMatch> all;
    for (const Pattern& pattern : sentence_.lexicon().route) {
      for (const Match& match : chart_.match(pattern, at)) all.push_back({Meaning::route, {match.end, {}}});
    }
    return all;
  }

  void add_clause(const Progress& so_far, const ClauseMatch& clause) {
    const Slots& slots = clause.match.slots;
    std::vector<Step> steps = steps_of(clause.meaning, slots, so_far.thing);
    if (steps.empty() && clause.meaning != Meaning::route) return;
    Progress next = so_far;
    if (!steps.empty() && !(steps.back().thing == ThingPhrase{})) next.thing = steps.back().thing;
    std::ranges::move(steps, std::back_inserter(so_far.defers ? next.deferred : next.steps));
    if (next.choices.empty()) next.choices = slots.choices;
    next.last = clause.meaning;
    next.separated = next.first = next.defers = false;
    add(clause.match.end, std::move(next));
  }

  void add(std::size_t at, Progress progress) {
    std::vector<Progress>& here = progress_[at];
    if (here.size() < kMostReadings && std::ranges::find(here, progress) == here.end()) {
      here.push_back(std::move(progress));
    }
  }

  static Reading understood(Progress& plan) {
    if (!plan.choices.empty()) return {.outcome = ReadingOutcome::ambiguous, .meanings = plan.choices};
    return {.outcome = ReadingOutcome::understood, .steps = std::move(plan.steps)};
  }

  static Reading ambiguous(const std::map<std::string, Progress>& plans) {
    Reading reading{.outcome = ReadingOutcome::ambiguous};
    for (const auto& [text, plan] : plans) reading.meanings.push_back(text);
    return reading;
  }

  Reading route() const {
    std::size_t end = sentence_.size();
    while (end > 0 && sentence_.is_mark(end - 1, ".")) --end;
    const Step step{.skill = Skill::follow, .route = lower_case(sentence_.slice(0, end))};
    return {.outcome = ReadingOutcome::understood, .steps = {step}};
  }

  // Where reading came to an end: the word there, but for articles; the last word that was read where nothing follows,
  // or what joins clauses does.
  std::string word_not_read() const {
    std::size_t at = chart_.farthest();
    const auto is_article = [this](std::size_t word) { return sentence_.longest(word, Group::determiner) > word; };
    while (at + 1 < sentence_.size() && is_article(at) && !sentence_.is_mark(at + 1, kMarks)) ++at;
    const bool joins = at < sentence_.size() && sentence_.longest(at, Group::join) > at;
    if (at > 0 && (at >= sentence_.size() || joins)) --at;
    while (at > 0 && at < sentence_.size() && sentence_[at].token.kind == Token::Kind::mark) --at;
    return at < sentence_.size() ? sentence_[at].token.text : "";
  }

  const Sentence& sentence_;
  Chart chart_;
  std::vector<std::vector<Progress>> progress_;
};

bool has_control(std::string_view name) {
  return std::ranges::any_of(name, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
}

void check(std::string_view text, std::span<const std::string> places) {
  const std::size_t length = text.size() <= kLongestCommand ? text.size() : count_characters(text);
  if (length > kLongestCommand) {
    throw ContractError(fmt::format("text: expected at most {} characters, got {}", kLongestCommand, length));
  }
  if (places.size() > kMostPlaces) {
    throw ContractError(fmt::format("places: expected at most {}, got {}", kMostPlaces, places.size()));
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::string& name = places[i];
    if (name.empty() || name.size() > kLongestPlace || !is_utf8(name) || has_control(name)) {
      throw ContractError(fmt::format("places[{}]: expected a name of 1 to {} bytes, UTF-8 without control characters",
                                      i, kLongestPlace));
    }
  }
}

}  // namespace

Reading read(std::string_view text, const Lexicon& lexicon, std::span<const std::string> known_places) {
  check(text, known_places);
  const Sentence sentence(text, lexicon.tables(), known_places);
  return Reader(sentence).read();
}

}  // namespace threewe::language
