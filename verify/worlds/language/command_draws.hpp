// Drawn commands: a plan, and a sentence that says it. They share the phrases of the lexicon with the grammar, and no
// code: the sentences are templates of their own, and the canonical text is written here once more.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "language/command_phrases.hpp"

namespace threewe::testing {

/// A sentence and what it means.
struct DrawnCommand {
  std::string text;
  std::string meant;  ///< canonical
};

/// Draws commands for a robot that knows `places()`.
class CommandDraws {
  using Names = std::vector<std::string>;
  struct Clause {
    std::string text;
    std::string meant;
    bool question = false;
  };

 public:
  CommandDraws(const CommandPhrases& phrases, std::uint64_t seed) : phrases_(phrases), bits_(seed) {}

  static const Names& places() {
    static const Names names = {"kitchen",  "lounge",       "lobby",        "corridor", "office 1",
                                "office 2", "meeting room", "storage room", "workshop"};
    return names;
  }

  /// One to three clauses. One in twenty is ambiguous, one in twenty asks for what no lexicon has.
  DrawnCommand draw() {
    if (chance(0.05)) return {polite(go() + "the office"), "ambiguous(office 1 | office 2)"};
    if (chance(0.05)) {
      const std::string unknown = pick({"zeppelin", "unicorn", "xylophone", "gazebo"});
      return {polite(pick({"find the ", "go to the ", "where is the ", "count the "}) + unknown),
              "not_understood(" + unknown + ")"};
    }
    std::vector<Clause> clauses;
    for (std::size_t i = 1 + whole(3); i > 0; --i) clauses.push_back(clause());
    return joined(clauses);
  }

 private:
  DrawnCommand joined(const std::vector<Clause>& clauses) {
    const auto& [first, meant, question] = clauses.front();
    if (clauses.size() == 2 && !clauses[1].question && chance(0.2)) {
      return {polite("before you " + clauses[1].text + ", " + first), meant + "; " + clauses[1].meant};
    }
    if (clauses.size() == 2 && !question && chance(0.1)) {
      return {polite("after you " + first + ", " + clauses[1].text), meant + "; " + clauses[1].meant};
    }
    DrawnCommand all{clauses.size() > 1 && chance(0.2) ? "first " + first : first, meant};
    for (std::size_t i = 1; i < clauses.size(); ++i) {
      all.text += pick({", then ", " and ", ". ", "; ", " and then ", ", after that ", ", "}) + clauses[i].text;
      all.meant += "; " + clauses[i].meant;
    }
    all.text = polite(all.text);
    return all;
  }

  Clause clause() {
    switch (whole(8)) {
      case 0: return driving();
      case 1: return pointing();
      case 2: return moving();
      case 3: return turning();
      case 4: return searching();
      case 5: return looking();
      case 6: return waiting();
      default: return asking();
    }
  }

  std::string go() { return pick({"go to ", "drive to ", "head over to ", "move to "}); }

  Clause driving() {
    if (chance(0.2)) {
      return {pick({"come back", "go home", "return to the start", "go back to where you started"}),
              "move_to_place(place=start)"};
    }
    const std::string to = chance(0.5) ? go() : one_of("reach") + " ";
    if (chance(0.4)) {
      const auto [said, arguments] = thing(false, false);
      return {to + said, "approach(" + arguments + ")"};
    }
    const std::string place = pick(places());
    return {to + the(typo(place)), "move_to_place(place=" + place + ")"};
  }

  Clause pointing() {
    const int x = static_cast<int>(whole(41)) - 20;
    const int y = static_cast<int>(whole(41)) - 20;
    const std::string a = number(x / 4.0);
    const std::string b = number(y / 4.0);
    const std::string said =
        pick({"(" + a + ", " + b + ")", a + ", " + b, "x " + a + " y " + b, "x=" + a + ", y=" + b});
    std::string meant = "x=" + a + ", y=" + b;
    if (chance(0.7)) return {pick({"go to ", "drive to ", "move to the point "}) + said, "move_to(" + meant + ")"};
    const int degrees = 15 * (static_cast<int>(whole(25)) - 12);
    meant += ", theta=" + number(degrees * kDegree);
    return {"go to " + said + pick({" facing ", ", facing ", " with a heading of "}) + number(degrees) + " degrees",
            "move_to(" + meant + ")"};
  }

  Clause moving() {
    const auto [said, meters] = length();
    const std::string forward = pick({"forward", "ahead", "straight ahead"});
    const std::string back = pick({"back", "backwards", "backward"});
    const std::string verb = pick({"move ", "go ", "drive "});
    const std::string by = chance(0.3) ? "by " : "";
    switch (whole(4)) {
      case 0: return {verb + forward + " " + by + said, "move_forward(distance=" + number(meters) + ")"};
      case 1: return {verb + said + " " + forward, "move_forward(distance=" + number(meters) + ")"};
      case 2: return {verb + said + " " + back, "move_forward(distance=" + number(-meters) + ")"};
      default: break;
    }
    const bool left = chance(0.5);
    return {verb + (left ? "left " : "right ") + said, "rotate(angle=" + number(left ? 90 * kDegree : -90 * kDegree) +
                                                           "); move_forward(distance=" + number(meters) + ")"};
  }

  Clause turning() {
    if (chance(0.2)) return {one_of("turn_around"), "rotate(angle=3.1416)"};
    const bool left = chance(0.5);
    const std::string side =
        left ? pick({"left", "to the left", "counterclockwise"}) : pick({"right", "to the right", "clockwise"});
    const std::string verb = pick({"turn ", "rotate ", "spin "});
    if (chance(0.3)) return {verb + side, "rotate(angle=" + number(left ? 90 * kDegree : -90 * kDegree) + ")"};
    const int degrees = 5 * (1 + static_cast<int>(whole(36)));
    const std::string angle = (chance(0.5) ? number(degrees) : spelled(degrees)) + pick({" degrees", " deg"});
    const std::string meant = "rotate(angle=" + number(left ? degrees * kDegree : -degrees * kDegree) + ")";
    return {chance(0.5) ? verb + side + " " + pick({"", "by "}) + angle : verb + pick({"", "by "}) + angle + " " + side,
            meant};
  }

  Clause searching() {
    const auto [said, arguments] = thing(false, true);
    return {one_of("find") + " " + said, "search(" + arguments + ")"};
  }

  Clause looking() {
    const std::string place = pick(places());
    const std::string go = "move_to_place(place=" + place + "); look()";
    switch (whole(6)) {
      case 0: return {"look around", "look()"};
      case 1: return {"look around in " + the(place), go};
      case 2: return {pick({"explore", "map the building", "explore the building"}), "explore()"};
      case 3: return {pick({"explore ", "map "}) + the(place), "explore(place=" + place + ")"};
      case 4: return {"what do you see", "look(); list_things()", true};
      default: return {"what is in " + the(place), go + "; list_things(place=" + place + ")", true};
    }
  }

  Clause waiting() {
    const int seconds = 1 + static_cast<int>(whole(99));
    const std::string count = chance(0.5) ? number(seconds) : spelled(seconds);
    if (chance(0.2)) return {"wait half a minute", "wait(duration=30)"};
    if (chance(0.2)) return {"wait " + count + " minutes", "wait(duration=" + number(60 * seconds) + ")"};
    const std::string verb = pick({"wait ", "wait for ", "pause for "});
    return {verb + count + pick({" seconds", " s", " sec"}), "wait(duration=" + number(seconds) + ")"};
  }

  Clause asking() {
    const std::string place = pick(places());
    const std::string go = "move_to_place(place=" + place + "); look(); answer(about=";
    const auto [one, about_one] = thing(false, false);
    const auto [many, about_many] = thing(true, false);
    const std::string there = ", place=" + place + ")";
    switch (whole(9)) {
      case 0: return {"is there " + one + " in " + the(place), go + "exists, " + about_one + there, true};
      case 1: return {"is there " + one, "search(" + about_one + "); answer(about=exists, " + about_one + ")", true};
      case 2: return {"where is " + one, "search(" + about_one + "); answer(about=where, " + about_one + ")", true};
      case 3: return {"how many " + many + " are in " + the(place), go + "count, " + about_many + there, true};
      case 4: return {"count the " + many + " in " + the(place), go + "count, " + about_many + there};
      case 5: return {"how many " + many + " are there", "explore(); answer(about=count, " + about_many + ")", true};
      case 6: return {"which places do you know", "list_places()", true};
      case 7: return {"what things do you know", "list_things()", true};
      default: return {"where are you", "answer(about=position)", true};
    }
  }

  // A thing and its arguments; of many without an article.
  std::pair<std::string, std::string> thing(bool many, bool with_place) {
    const bool pointed = !many && chance(0.3);
    const std::string which = pointed ? pick({"nearest", "farthest"}) : "";
    const std::string color = chance(0.5) ? key(phrases_.colors) : "";
    const auto [name, kind] = noun(many);
    std::string said = which.empty() ? "" : which + " ";
    if (!color.empty()) said += pick(phrases_.colors.at(color)) + " ";
    said += name;
    std::string arguments = "kind=" + kind;
    if (!color.empty()) arguments += ", color=" + color;
    if (!which.empty()) arguments += ", which=" + which;
    if (!many && chance(0.2)) {
      const auto [other, other_kind] = noun(false);
      const std::string other_color = chance(0.5) ? key(phrases_.colors) : "";
      const std::string tint = other_color.empty() ? "" : other_color + " ";
      said += " " + pick(phrases_.next_to) + " the " + tint + other;
      arguments += ", next_to=" + tint + other_kind;
    }
    if (with_place && chance(0.3)) {
      const std::string place = pick(places());
      said += " in " + the(place);
      arguments += ", place=" + place;
    }
    return {many ? said : "the " + said, arguments};
  }

  // What a kind is called, and the kind. "somebody" has neither article nor color.
  std::pair<std::string, std::string> noun(bool many) {
    const std::string kind = key(phrases_.kinds);
    std::string name;
    do name = pick(phrases_.kinds.at(kind));
    while (name.ends_with("body") || name.ends_with("one"));
    return {typo(many ? phrases_.plural(name) : name), kind};
  }

  std::pair<std::string, double> length() {
    switch (whole(5)) {
      case 0: return {"half a meter", 0.5};
      case 1: return {"one and a half meters", 1.5};
      case 2: break;
      default: {
        const int tenths = 1 + static_cast<int>(whole(50));
        return {number(tenths / 10.0) + pick({" m", " meters", "m"}), tenths / 10.0};
      }
    }
    const int centimeters = 1 + static_cast<int>(whole(199));
    const std::string count = chance(0.5) ? number(centimeters) : spelled(centimeters);
    return {count + pick({" cm", " centimeters"}), centimeters / 100.0};
  }

  std::string polite(const std::string& text) {
    const std::string before = pick({"", "", "please ", "could you ", "robot, ", "I want you to ", "okay, ", "now "});
    std::string said = before + text + pick({"", "", ".", "!", ", please", " please."});
    if (chance(0.5)) said[0] = said[0] >= 'a' && said[0] <= 'z' ? static_cast<char>(said[0] - 'a' + 'A') : said[0];
    return said;
  }

  // One letter wrong, missing, doubled or two swapped, in one word in five, where that is near one known word alone.
  std::string typo(const std::string& phrase) {
    if (phrase.size() < 5 || phrase.find(' ') != std::string::npos || !chance(0.2)) return phrase;
    std::string wrong = phrase;
    const std::size_t at = 1 + whole(phrase.size() - 2);
    switch (whole(4)) {
      case 0: wrong[at] = static_cast<char>('a' + whole(26)); break;
      case 1: wrong.erase(at, 1); break;
      case 2: wrong.insert(at, 1, wrong[at]); break;
      default: std::swap(wrong[at], wrong[at + 1]); break;
    }
    int near = 0;
    for (const std::string& word : phrases_.words) near += distance(word, wrong) <= 1 ? 1 : 0;
    const bool known = phrases_.words.contains(wrong);
    return near == 1 && !known && distance(phrase, wrong) == 1 ? wrong : phrase;
  }

  static std::size_t distance(const std::string& a, const std::string& b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) {
      for (std::size_t j = 0; j <= b.size(); ++j) {
        d[i][j] = i + j;
        if (i == 0 || j == 0) continue;
        d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
        const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
        if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
    return d[a.size()][b.size()];
  }

  static std::string the(const std::string& place) {
    return place.back() >= '0' && place.back() <= '9' ? place : "the " + place;
  }

  static std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4f", value);
    std::string shown = text.data();
    while (shown.back() == '0') shown.pop_back();
    if (shown.back() == '.') shown.pop_back();
    return shown == "-0" ? "0" : shown;
  }

  static std::string spelled(int count) {
    static const Names small = {"zero",     "one",     "two",     "three",     "four",     "five",    "six",
                                "seven",    "eight",   "nine",    "ten",       "eleven",   "twelve",  "thirteen",
                                "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"};
    static const Names tens = {"", "", "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety"};
    const auto n = static_cast<std::size_t>(count);
    if (n >= 100) return "one hundred" + (n > 100 ? " and " + spelled(count - 100) : "");
    if (n < 20) return small[n];
    return tens[n / 10] + (n % 10 > 0 ? "-" + small[n % 10] : "");
  }

  std::size_t whole(std::size_t below) { return static_cast<std::size_t>(bits_() % below); }
  bool chance(double share) { return static_cast<double>(bits_() >> 11U) * 0x1p-53 < share; }
  std::string pick(const Names& from) { return from[whole(from.size())]; }
  std::string one_of(const char* group) { return pick(phrases_.groups.at(group)); }
  std::string key(const Synonyms& all) {
    return std::next(all.begin(), static_cast<std::ptrdiff_t>(whole(all.size())))->first;
  }

  static constexpr double kDegree = 0.017453292519943295;  // [rad]
  const CommandPhrases& phrases_;
  std::mt19937_64 bits_;
};

}  // namespace threewe::testing
