#include "language/text.hpp"

#include <algorithm>
#include <utility>

namespace threewe::language {
namespace {

constexpr char32_t kReplacement = 0xFFFD;

// One character of a text and the bytes that it takes.
struct Character {
  char32_t code = 0;
  std::size_t size = 1;
};

// RFC 3629: no overlong forms, no surrogates, nothing beyond U+10FFFF. What is wrong is one byte of U+FFFD.
Character character_at(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U; };
  const char32_t first = byte(at);
  if (first < 0x80) return {first, 1};
  const std::size_t size = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
  if (size == 0) return {kReplacement, 1};
  char32_t code = first & (0xFFU >> (size + 1));
  for (std::size_t k = 1; k < size; ++k) {
    if ((byte(at + k) & 0xC0U) != 0x80U) return {kReplacement, 1};
    code = code << 6U | (byte(at + k) & 0x3FU);
  }
  const bool overlong = (size == 3 && code < 0x800) || (size == 4 && code < 0x10000);
  const bool wrong = overlong || (code >= 0xD800 && code < 0xE000) || code > 0x10FFFF;
  return wrong ? Character{kReplacement, 1} : Character{code, size};
}

void append(std::string& text, char32_t code) {
  const auto put = [&text](char32_t bits) { text += static_cast<char>(bits); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0 | code >> 6U);
    put(0x80 | (code & 0x3FU));
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12U);
    put(0x80 | (code >> 6U & 0x3FU));
    put(0x80 | (code & 0x3FU));
  } else {
    put(0xF0 | code >> 18U);
    put(0x80 | (code >> 12U & 0x3FU));
    put(0x80 | (code >> 6U & 0x3FU));
    put(0x80 | (code & 0x3FU));
  }
}

char32_t lower(char32_t c) {
  const bool plain = (c >= U'A' && c <= U'Z') || (c >= 0xC0 && c <= 0xDE && c != 0xD7) || (c >= 0x391 && c <= 0x3A9) ||
                     (c >= 0x410 && c <= 0x42F);
  if (plain) return c + 0x20;
  if (c >= 0x400 && c <= 0x40F) return c + 0x50;
  const bool even_upper = (c >= 0x100 && c <= 0x137) || (c >= 0x14A && c <= 0x177);
  const bool odd_upper = (c >= 0x139 && c <= 0x148) || (c >= 0x179 && c <= 0x17E);
  if ((even_upper && c % 2 == 0) || (odd_upper && c % 2 == 1)) return c + 1;
  return c;
}

// Typographic marks as those of a keyboard.
char32_t plain(char32_t c) {
  switch (c) {
    case 0x2018:
    case 0x2019:
    case 0x02BC: return U'\'';
    case 0x201C:
    case 0x201D:
    case 0x201E:
    case 0xAB:
    case 0xBB: return U'"';
    case 0x2010:
    case 0x2011:
    case 0x2212: return U'-';
    case 0x2013:
    case 0x2014:
    case 0x2026: return U',';
    case 0xA0:
    case 0x202F: return U' ';
    default: return c;
  }
}

bool is_digit(char32_t c) { return c >= U'0' && c <= U'9'; }
bool is_space(char32_t c) { return c == U' ' || c == U'\t' || c == U'\r' || c == U'_'; }
bool is_mark(char32_t c) {
  constexpr std::u32string_view kMarks = U",.;:!?()\"-/=";
  return kMarks.find(c) != std::u32string_view::npos;
}
// What is beyond ASCII is taken for a letter, but for signs that stand alone.
bool is_letter(char32_t c) {
  const char32_t small = lower(c);
  return (small >= U'a' && small <= U'z') || (c >= 0xC0 && c != kReplacement && c != 0xD7 && c != 0xF7);
}

class Tokenizer {
 public:
  explicit Tokenizer(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) {
      const Character one = character_at(text, at);
      codes_.push_back(plain(one.code));
      begins_.push_back(at);
      at += one.size;
    }
    begins_.push_back(text.size());
  }

  std::vector<Token> tokens() {
    while (at_ < codes_.size()) {
      if (is_space(code())) {
        ++at_;
      } else if (is_digit(code()) || (code() == U'.' && is_digit(code(1)))) {
        number();
      } else if (is_letter(code())) {
        word();
      } else {
        sign();
      }
    }
    return std::move(tokens_);
  }

 private:
  char32_t code(std::size_t ahead = 0) const { return at_ + ahead < codes_.size() ? codes_[at_ + ahead] : 0; }
  bool follows_word() const { return at_ > 0 && (is_letter(codes_[at_ - 1]) || is_digit(codes_[at_ - 1])); }

  void number() {
    const std::size_t begin = at_;
    std::string digits;
    while (is_digit(code())) digits += static_cast<char>(codes_[at_++]);
    if (code() == U'.' && is_digit(code(1))) {
      digits += static_cast<char>(codes_[at_++]);
      while (is_digit(code())) digits += static_cast<char>(codes_[at_++]);
    }
    add(Token::Kind::number, digits, begin).value = value_of(digits);
  }

  // Without the locale. What has more digits than a double is as near as it gets.
  static double value_of(std::string_view digits) {
    double value = 0.0;
    double scale = 1.0;
    bool fraction = false;
    for (const char c : digits) {
      if (c == '.') {
        fraction = true;
        continue;
      }
      value = value * 10.0 + (c - '0');
      if (fraction) scale *= 10.0;
    }
    return value / scale;
  }

  void word() {
    const std::size_t begin = at_;
    std::u32string letters;
    while (is_letter(code()) || is_digit(code()) || (code() == U'\'' && is_letter(code(1)))) {
      letters += lower(codes_[at_++]);
    }
    std::string text;
    for (const char32_t c : letters) append(text, c);
    add(Token::Kind::word, text, begin).letters = letters;
  }

  // Whether a word of one letter ends here: an axis, as in "x-1".
  bool follows_axis() const {
    return at_ > 0 && is_letter(codes_[at_ - 1]) &&
           (at_ == 1 || !(is_letter(codes_[at_ - 2]) || is_digit(codes_[at_ - 2])));
  }

  // A hyphen within a word separates its parts, and another is a minus. An apostrophe that is not within a word quotes.
  void sign() {
    const std::size_t begin = at_;
    const char32_t c = code() == U'\'' || code() == U'`' ? U'"'
                       : code() == U'['                  ? U'('
                       : code() == U']'                  ? U')'
                                                         : code();
    const bool minus = is_digit(code(1)) || code(1) == U'.' || is_space(code(1));
    const bool joins = c == U'-' && (!minus || (follows_word() && !(follows_axis() && is_digit(code(1)))));
    ++at_;
    if (joins) return;
    if (c == U'\n') {
      add(Token::Kind::mark, ".", begin);
    } else if (c == 0xBD || c == 0xBC || c == 0xBE) {
      add(Token::Kind::number, "", begin).value = c == 0xBD ? 0.5 : c == 0xBC ? 0.25 : 0.75;
    } else if (is_mark(c)) {
      add(Token::Kind::mark, std::string(1, static_cast<char>(c)), begin);
    } else {
      const char32_t shown = c < 0x20 || (c >= 0x7F && c < 0xA0) ? kReplacement : c;
      std::string text;
      append(text, shown);
      add(Token::Kind::word, text, begin).letters = std::u32string(1, shown);
    }
  }

  Token& add(Token::Kind kind, const std::string& text, std::size_t begin) {
    Token token;
    token.kind = kind;
    token.text = text;
    token.begin = begins_[begin];
    token.end = begins_[at_];
    return tokens_.emplace_back(std::move(token));
  }

  std::vector<char32_t> codes_;
  std::vector<std::size_t> begins_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<Token> tokens_of(std::string_view text) { return Tokenizer(text).tokens(); }

std::size_t count_characters(std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < text.size(); at += character_at(text, at).size) ++count;
  return count;
}

bool is_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const Character one = character_at(text, at);
    if (one.code == kReplacement && one.size == 1) return false;
    at += one.size;
  }
  return true;
}

std::string lower_case(std::string_view text) {
  std::string lowered;
  for (std::size_t at = 0; at < text.size();) {
    const Character one = character_at(text, at);
    append(lowered, lower(one.code));
    at += one.size;
  }
  return lowered;
}

}  // namespace threewe::language
