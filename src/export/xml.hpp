// XML writer: an element, its attributes, its children.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>

#include <pugixml.hpp>

#include "export/shape.hpp"

namespace threewe::exports {

/// The shortest text that reads back as the same number; rounding errors of zero are zero.
std::string text(double value);
std::string text(const Vec3& v);
/// w, x, y, z
std::string text(const Quaternion& q);
/// Opaque, as red, green, blue and alpha.
std::string text(const Color& color);

using Attributes = std::initializer_list<std::pair<const char*, std::string>>;

/// Adds a child with attributes.
pugi::xml_node add(pugi::xml_node parent, const char* name, Attributes attributes = {});
/// Adds a child that holds text.
void add_text(pugi::xml_node parent, const char* name, const std::string& contents);
void add_text(pugi::xml_node parent, const char* name, double value);
/// Adds a comment.
void add_comment(pugi::xml_node parent, const std::string& contents);
/// The document, two spaces a level.
std::string to_string(const pugi::xml_document& document);

}  // namespace threewe::exports
