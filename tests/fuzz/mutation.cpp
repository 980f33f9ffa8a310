#include "mutation.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <random>
#include <string_view>
#include <utility>

namespace threewe::fuzz {
namespace {

constexpr std::array kExtremes = {"0",
                                  "-0.0",
                                  "1",
                                  "-1",
                                  "nan",
                                  ".nan",
                                  "inf",
                                  "-.inf",
                                  "1e308",
                                  "-1e308",
                                  "1e-320",
                                  "1e400",
                                  "1e6",
                                  "-1000000",
                                  "1000001",
                                  "8192",
                                  "8193",
                                  "16384",
                                  "32767",
                                  "-32768",
                                  "65535",
                                  "65536",
                                  "2147483647",
                                  "2147483648",
                                  "-2147483649",
                                  "4294967296",
                                  "9223372036854775807",
                                  "9223372036854775808",
                                  "18446744073709551615",
                                  "0.001",
                                  "6.2832",
                                  "3.14159",
                                  "1e9",
                                  "1e-9",
                                  "0x10",
                                  "true",
                                  "~",
                                  "{}",
                                  "[]",
                                  "*a",
                                  "&a",
                                  "<<",
                                  "!!int",
                                  "|",
                                  R"("\0")",
                                  "../../x"};

class TextMutation {
 public:
  TextMutation(std::string text, unsigned seed) : text_(std::move(text)), random_(seed) {}

  std::string apply() {
    const bool by_line = below(2) == 0;
    const Piece piece = by_line ? line() : word();
    const std::string copy = text_.substr(piece.begin, piece.size);
    switch (below(by_line ? 5 : 6)) {
      case 0: text_.erase(piece.begin, piece.size); break;
      case 1: text_.insert(piece.begin, by_line ? copy : copy + " "); break;
      case 2: {  // from elsewhere
        const Piece other = by_line ? line() : word();
        text_.replace(piece.begin, piece.size, text_.substr(other.begin, other.size));
        break;
      }
      case 3: {  // moved
        text_.erase(piece.begin, piece.size);
        text_.insert(by_line ? line().begin : word().begin, copy);
        break;
      }
      case 4: {  // many of the same
        std::string many;
        for (std::size_t n = std::size_t{1} << below(7); n > 0 && many.size() < text_.size() + 512; --n) many += copy;
        text_.insert(piece.begin, many);
        break;
      }
      default: text_.replace(piece.begin, piece.size, kExtremes[below(kExtremes.size())]); break;
    }
    return text_;
  }

 private:
  struct Piece {
    std::size_t begin;
    std::size_t size;
  };

  std::size_t below(std::size_t count) { return random_() % count; }

  Piece line() {
    const std::size_t at = below(text_.size() + 1);
    const std::size_t before = at == 0 ? std::string::npos : text_.rfind('\n', at - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    const std::size_t end = std::min(text_.find('\n', begin), text_.size());
    return {begin, std::min(end + 1, text_.size()) - begin};
  }

  Piece word() {
    const auto belongs = [this](std::size_t i) {
      const char c = text_[i];
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '+' || c == '_';
    };
    std::size_t begin = below(text_.size() + 1);
    while (begin < text_.size() && !belongs(begin)) ++begin;
    while (begin > 0 && begin < text_.size() && belongs(begin - 1)) --begin;
    std::size_t end = begin;
    while (end < text_.size() && belongs(end)) ++end;
    return {begin, end - begin};
  }

  std::string text_;
  std::minstd_rand random_;
};

}  // namespace

std::string change_text(std::string text, unsigned seed) { return TextMutation(std::move(text), seed).apply(); }

std::string change_bytes(std::string bytes, unsigned seed) {
  constexpr std::array<std::uint64_t, 8> kNumbers = {
      0, 1, 0x7F, 0xFF, 0x7FFF'FFFF, 0xFFFF'FFFF, 0x7FF0'0000'0000'0000, 0xFFFF'FFFF'FFFF'FFFF};
  std::minstd_rand random(seed);
  const auto below = [&](std::size_t count) { return static_cast<std::size_t>(random()) % count; };
  const std::size_t at = below(bytes.size() + 1);
  const std::size_t size = std::min(std::size_t{1} << below(7), bytes.size() - at);
  switch (below(6)) {
    case 0: bytes.erase(at, size); break;
    case 1: bytes.resize(at); break;
    case 2: bytes.insert(at, bytes.substr(below(bytes.size() + 1), size)); break;
    case 3: bytes.insert(at, size, static_cast<char>(below(256))); break;
    case 4: {  // a number of 1, 2, 4 or 8 bytes
      const std::uint64_t number = kNumbers[below(kNumbers.size())];
      std::memcpy(bytes.data() + at, &number, std::min(std::size_t{1} << below(4), bytes.size() - at));
      break;
    }
    default:
      if (at < bytes.size()) bytes[at] = static_cast<char>(below(256));
  }
  return bytes;
}

}  // namespace threewe::fuzz
