// What commands are read as, row by row of what the grammar promises.
#include "threewe/language/command.hpp"

#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "threewe/core/errors.hpp"

namespace threewe::language {
namespace {

using Rows = std::vector<std::pair<std::string, std::string>>;

const std::vector<std::string> kPlaces = {"kitchen",  "lounge",       "lobby",        "corridor", "office 1",
                                          "office 2", "meeting room", "storage room", "workshop"};

std::string read_as(const std::string& text, const std::vector<std::string>& places = kPlaces) {
  static const Lexicon lexicon = Lexicon::load();
  return to_text(read(text, lexicon, places));
}

void check(const Rows& rows) {
  for (const auto& [said, meant] : rows) {
    CAPTURE(said);
    CHECK(read_as(said) == meant);
  }
}

TEST_CASE("places are driven to") {
  for (const char* said : {"go to the kitchen", "drive to kitchen", "take me to the kitchen",
                           "head over to the kitchen, please", "Go to the Kitchen!", "find the kitchen"}) {
    CAPTURE(said);
    CHECK(read_as(said) == "move_to_place(place=kitchen)");
  }
  for (const char* said : {"come back", "return to the start", "go home", "go back", "go back to where you started"}) {
    CAPTURE(said);
    CHECK(read_as(said) == "move_to_place(place=start)");
  }
  check({{"go to office two", "move_to_place(place=office 2)"},
         {"go to office number 2", "move_to_place(place=office 2)"},
         {"go to the storage", "move_to_place(place=storage room)"},
         {"go to the bathroom", "move_to_place(place=bathroom)"},
         {"go to office 7", "move_to_place(place=office 7)"},
         {"go to room 101", "move_to_place(place=room 101)"}});
}

TEST_CASE("things are approached and searched for") {
  check({{"go to the red chair", "approach(kind=chair, color=red)"},
         {"go to the nearest table", "approach(kind=table, which=nearest)"},
         {"drive to the table farthest away", "approach(kind=table, which=farthest)"},
         {"find the red chair", "search(kind=chair, color=red)"},
         {"look for the red chair", "search(kind=chair, color=red)"},
         {"search for the red chair", "search(kind=chair, color=red)"},
         {"locate the red chair", "search(kind=chair, color=red)"},
         {"find something red", "search(color=red)"},
         {"find the chair that is red", "search(kind=chair, color=red)"},
         {"find a plant in the lobby", "search(kind=plant, place=lobby)"},
         {"search the lobby for a plant", "search(kind=plant, place=lobby)"},
         {"find the red chair in the kitchen", "search(kind=chair, color=red, place=kitchen)"},
         {"go to the office chair", "approach(kind=chair)"},
         {"find the sofa", "search(kind=couch)"},
         {"find an armchair", "search(kind=chair)"},
         {"find the grey bookcase", "search(kind=shelf, color=gray)"},
         {"find a violet fridge", "search(kind=refrigerator, color=purple)"},
         {"find the nearest red chair next to the desk in the lobby",
          "search(kind=chair, color=red, which=nearest, next_to=desk, place=lobby)"},
         {"get closer to the blue couch", "approach(kind=couch, color=blue)"},
         {"I need you in the lobby", "move_to_place(place=lobby)"},
         {"find a plant and go to it", "search(kind=plant); approach(kind=plant)"}});
  for (const char* near : {"next to", "beside", "by", "near"}) {
    CAPTURE(near);
    CHECK(read_as("find the chair " + std::string(near) + " the white desk") ==
          "search(kind=chair, next_to=white desk)");
  }
}

TEST_CASE("points and motions have their numbers in SI units") {
  check({{"go to (2, 1)", "move_to(x=2, y=1)"},
         {"go to the point [2,-1]", "move_to(x=2, y=-1)"},
         {"drive to x 2 y -1.5", "move_to(x=2, y=-1.5)"},
         {"drive to x = 2 m, y = minus one m", "move_to(x=2, y=-1)"},
         {"go to x-1 y 2", "move_to(x=-1, y=2)"},
         {"go to 2, 1 facing 90 degrees", "move_to(x=2, y=1, theta=1.5708)"},
         {"go to (2, 1, 1.57)", "move_to(x=2, y=1, theta=1.57)"},
         {"move forward 75 cm", "move_forward(distance=0.75)"},
         {"move forward seventy-five centimeters", "move_forward(distance=0.75)"},
         {"drive two meters ahead", "move_forward(distance=2)"},
         {"back up half a meter", "move_forward(distance=-0.5)"},
         {"go 1 m backwards", "move_forward(distance=-1)"},
         {"drive one and a half meters", "move_forward(distance=1.5)"},
         {"go a meter and a half ahead", "move_forward(distance=1.5)"},
         {"move forward 1 m 50 cm", "move_forward(distance=1.5)"},
         {"move ½ m", "move_forward(distance=0.5)"},
         {"move 1/4 m", "move_forward(distance=0.25)"},
         {"advance by zero point five meters", "move_forward(distance=0.5)"},
         {"move left 50 cm", "rotate(angle=1.5708); move_forward(distance=0.5)"},
         {"turn left", "rotate(angle=1.5708)"},
         {"turn right 30 degrees", "rotate(angle=-0.5236)"},
         {"turn around", "rotate(angle=3.1416)"},
         {"face the other way", "rotate(angle=3.1416)"},
         {"rotate by 45 deg counterclockwise", "rotate(angle=0.7854)"},
         {"turn 90° to the right", "rotate(angle=-1.5708)"},
         {"make a half turn", "rotate(angle=3.1416)"},
         {"turn left, then right", "rotate(angle=1.5708); rotate(angle=-1.5708)"},
         {"wait 5 seconds", "wait(duration=5)"},
         {"wait half a minute", "wait(duration=30)"},
         {"wait for 1 minute and 30 seconds", "wait(duration=90)"},
         {"wait 9999999 hours", "not_understood(9999999)"}});
}

TEST_CASE("looking, exploring, naming, ending") {
  check({{"explore", "explore()"},
         {"map the building", "explore()"},
         {"explore the workshop", "explore(place=workshop)"},
         {"look around", "look()"},
         {"look around in the lounge", "move_to_place(place=lounge); look()"},
         {"which places do you know?", "list_places()"},
         {"this is the kitchen", "name_place(name=kitchen)"},
         {"call this place kitchen", "name_place(name=kitchen)"},
         {"name this room \"copy room\"", "name_place(name=copy room)"},
         {"call this place Bob's Corner, please", "name_place(name=Bob's Corner)"},
         {"this place is called workshop", "name_place(name=workshop)"},
         {"call this lab", "name_place(name=lab)"},
         {"this is great", "not_understood(great)"},
         {"this is not the kitchen", "not_understood(not)"},
         {"stop", "done()"},
         {"you are done", "done()"},
         {"that's all", "done()"}});
}

TEST_CASE("questions are looked up before they are answered") {
  check({{"what do you see?", "look(); list_things()"},
         {"what things do you know?", "list_things()"},
         {"what is in the lounge?", "move_to_place(place=lounge); look(); list_things(place=lounge)"},
         {"is there a plant in the lobby?",
          "move_to_place(place=lobby); look(); answer(about=exists, kind=plant, place=lobby)"},
         {"is anybody in the lounge?",
          "move_to_place(place=lounge); look(); answer(about=exists, kind=person, place=lounge)"},
         {"is there a red chair?", "search(kind=chair, color=red); answer(about=exists, kind=chair, color=red)"},
         {"where is the plant?", "search(kind=plant); answer(about=where, kind=plant)"},
         {"tell me where the plant is", "search(kind=plant); answer(about=where, kind=plant)"},
         {"how many chairs are in the lounge?",
          "move_to_place(place=lounge); look(); answer(about=count, kind=chair, place=lounge)"},
         {"count the chairs in the lounge",
          "move_to_place(place=lounge); look(); answer(about=count, kind=chair, place=lounge)"},
         {"how many chairs are there?", "explore(); answer(about=count, kind=chair)"},
         {"count the chairs", "explore(); answer(about=count, kind=chair)"},
         {"where are you?", "answer(about=position)"}});
}

TEST_CASE("several commands follow one another in the order in which they are done") {
  const std::string both = "move_to_place(place=kitchen); search(kind=chair, color=red)";
  for (const char* said :
       {"go to the kitchen and find the red chair", "go to the kitchen, then find the red chair",
        "Go to the kitchen. Find the red chair.", "go to the kitchen; find the red chair",
        "first go to the kitchen, after that find the red chair", "before you find the red chair, go to the kitchen",
        "after you have gone to the kitchen, find the red chair", "go to the kitchen before you find the red chair"}) {
    CAPTURE(said);
    CHECK(read_as(said) == both);
  }
  check({{"go to the kitchen and then come back", "move_to_place(place=kitchen); move_to_place(place=start)"},
         {"go to the kitchen and the lobby", "move_to_place(place=kitchen); move_to_place(place=lobby)"},
         {"before you go to the lobby, turn left, then wait 5 s. Stop.",
          "rotate(angle=1.5708); wait(duration=5); move_to_place(place=lobby); done()"},
         {"go to the kitchen after you find the chair", "not_understood(after)"},
         {"go to the kitchen find the chair", "not_understood(find)"}});
}

TEST_CASE("routes are followed by their text") {
  check({{"Walk past the chair on your left and stop at the desk.",
          "follow(route=walk past the chair on your left and stop at the desk)"},
         {"turn left, go through the door and enter the kitchen",
          "follow(route=turn left, go through the door and enter the kitchen)"},
         {"Leave the kitchen through the second door on your right into the corridor, then stop just inside.",
          "follow(route=leave the kitchen through the second door on your right into the corridor, then stop just "
          "inside)"},
         {"walk past the unicorn on your left", "not_understood(unicorn)"},
         {"explore, then go through the door", "not_understood(through)"}});
}

TEST_CASE("what may be several is asked") {
  check({{"go to the office", "ambiguous(office 1 | office 2)"},
         {"find a chair in the office", "ambiguous(office 1 | office 2)"}});
  CHECK(read_as("go to the desk", {"desk"}) == "ambiguous(approach(kind=desk) | move_to_place(place=desk))");
}

TEST_CASE("the word that could not be read is named") {
  check({{"go forward", "not_understood(forward)"},
         {"go to the garage", "not_understood(garage)"},
         {"go to the kitchen and dance", "not_understood(dance)"},
         {"sing a song", "not_understood(sing)"},
         {"wait", "not_understood(wait)"},
         {"go around the chair", "not_understood(around)"},
         {"avoid the keep-out zone", "not_understood(avoid)"},
         {"Stop the MUSIC", "not_understood(music)"},
         {"go to", "not_understood(to)"},
         {"hello", "not_understood(hello)"},
         {"", "not_understood()"}});
}

TEST_CASE("one typo in a long word is mended where one word alone is near") {
  check({{"go to the kichen", "move_to_place(place=kitchen)"},
         {"go to the kitchenn", "move_to_place(place=kitchen)"},
         {"find the rde chair", "not_understood(rde)"},
         {"find the red chiar", "search(kind=chair, color=red)"},
         {"serach for the yelow tabel", "search(kind=table, color=yellow)"},
         {"trun left", "rotate(angle=1.5708)"},
         {"move foward 1 metre", "move_forward(distance=1)"}});
  CHECK(read_as("go to the bazar", {"bazaar", "bizar"}) == "not_understood(bazar)");
}

TEST_CASE("politeness says nothing") {
  for (const char* said :
       {"please go to the kitchen", "could you go to the kitchen", "Robot, go to the kitchen now",
        "I want you to go to the kitchen", "okay, go to the kitchen", "go please to the kitchen",
        "hello robot, would you please go to the kitchen, thank you very much!", "go, please, to the kitchen"}) {
    CAPTURE(said);
    CHECK(read_as(said) == "move_to_place(place=kitchen)");
  }
}

TEST_CASE("what no robot does is refused, anywhere in a text") {
  check({{"Faster than allowed", "refused(speed)"},
         {"through the wall", "refused(obstacle)"},
         {"ignore the stop", "refused(emergency_stop)"},
         {"ignore the stop and go to the kitchen", "refused(emergency_stop)"},
         {"drive to the kitchen, ignoring the emergency stop", "refused(emergency_stop)"},
         {"go to the kitchen, ignoring all stops", "refused(emergency_stop)"},
         {"ignore the zones", "refused(zone)"},
         {"drive to the kitchen, disregarding any zone", "refused(zone)"},
         {"drive to the kitchen, ignoring the limit", "refused(speed)"},
         {"go to the kitchen and stop", "move_to_place(place=kitchen); done()"},
         {"go faster than allowed", "refused(speed)"},
         {"drive to the kitchen at full speed 3 m/s", "refused(speed)"},
         {"drive to the kitchen at 3 m/s", "refused(speed)"},
         {"drive as fast as you can, ignore the limit", "refused(speed)"},
         {"drive through the wall", "refused(obstacle)"},
         {"drive over the chair", "refused(obstacle)"},
         {"ram the desk", "refused(obstacle)"},
         {"push the box away", "refused(obstacle)"},
         {"ignore the emergency stop", "refused(emergency_stop)"},
         {"release the emergency stop", "refused(emergency_stop)"},
         {"reset the e-stop", "refused(emergency_stop)"},
         {"disable the emergency stop", "refused(emergency_stop)"},
         {"ignore the keep-out zone", "refused(zone)"},
         {"enter the keep-out zone", "refused(zone)"},
         {"cross the keep-out zone", "refused(zone)"},
         {"go to the kitchen and then sing and ram the desk", "refused(obstacle)"},
         {"do not ram the desk", "not_understood(not)"}});
}

TEST_CASE("known places have any names") {
  const std::vector<std::string> places = {"Büro 3", "R&D",  "O'Brien's desk", "lab-2",
                                           "кухня",  "3.14", "A b  c.d",       "the Lab"};
  for (const std::string& place : places) {
    CAPTURE(place);
    CHECK(read_as("go to " + place, places) == "move_to_place(place=" + place + ")");
    CHECK(read_as("find a chair in " + place + ", then stop", places) ==
          "search(kind=chair, place=" + place + "); done()");
  }
  CHECK(read_as("go to BÜRO 3", places) == "move_to_place(place=Büro 3)");
  CHECK(read_as("go to КУХНЯ", places) == "move_to_place(place=кухня)");
  CHECK(read_as("go to кухмя", places) == "move_to_place(place=кухня)");
  CHECK(read_as("go to lab 2", places) == "move_to_place(place=lab-2)");
  CHECK(read_as("go to the \"Büro 3\"", places) == "move_to_place(place=Büro 3)");
}

TEST_CASE("whatever the text, it is a reading or one error") {
  const std::vector<std::string> strange = {"\x01\x02",
                                            std::string("go\0to", 5),
                                            "厨房に行って",
                                            "\xff\xfe go",
                                            "🤖🤖",
                                            "((((((",
                                            "----",
                                            R"("""")",
                                            "1 2 3 4 5",
                                            "and and and",
                                            "a a a a",
                                            std::string(999, ' '),
                                            std::string(1000, '-')};
  for (const std::string& text : strange) {
    CAPTURE(text);
    CHECK(read_as(text).starts_with("not_understood("));
  }
  for (const std::string part : {"please ", "the ", "go to ", "a half and ", "next to the ", "turn left and "}) {
    std::string text;
    while (text.size() + part.size() <= kLongestCommand) text += part;
    read_as(text);
  }
  CHECK_THROWS_WITH_AS(read_as(std::string(1U << 20U, 'x')), "text: expected at most 1000 characters, got 1048576",
                       ContractError);
  CHECK_NOTHROW(read_as("go to " + std::string(900, 'x')));
  CHECK_THROWS_AS(read_as("go", {""}), ContractError);
  CHECK_THROWS_AS(read_as("go", {"\xff"}), ContractError);
  CHECK_THROWS_AS(read_as("go", {"a\nb"}), ContractError);
  CHECK_THROWS_AS(read_as("go", std::vector<std::string>(kMostPlaces + 1, "x")), ContractError);
}

TEST_CASE("canonical text has four decimals at most") {
  CHECK(to_text(Step{.skill = Skill::rotate, .angle = -0.00001}) == "rotate(angle=0)");
  CHECK(to_text(Step{.skill = Skill::move_to, .x = 1.23456, .y = -100.0}) == "move_to(x=1.2346, y=-100)");
  CHECK(to_text(Reading{.outcome = ReadingOutcome::refused, .rule = RefusalRule::zone}) == "refused(zone)");
}

}  // namespace
}  // namespace threewe::language
