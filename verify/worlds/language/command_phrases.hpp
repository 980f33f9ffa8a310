// Phrases of a lexicon file, as templates of sentences need them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::testing {

/// Names and what they may be called.
using Synonyms = std::map<std::string, std::vector<std::string>>;

/// The phrases of assets/languages/commands_english_v1.yaml.
struct CommandPhrases {
  Synonyms kinds;                              ///< what things are called
  std::map<std::string, std::string> plurals;  ///< of those that are no regular ones
  Synonyms colors;
  Synonyms groups;
  std::vector<std::string> next_to;
  std::set<std::string> words;  ///< to which typos may be mended

  CommandPhrases() {
    ConfigNode root = ConfigNode::load(find_asset("languages", "commands_english_v1"));
    kinds = synonyms(root.at("kinds"));
    for (auto& [kind, names] : kinds) names.push_back(kind);
    colors = synonyms(root.at("colors"));
    groups = synonyms(root.at("groups"));
    next_to = texts(root.at("next_to"));
    for (const auto& [noun, plural] : root.at("plurals").fields()) plurals[noun] = plural.text();
    for (const char* list : {"clauses", "continued", "refusals", "which"}) {
      for (const auto& [name, patterns] : synonyms(root.at(list))) add_words(patterns);
    }
    for (const char* list : {"anything", "places", "start", "left", "right", "determiners", "next_to", "inside",
                             "relatives", "it", "polite", "joins", "after", "before", "route"}) {
      add_words(texts(root.at(list)));
    }
    for (const Synonyms* all : {&kinds, &colors, &groups}) {
      for (const auto& [name, phrases] : *all) add_words(phrases);
    }
    for (const char* list : {"numbers", "fractions", "lengths", "angles", "durations", "forms", "plurals"}) {
      for (const auto& [name, node] : root.at(list).fields()) add_words({name, node.text()});
    }
    for (const auto& [kind, names] : kinds) {
      for (const std::string& name : names) add_words({plural(name)});
    }
    for (const auto& [category, shapes] :
         ConfigNode::load(find_asset("languages", "english_v1")).at("nouns").fields()) {
      for (const auto& [shape, name] : shapes.fields()) add_words({name.text(), plural(name.text())});
    }
    for (const std::string& word : texts(root.at("rare"))) words.erase(word);
  }

  /// More than one of a noun.
  std::string plural(const std::string& name) const {
    if (const auto known = plurals.find(name); known != plurals.end()) return known->second;
    const std::string end = name.substr(name.size() - std::min<std::size_t>(2, name.size()));
    const bool hissing = end.back() == 's' || end.back() == 'x' || end == "ch" || end == "sh";
    if (hissing) return name + "es";
    if (name.back() == 'y' && std::string("aeiou").find(end.front()) == std::string::npos)
      return name.substr(0, name.size() - 1) + "ies";
    return name + "s";
  }

 private:
  static std::vector<std::string> texts(const ConfigNode& list) {
    std::vector<std::string> all;
    for (const ConfigNode& node : list.items()) all.push_back(node.text());
    return all;
  }
  static Synonyms synonyms(const ConfigNode& map) {
    Synonyms all;
    for (const auto& [name, node] : map.fields()) all[name] = texts(node);
    return all;
  }
  // Slots of patterns are in upper case and none of the words.
  void add_words(const std::vector<std::string>& phrases) {
    for (const std::string& phrase : phrases) {
      std::string word;
      for (const char c : phrase + " ") {
        if ((c >= 'a' && c <= 'z') || c == '\'') {
          word += c;
        } else if (word.size() >= 4) {
          words.insert(word);
          word.clear();
        } else {
          word.clear();
        }
      }
    }
  }
};

}  // namespace threewe::testing
