#include "language/lexicon.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "core/config.hpp"
#include "core/names.hpp"
#include "language/text.hpp"
#include "language/vocabulary.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::language {
namespace {

using Words = std::vector<std::string>;

constexpr std::array<const char*, index_of(Group::others)> kGroups = {
    "kind",    "anything", "color",    "which", "place",    "numbered", "start", "number",
    "hundred", "fraction", "length",   "angle", "duration", "speed",    "side",  "determiner",
    "next_to", "inside",   "relative", "it",    "polite",   "join",     "after", "before"};
constexpr std::array<const char*, 20> kMeanings = {
    "go",  "return",      "forward",     "backward", "sideways", "turn",   "turn_around", "search", "explore",  "look",
    "see", "list_things", "list_places", "name",     "wait",     "exists", "where",       "count",  "position", "done"};
constexpr std::array<RefusalRule, 4> kRules = {RefusalRule::speed, RefusalRule::obstacle, RefusalRule::emergency_stop,
                                               RefusalRule::zone};
// What the reader asks for by name among the groups of the file.
constexpr std::array kNamedGroups = {"not",   "point",   "x",           "y",    "is",  "facing",     "theta",
                                     "minus", "ordinal", "side_of_you", "wall", "the", "this_place", "as"};

Words words_in(std::string_view phrase) {
  Words words;
  for (const Token& token : tokens_of(phrase)) words.push_back(token.text);
  return words;
}

// "boxes", "shelves" where the file says so, "armchairs"
std::string plural_of(const std::string& noun) {
  const auto ends_with = [&noun](std::string_view end) { return noun.ends_with(end); };
  if (ends_with("s") || ends_with("x") || ends_with("ch") || ends_with("sh")) return noun + "es";
  constexpr std::string_view kVowels = "aeiou";
  const bool consonant_y =
      noun.size() > 1 && ends_with("y") && kVowels.find(noun[noun.size() - 2]) == std::string_view::npos;
  return consonant_y ? noun.substr(0, noun.size() - 1) + "ies" : noun + "s";
}

// Fills the tables, section by section.
class Loader {
 public:
  Loader(ConfigNode root, Lexicon::Tables& tables) : root_(std::move(root)), tables_(tables) {}

  void load() {
    root_.integer_in("version", 1, 1000);
    for (std::size_t i = 0; i < kGroups.size(); ++i) tables_.groups.emplace(kGroups.at(i), i);
    things();
    places();
    quantities();
    small_words();
    groups();
    sentences();
    root_.finish();
  }

 private:
  void things() {
    const Language language = Language::load(root_.text("vocabulary"));
    std::map<std::string, std::string> plurals;
    for (const auto& [noun, plural] : root_.at("plurals").fields()) plurals[noun] = plural.text();
    const auto add_noun = [&](const ConfigNode& where, const std::string& noun, const std::string& kind) {
      const auto known = plurals.find(noun);
      const std::string plural = known == plurals.end() ? plural_of(noun) : known->second;
      add(where, Group::kind, noun, kind);
      add(where, Group::kind, plural, kind);
      const Words one = words_in(noun);
      const Words many = words_in(plural);
      for (std::size_t i = 0; i < std::min(one.size(), many.size()); ++i) {
        tables_.vocabulary.try_emplace(many[i], one[i]);
      }
    };
    for (const auto& [kind, node] : root_.at("kinds").fields()) {
      add_noun(node, kind, kind);
      for (const ConfigNode& noun : node.items()) add_noun(noun, noun.text(), kind);
    }
    for (const auto& [category_and_shape, noun] : language.nouns()) add_noun(root_, noun, category_and_shape.first);
    list("anything", Group::anything);
    for (const auto& [color, node] : root_.at("colors").fields()) {
      for (const ConfigNode& name : node.items()) add(name, Group::color, name.text(), color);
    }
    ConfigNode which = root_.at("which");
    for (const char* one : {"nearest", "farthest"}) {
      for (const ConfigNode& phrase : which.at(one).items()) add(phrase, Group::which, phrase.text(), one);
    }
    which.finish();
  }

  void places() {
    for (const ConfigNode& node : root_.at("places").items()) add(node, Group::place, node.text(), node.text());
    for (const ConfigNode& node : root_.at("numbered").items()) add(node, Group::numbered, node.text(), node.text());
    for (const ConfigNode& node : root_.at("start").items()) add(node, Group::start, node.text(), std::string(kStart));
  }

  void quantities() {
    constexpr std::array<std::pair<const char*, Group>, 6> kScales = {{{"numbers", Group::number},
                                                                       {"fractions", Group::fraction},
                                                                       {"lengths", Group::length},
                                                                       {"angles", Group::angle},
                                                                       {"durations", Group::duration},
                                                                       {"speeds", Group::speed}}};
    constexpr double kLargest = 1e6;
    for (const auto& [section, group] : kScales) {
      for (const auto& [phrase, node] : root_.at(section).fields()) {
        add(node, group, phrase, "", node.number_in(0.0, kLargest));
      }
    }
    list("hundred", Group::hundred);
    for (const ConfigNode& node : root_.at("left").items()) add(node, Group::side, node.text(), "left", 1.0);
    for (const ConfigNode& node : root_.at("right").items()) add(node, Group::side, node.text(), "right", -1.0);
    tables_.fastest = root_.number_in("fastest", 0.0, kLargest);
  }

  void small_words() {
    constexpr std::array<std::pair<const char*, Group>, 9> kLists = {{{"determiners", Group::determiner},
                                                                      {"next_to", Group::next_to},
                                                                      {"inside", Group::inside},
                                                                      {"relatives", Group::relative},
                                                                      {"it", Group::it},
                                                                      {"polite", Group::polite},
                                                                      {"joins", Group::join},
                                                                      {"after", Group::after},
                                                                      {"before", Group::before}}};
    for (const auto& [section, group] : kLists) list(section, group);
    for (const auto& [form, base] : root_.at("forms").fields()) {
      tables_.forms[form] = base.text();
      tables_.vocabulary[form] = base.text();
    }
    for (const ConfigNode& word : root_.at("rare").items()) tables_.rare.insert(word.text());
    for (const auto& [short_form, words] : root_.at("contractions").fields()) {
      tables_.contractions[short_form] = words_in(words.text());
      tables_.vocabulary.emplace(short_form, short_form);
    }
  }

  void groups() {
    std::size_t number = kGroups.size();
    ConfigNode section = root_.at("groups");
    for (const auto& [name, node] : section.fields()) {
      if (!tables_.groups.emplace(name, number).second) node.fail("the group '" + name + "' has another meaning");
      for (const ConfigNode& phrase : node.items()) add(phrase, number, phrase.text(), "", 0.0);
      ++number;
    }
    for (const char* needed : kNamedGroups) section.at(needed);
  }

  void sentences() {
    clauses("clauses", tables_.clauses);
    clauses("continued", tables_.continued);
    for (const ConfigNode& node : root_.at("route").items()) tables_.route.push_back(pattern(node));
    ConfigNode refusals = root_.at("refusals");
    for (const RefusalRule rule : kRules) {
      for (const ConfigNode& node : refusals.at(to_string(rule)).items()) {
        tables_.refusals.push_back({rule, pattern(node)});
      }
    }
    refusals.finish();
  }

  void clauses(const char* section, std::vector<Lexicon::Tables::Clause>& to) {
    ConfigNode all = root_.at(section);
    for (std::size_t i = 0; i < kMeanings.size(); ++i) {
      if (!all.has(kMeanings.at(i))) continue;
      for (const ConfigNode& node : all.at(kMeanings.at(i)).items()) {
        to.push_back({static_cast<Meaning>(i), pattern(node)});
      }
    }
    all.finish();
  }

  Pattern pattern(const ConfigNode& node) {
    try {
      Pattern pattern = parse_pattern(node.text(), tables_.groups);
      for_each_word(pattern, [this](const std::string& word) { tables_.vocabulary.emplace(word, word); });
      return pattern;
    } catch (const ConfigError& error) {
      node.fail(error.what());
    }
  }

  void list(const char* section, Group group) {
    for (const ConfigNode& node : root_.at(section).items()) add(node, group, node.text(), node.text());
  }
  void add(const ConfigNode& where, Group group, const std::string& phrase, const std::string& value,
           double number = 0.0) {
    add(where, index_of(group), phrase, value, number);
  }
  void add(const ConfigNode& where, std::size_t group, const std::string& phrase, const std::string& value,
           double number) {
    std::size_t at = 0;
    for (const std::string& word : words_in(phrase)) {
      const auto [next, is_new] = tables_.trie[at].next.emplace(word, tables_.trie.size());
      at = next->second;
      if (is_new) tables_.trie.emplace_back();
      tables_.vocabulary.emplace(word, word);
    }
    if (at == 0) where.fail("a phrase cannot be empty");
    tables_.trie[at].phrases.push_back({group, value, number});
    const bool stands_for_something = group < index_of(Group::determiner) && (!value.empty() || number != 0.0);
    if (words_in(phrase).size() == 1 && stands_for_something) {
      tables_.vocabulary[words_in(phrase).front()] = fmt::format("{} {} {}", group, value, number);
    }
  }

  ConfigNode root_;
  Lexicon::Tables& tables_;
};

}  // namespace

std::size_t Lexicon::Tables::group(std::string_view name) const { return groups.find(name)->second; }

Lexicon Lexicon::load(std::string_view name) {
  const auto file = find_asset("languages", name);
  return parse(ConfigNode::read(file), file.string());
}

Lexicon Lexicon::parse(const std::string& text, const std::string& name) {
  auto tables = std::make_shared<Tables>();
  Loader(ConfigNode::parse(text, name), *tables).load();
  Lexicon lexicon;
  lexicon.tables_ = std::move(tables);
  return lexicon;
}

}  // namespace threewe::language
