#include "core/names.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace threewe {
namespace {

const std::vector<std::string> kScenes{"office_v2", "apartment_v1", "corridor_v1", "warehouse_v1", "outdoor_v1"};

TEST_CASE("the nearest name is the one that was meant") {
  CHECK(nearest_name("ofice_v2", kScenes) == "office_v2");
  CHECK(nearest_name("office", kScenes) == "office_v2");
  CHECK(nearest_name("ofice", kScenes) == "office_v2");
  CHECK(nearest_name("wharehouse", kScenes) == "warehouse_v1");
  CHECK(nearest_name("office_v1", kScenes) == "office_v2");
  CHECK(nearest_name("coridor_v1", kScenes) == "corridor_v1");
  CHECK(nearest_name("wharehouse_v1", kScenes) == "warehouse_v1");
  CHECK(nearest_name("office_v2", kScenes) == "office_v2");
}

TEST_CASE("nothing is offered when nothing is near") {
  CHECK(nearest_name("zzzzzzzzzz", kScenes).empty());
  CHECK(nearest_name("q", kScenes).empty());
  CHECK(nearest_name("of", std::vector<std::string>{"x", "y", "theta"}).empty());
  CHECK(nearest_name("xyz", kScenes).empty());
  CHECK(nearest_name("", kScenes).empty());
  CHECK(nearest_name("office_v2", {}).empty());
}

TEST_CASE("of two equally near the first is offered") {
  const std::vector<std::string> names{"left", "lift"};
  CHECK(nearest_name("lft", names) == "left");
}

TEST_CASE("no character is cut in two") {
  const std::string text = "a\u00E9\u20AC\U0001F600";  // of 1, 2, 3 and 4 bytes
  const std::vector<std::size_t> ends{0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 10};
  for (std::size_t most = 0; most < ends.size(); ++most) CHECK(cut_text(text, most) == text.substr(0, ends[most]));
  CHECK(cut_text("\x80\x80", 1).empty());  // no text at all
}

TEST_CASE("messages") {
  CHECK(unknown_name("scene", "ofice_v2", kScenes) == "unknown scene 'ofice_v2'; did you mean 'office_v2'?");
  CHECK(unknown_name("scene", "zzzzzzzzzz", kScenes) ==
        "unknown scene 'zzzzzzzzzz'; known: office_v2, apartment_v1, corridor_v1, warehouse_v1, outdoor_v1");
  CHECK(unknown_name("scene", "anything", {}) == "unknown scene 'anything'; there are none");
}

}  // namespace
}  // namespace threewe
