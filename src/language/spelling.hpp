// Spelling correction: vocabulary entries that are one edit away.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace threewe::language {

/// Whether one letter wrong, missing or too many, or two neighbours swapped, is all that is between two different
/// words: optimal string alignment distance 1 (Damerau 1964). In time linear in their lengths.
bool is_one_edit_apart(std::u32string_view a, std::u32string_view b);

/// Words that are known, each with what it is a form of.
class Spelling {
 public:
  /// `mends`: whether typos may be mended to it.
  void add(const std::string& word, const std::string& base, bool mends = true);
  bool knows(std::string_view word) const { return words_.contains(word); }
  /// The one word of four letters and more that another such word is one edit away from; forms of one word count once.
  /// Empty where there is none, or more.
  std::string mended(std::u32string_view letters) const;

 private:
  struct Known {
    std::string base;
    std::u32string letters;
    bool mends = true;
  };
  std::map<std::string, Known, std::less<>> words_;
};

}  // namespace threewe::language
