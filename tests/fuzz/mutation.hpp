// Random changes of inputs.
#pragma once

#include <string>

namespace threewe::fuzz {

/// One change of a text that knows what texts are made of: a number becomes another, often an extreme one; a word, a
/// line or a block of lines is lost, doubled, moved or taken from elsewhere.
std::string change_text(std::string text, unsigned seed);

/// One change of any bytes: some are lost, doubled or inserted, or become an extreme number.
std::string change_bytes(std::string bytes, unsigned seed);

}  // namespace threewe::fuzz
