#include "xml.hpp"

#include <cmath>
#include <sstream>

#include <fmt/format.h>

namespace threewe::exports {

std::string text(double value) {
  constexpr double kRounding = 1e-14;
  return fmt::format("{}", std::fabs(value) < kRounding ? 0.0 : value);
}
std::string text(const Vec3& v) { return fmt::format("{} {} {}", text(v.x), text(v.y), text(v.z)); }
std::string text(const Quaternion& q) { return fmt::format("{} {} {} {}", text(q.w), text(q.x), text(q.y), text(q.z)); }
std::string text(const Color& c) { return fmt::format("{} {} {} 1", text(c.red), text(c.green), text(c.blue)); }

pugi::xml_node add(pugi::xml_node parent, const char* name, Attributes attributes) {
  pugi::xml_node child = parent.append_child(name);
  for (const auto& [key, value] : attributes) child.append_attribute(key).set_value(value.c_str());
  return child;
}

void add_text(pugi::xml_node parent, const char* name, const std::string& contents) {
  parent.append_child(name).text().set(contents.c_str());
}
void add_text(pugi::xml_node parent, const char* name, double value) { add_text(parent, name, text(value)); }

void add_comment(pugi::xml_node parent, const std::string& contents) {
  parent.append_child(pugi::node_comment).set_value(fmt::format(" {} ", contents).c_str());
}

std::string to_string(const pugi::xml_document& document) {
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace threewe::exports
