#include "ros2/type_hash.hpp"

#include <fmt/format.h>

#include "ros2/sha256.hpp"

namespace threewe::ros2 {

void TypeDescriber::add_field(std::string_view name, const Kind& kind) {
  std::string& fields = types_[current_];
  if (!fields.empty()) fields += ", ";
  fields += fmt::format(
      R"({{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "string_capacity": {}, "nested_type_name": "{}"}}}})",
      name, kind.id, kind.capacity, kind.text_capacity, kind.nested);
}

std::string TypeDescriber::hash(std::string_view type) const {
  const auto described = [](std::string_view name, std::string_view fields) {
    return fmt::format(R"({{"type_name": "{}", "fields": [{}]}})", name, fields);
  };
  std::string own;
  std::string referenced;
  for (const auto& [name, fields] : types_) {
    if (name == type) {
      own = described(name, fields);
      continue;
    }
    if (!referenced.empty()) referenced += ", ";
    referenced += described(name, fields);
  }
  return "RIHS01_" +
         sha256(fmt::format(R"({{"type_description": {}, "referenced_type_descriptions": [{}]}})", own, referenced));
}

}  // namespace threewe::ros2
