// Writes a scene as the file that it could have been read from.
#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {
namespace {

// Plain where YAML has no other use for it, else in quotes.
std::string text(const std::string& value) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  if (!value.empty() && std::ranges::all_of(value, plain)) return value;
  std::string quoted = "\"";
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20) {
      quoted += fmt::format("\\x{:02x}", byte);
      continue;
    }
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string point(Vec2 p) { return fmt::format("[{}, {}]", p.x, p.y); }

// Quarter turns are written short, as people write them: the reader knows what is meant.
std::string angle(double theta) {
  if (theta == exact::kHalfPi) return "1.5708";
  if (theta == -exact::kHalfPi) return "-1.5708";
  if (theta == exact::kPi) return "3.1416";
  return fmt::format("{}", theta);
}

std::string pose(const Pose2D& p) { return fmt::format("[{}, {}, {}]", p.x, p.y, angle(p.theta)); }

class Writer {
 public:
  std::string write(const Scene& scene) {
    line("name: {}", text(scene.name));
    line("description: {}", text(scene.description));
    if (!scene.ceiling) line("ceiling: false");
    list("starts", scene.starts, [](const Pose2D& start) { return pose(start); });
    list("rooms", scene.rooms, [](const Room& room) {
      return fmt::format("{{name: {}, min: {}, max: {}, floor: {}, anchor: {}}}", text(room.name), point(room.min),
                         point(room.max), room.floor, point(room.anchor));
    });
    list("walls", scene.plan, wall);
    list("patches", scene.patches, [](const Patch& patch) {
      return fmt::format("{{name: {}, min: {}, max: {}, floor: {}, friction: {}}}", text(patch.name), point(patch.min),
                         point(patch.max), patch.floor, patch.friction);
    });
    list("people", scene.people, person);
    list("objects", scene.objects, [](const Object& object) {
      return fmt::format("{{category: {}, shape: {}, pose: {}, name: {}}}", text(object.category), text(object.shape),
                         pose(object.pose), text(object.name));
    });
    return std::move(out_);
  }

 private:
  static std::string wall(const WallPlan& plan) {
    std::string fields = fmt::format("a: {}, b: {}, thickness: {}, height: {}", point(plan.wall.a), point(plan.wall.b),
                                     plan.wall.thickness, plan.wall.height);
    const char* separator = ", doors: [";
    for (const Doorway& door : plan.doorways) {
      fields += fmt::format("{}{{name: {}, at: {}, width: {}}}", separator, text(door.name), door.at, door.width);
      separator = ", ";
    }
    return fmt::format("{{{}{}}}", fields, plan.doorways.empty() ? "" : "]");
  }

  static std::string person(const Person& person) {
    std::string route;
    for (const Vec2 waypoint : person.route) route += (route.empty() ? "" : ", ") + point(waypoint);
    return fmt::format("{{name: {}, speed: {}, radius: {}, route: [{}]}}", text(person.name), person.speed,
                       person.radius, route);
  }

  template <typename Items, typename Describe>
  void list(const char* field, const Items& items, Describe describe) {
    if (items.empty()) return;
    line("\n{}:", field);
    for (const auto& item : items) line("  - {}", describe(item));
  }

  template <typename... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
    out_ += '\n';
  }

  std::string out_;
};

}  // namespace

std::string to_yaml(const Scene& scene) { return Writer().write(scene); }

}  // namespace threewe::scene
