// Files as they look after somebody slipped: whoever reads them either accepts them or says where they are wrong.
#pragma once

#include <array>
#include <cctype>
#include <exception>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "draw.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::testing {

/// One mistake at a random place of a text of YAML, such as people, editors and disks make.
inline std::string with_mistake(const std::string& text, Draw& draw) {
  if (text.empty()) return text;
  std::string spoilt = text;
  const auto somewhere = [&draw](const auto& in) {
    return static_cast<std::size_t>(draw.whole(0, static_cast<int>(in.size()) - 1));
  };
  const auto any_of = [&](const auto& choices) { return std::string(choices[somewhere(choices)]); };
  const auto is_in_number = [](char c) { return std::isdigit(c) != 0 || c == '.' || c == '-' || c == '+'; };
  // a stretch of characters of one kind, the next one from some place on
  const auto stretch = [&](auto&& belongs) {
    std::size_t begin = somewhere(text);
    while (begin < text.size() && !belongs(text[begin])) ++begin;
    std::size_t end = begin;
    while (end < text.size() && belongs(text[end])) ++end;
    return std::pair(begin, end - begin);
  };

  constexpr std::array kNumbers = {"-1",    "0",      "1e30",  "-1e30", ".nan",       "nan",  ".inf",
                                   "1e400", "1e-320", "abc",   "1000",  "4294967296", "0.5",  "",
                                   "~",     "[1, 2]", "{}",    "-0.0",  "1,5",        "0x10", "99999999999999999999",
                                   "1.0.0", "true",   "\"1\"", "*a",    "!!int 3"};
  constexpr std::array kBits = {
      "{", "}", "[", "]",  ":",  ",",  "-",     "#",     "\"",   "'",    "&a ",          "*a",   "!", "%",
      "|", ">", "?", "\t", "\n", "\r", "---\n", "...\n", "<<: ", "\xff", "\xef\xbb\xbf", "\xc3", "@", "`"};
  switch (draw.whole(0, 9)) {
    case 0: return spoilt.erase(somewhere(text), 1);
    case 1: return spoilt.insert(somewhere(text), any_of(kBits));
    case 2: return spoilt.erase(somewhere(text));  // all of the rest
    case 3:
    case 4: {
      const auto [begin, length] = stretch(is_in_number);
      return spoilt.replace(begin, length, any_of(kNumbers));
    }
    case 5: {  // another digit
      const auto [begin, length] = stretch([](char c) { return std::isdigit(c) != 0; });
      if (length > 0) spoilt[begin] = static_cast<char>('0' + draw.whole(0, 9));
      return spoilt;
    }
    case 6: {  // a letter of a name
      const auto [begin, length] = stretch([](char c) { return std::isalpha(c) != 0; });
      if (length > 0) spoilt[begin + static_cast<std::size_t>(draw.whole(0, static_cast<int>(length) - 1))] = 'q';
      return spoilt;
    }
    case 7: {  // a field of a mapping in braces, twice
      const auto [begin, length] = stretch([](char c) { return c != ',' && c != '{' && c != '}' && c != '\n'; });
      return spoilt.insert(begin, text.substr(begin, length) + ", ");
    }
    default: {  // a line is lost, or stands twice
      std::size_t begin = text.rfind('\n', somewhere(text));
      begin = begin == std::string::npos ? 0 : begin + 1;
      const std::size_t length = text.find('\n', begin) - begin + 1;
      return draw.whole(0, 1) == 0 ? spoilt.erase(begin, length) : spoilt.insert(begin, text.substr(begin, length));
    }
  }
}

/// Whether a message begins with a place: one of `beginnings`, and a line's number after the name of a file.
inline bool begins_with_a_place(std::string_view message, const std::vector<std::string>& beginnings) {
  for (const std::string& beginning : beginnings) {
    if (!message.starts_with(beginning)) continue;
    const std::string_view rest = message.substr(beginning.size());
    if (!beginning.ends_with(".yaml:") || (!rest.empty() && rest[0] >= '1' && rest[0] <= '9')) return true;
  }
  return false;
}

/// Reads a text with one to three mistakes. Fails unless it is accepted, or is one ConfigError that says where.
template <typename Read>
void read_with_mistakes(const std::string& text, std::uint64_t seed, const std::vector<std::string>& places,
                        Read read) {
  Draw draw(seed);
  std::string spoilt = text;
  for (int mistakes = draw.whole(1, 3); mistakes > 0; --mistakes) spoilt = with_mistake(spoilt, draw);
  CAPTURE(seed);
  try {
    read(spoilt);
  } catch (const ConfigError& error) {
    CHECK_MESSAGE(begins_with_a_place(error.what(), places), error.what(), "\n", spoilt);
  } catch (const std::exception& other) {
    FAIL_CHECK("not a ConfigError: ", other.what(), "\n", spoilt);
  }
}

}  // namespace threewe::testing
