#include "furnishing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "core/exact.hpp"
#include "object_library.hpp"

namespace threewe::scene {
namespace {

constexpr int kDoorSpace = 90;  // [cm] kept free from the middle of a doorway into the room
constexpr int kWallFace = 8;    // [cm] from the middle of a wall to a leaf that hangs on it

// One piece of a group. A group's frame has x pointing away from the wall, or anywhere for groups without one.
struct Part {
  const char* category = nullptr;
  const char* shape = nullptr;
  int x = 0;         // [cm]
  int y = 0;         // [cm]
  int turns = 0;     // quarters
  int careless = 0;  // up to this many hundredths of a radian it may be turned
};

struct GroupPlan {
  std::array<Part, 8> places;  // the first of them, as many as have a category

  std::span<const Part> parts() const { return {places.begin(), std::ranges::find(places, nullptr, &Part::category)}; }
};

// what stands at a wall, at x = 0
constexpr GroupPlan kDesk = {
    {{{"desk", "four_leg", 42}, {"chair", "swivel", 110, -8, 2, 30}, {"monitor", "wide", 24}}}};
constexpr GroupPlan kPanelDesk = {
    {{{"desk", "panel", 42}, {"chair", "sled", 108, 5, 2, 15}, {"monitor", "dual", 26}, {"cup", "mug", 50, 45}}}};
constexpr GroupPlan kSmallDesk = {{{{"desk", "pedestal", 37},
                                    {"chair", "wooden", 96, 10, 2, 20},
                                    {"monitor", "laptop", 34, 5},
                                    {"cup", "paper", 45, 40}}}};
constexpr GroupPlan kBookcase = {{{{"shelf", "bookcase", 18}}}};
constexpr GroupPlan kBookcases = {{{{"shelf", "bookcase", 18, -46}, {"shelf", "bookcase", 18, 46}}}};
constexpr GroupPlan kWideShelf = {{{{"shelf", "wide", 20}}}};
constexpr GroupPlan kLowShelf = {{{{"shelf", "low", 22}}}};
constexpr GroupPlan kRack = {{{{"shelf", "metal", 28}}}};
constexpr GroupPlan kRacks = {{{{"shelf", "metal", 28, -65}, {"shelf", "metal", 28, 65}}}};
constexpr GroupPlan kTower = {{{{"shelf", "tower", 22}}}};
constexpr GroupPlan kFiling = {{{{"cabinet", "filing", 32}}}};
constexpr GroupPlan kSideboard = {{{{"cabinet", "sideboard", 25}, {"monitor", "wide", 25}}}};
constexpr GroupPlan kWardrobe = {{{{"cabinet", "wardrobe", 32}}}};
constexpr GroupPlan kLockers = {{{{"cabinet", "lockers", 25}}}};
constexpr GroupPlan kCouch = {{{{"couch", "three_seat", 48}, {"table", "coffee", 146}}}};
constexpr GroupPlan kSmallCouch = {{{{"couch", "two_seat", 45}, {"table", "coffee", 142}}}};
constexpr GroupPlan kBench = {{{{"couch", "bench", 26}}}};
constexpr GroupPlan kArmchair = {{{{"chair", "tub", 40, 0, 0, 20}}}};
constexpr GroupPlan kSingleBed = {{{{"bed", "single", 103}}}};
constexpr GroupPlan kDoubleBed = {{{{"bed", "double", 108}}}};
constexpr GroupPlan kDaybed = {{{{"bed", "daybed", 48, 0, 1}}}};
constexpr GroupPlan kBunk = {{{{"bed", "bunk", 50, 0, 1}}}};
constexpr GroupPlan kCounter = {{{{"counter", "sink", 32}, {"cup", "kitchen_mug", 30, -40}}}};
constexpr GroupPlan kLongCounter = {{{{"counter", "long", 32}, {"cup", "kitchen_mug", 34, 30}}}};
constexpr GroupPlan kRefrigerator = {{{{"refrigerator", "tall", 36}}}};
constexpr GroupPlan kRetro = {{{{"refrigerator", "retro", 34}}}};
constexpr GroupPlan kDoubleRefrigerator = {{{{"refrigerator", "double", 39}}}};
constexpr GroupPlan kSmallRefrigerator = {{{{"refrigerator", "small", 31}}}};
constexpr GroupPlan kFern = {{{{"plant", "fern", 36}}}};
constexpr GroupPlan kFicus = {{{{"plant", "ficus", 44}}}};
constexpr GroupPlan kYucca = {{{{"plant", "yucca", 30}}}};
constexpr GroupPlan kPlanter = {{{{"plant", "planter", 28}}}};
constexpr GroupPlan kCarton = {{{{"box", "carton", 26, 0, 1, 8}}}};
constexpr GroupPlan kStack = {{{{"box", "stack", 28, 0, 1, 8}}}};
constexpr GroupPlan kTrunk = {{{{"box", "trunk", 26, 0, 1}}}};
constexpr GroupPlan kPallet = {{{{"box", "pallet", 46, 0, 1}}}};

// what stands in the middle, at (0, 0)
constexpr GroupPlan kDining = {{{{"table", "dining"},
                                 {"chair", "wooden", 62, 38, 2, 15},
                                 {"chair", "wooden", 62, -38, 2, 15},
                                 {"chair", "wooden", -62, 38, 0, 15},
                                 {"chair", "wooden", -62, -38, 0, 15},
                                 {"cup", "tumbler", 20, 30},
                                 {"cup", "mug", -22, -30}}}};
constexpr GroupPlan kRoundTable = {{{{"table", "round"},
                                     {"chair", "wooden", 70, 0, 2, 20},
                                     {"chair", "wooden", -70, 0, 0, 20},
                                     {"chair", "wooden", 0, 70, 3, 20},
                                     {"cup", "espresso", 20, 10}}}};
constexpr GroupPlan kMeeting = {{{{"table", "meeting"},
                                  {"chair", "steel", 86, 100, 2, 12},
                                  {"chair", "steel", 86, 0, 2, 12},
                                  {"chair", "steel", 86, -100, 2, 12},
                                  {"chair", "steel", -86, 100, 0, 12},
                                  {"chair", "steel", -86, 0, 0, 12},
                                  {"chair", "steel", -86, -100, 0, 12},
                                  {"cup", "paper", 30, 40}}}};
constexpr GroupPlan kSquareTable = {
    {{{"table", "square"}, {"chair", "sled", 62, 0, 2, 20}, {"chair", "sled", -62, 0, 0, 20}}}};
constexpr GroupPlan kDeskIsland = {{{{"desk", "four_leg", 41},
                                     {"desk", "four_leg", -41, 0, 2},
                                     {"chair", "swivel", 112, 5, 2, 30},
                                     {"chair", "swivel", -112, -10, 0, 30},
                                     {"monitor", "small", 24},
                                     {"monitor", "wide", -24, 0, 2},
                                     {"cup", "mug", 50, 50}}}};
constexpr GroupPlan kIsland = {{{{"counter", "island"}}}};
constexpr GroupPlan kLonePallet = {{{{"box", "pallet"}}}};
constexpr GroupPlan kLoneStack = {{{{"box", "stack", 0, 0, 0, 80}}}};
constexpr GroupPlan kLoneCrate = {{{{"box", "crate", 0, 0, 0, 80}}}};
constexpr GroupPlan kLonePlant = {{{{"plant", "ficus"}}}};
constexpr GroupPlan kLoneChair = {{{{"chair", "tub", 0, 0, 0, 80}}}};
constexpr GroupPlan kLeaf = {{{{"door", "narrow"}}}};
constexpr GroupPlan kColumn = {{{{"column", "square"}}}};

// What a kind of room holds: first what it cannot be without, then what may be added.
struct Kind {
  const char* name;
  const char* floor;
  int smallest;   // [cm], of its shorter side
  double likely;  // that there is something in the middle, beside what difficulty adds
  std::vector<const GroupPlan*> first;
  std::vector<const GroupPlan*> more;
  std::vector<const GroupPlan*> middle;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> kKinds = {
      {"office",
       "carpet",
       260,
       0.4,
       {&kDesk, &kBookcase},
       {&kPanelDesk, &kSmallDesk, &kFiling, &kWideShelf, &kYucca, &kFicus},
       {&kDeskIsland, &kRoundTable}},
      {"study",
       "wood",
       260,
       0.4,
       {&kSmallDesk, &kBookcases},
       {&kArmchair, &kDaybed, &kFern, &kLowShelf, &kTower},
       {&kSquareTable}},
      {"bedroom",
       "carpet",
       280,
       0.0,
       {&kDoubleBed, &kWardrobe},
       {&kArmchair, &kFiling, &kSmallDesk, &kFern, &kWardrobe},
       {}},
      {"children",
       "wood",
       260,
       0.4,
       {&kBunk, &kSmallDesk},
       {&kTrunk, &kLowShelf, &kSingleBed, &kTower, &kCarton},
       {&kSquareTable}},
      {"kitchen",
       "tile",
       260,
       0.7,
       {&kCounter, &kRefrigerator},
       {&kLongCounter, &kRetro, &kTower, &kSmallRefrigerator, &kFern},
       {&kRoundTable, &kDining, &kIsland}},
      {"living_room",
       "wood",
       320,
       0.4,
       {&kCouch, &kSideboard},
       {&kArmchair, &kBookcase, &kFicus, &kLowShelf, &kPlanter, &kSmallCouch},
       {&kDining, &kRoundTable}},
      {"meeting_room", "carpet", 400, 1.0, {&kLowShelf}, {&kSideboard, &kFern, &kYucca, &kBench}, {&kMeeting}},
      {"storage",
       "concrete",
       260,
       0.4,
       {&kRacks, &kStack},
       {&kRack, &kPallet, &kCarton, &kLockers, &kDoubleRefrigerator, &kTrunk},
       {&kLonePallet}},
      {"lounge",
       "vinyl",
       280,
       0.4,
       {&kSmallCouch, &kPlanter},
       {&kBench, &kArmchair, &kSmallRefrigerator, &kFicus, &kBookcase},
       {&kRoundTable, &kColumn}},
  };
  return kKinds;
}

const Kind& corridor() {
  static const Kind kCorridor = {"corridor", "vinyl", 0, 0.0, {}, {&kBench, &kLockers, &kFern, &kYucca, &kLowShelf},
                                 {}};
  return kCorridor;
}

constexpr std::array<const GroupPlan*, 5> kClutter = {&kLoneStack, &kLoneCrate, &kLonePlant, &kLoneChair,
                                                      &kSquareTable};

// The library, read once in the life of the process: generated scenes use what is installed.
const std::vector<Prism>& prisms_of(const Part& part) {
  static const auto kLibrary = [] {
    ObjectLibrary library;
    std::map<std::pair<std::string, std::string>, std::vector<Prism>> all;
    const auto add = [&](std::span<const GroupPlan* const> groups) {
      for (const GroupPlan* group : groups) {
        for (const Part& p : group->parts())
          all.try_emplace({p.category, p.shape}, library.prisms(p.category, p.shape));
      }
    };
    for (const Kind& kind : kinds()) {
      add(kind.first);
      add(kind.more);
      add(kind.middle);
    }
    add(corridor().more);
    add(kClutter);
    add(std::array{&kLeaf});
    return all;
  }();
  return kLibrary.at({part.category, part.shape});
}

double in_metres(int cm) { return cm / 100.0; }

// (x, y) turned by quarters
std::pair<int, int> turned(int x, int y, int turns) {
  for (int i = 0; i < (turns & 3); ++i) std::tie(x, y) = std::pair(-y, x);
  return {x, y};
}

double heading(int turns, int hundredths) {
  constexpr std::array kHeadings = {0.0, exact::kHalfPi, exact::kPi, -exact::kHalfPi};
  const double theta = kHeadings[static_cast<std::size_t>(turns & 3)];
  return hundredths == 0 ? theta : wrap_angle(theta + hundredths / 100.0);
}

class Furnisher {
 public:
  Furnisher(const EmptyRoom& room, double difficulty, RandomStream& random)
      : room_(room), difficulty_(difficulty), random_(random), apron_(70 - static_cast<int>(20.0 * difficulty)) {}

  RoomUse furnish() {
    const Kind& kind = choose_kind();
    hang_doors();
    if (kind.likely == 1.0) put_in_the_middle(*random_.pick(kind.middle), 40);
    for (const GroupPlan* group : kind.first) put_at_wall(*group);
    if (kind.likely < 1.0 && !kind.middle.empty() && random_.chance(kind.likely + 0.5 * difficulty_)) {
      put_in_the_middle(*random_.pick(kind.middle), 12);
    }
    const double square_metres = in_metres(room_.inside.width()) * in_metres(room_.inside.depth());
    const int more = static_cast<int>(square_metres * (0.06 + 0.2 * difficulty_));
    for (int i = 0; i < more && !kind.more.empty(); ++i) put_at_wall(*random_.pick(kind.more));
    const int clutter = room_.corridor ? 0 : static_cast<int>(square_metres * 0.12 * difficulty_);
    for (int i = 0; i < clutter; ++i) put_in_the_middle(*random_.pick(kClutter), 4);
    return {kind.name, kind.floor, std::move(groups_)};
  }

 private:
  const Kind& choose_kind() {
    if (room_.corridor) return corridor();
    const int shorter = std::min(room_.inside.width(), room_.inside.depth());
    for (;;) {
      const Kind& kind = random_.pick(kinds());
      if (kind.smallest <= shorter + 20) return kind;
    }
  }

  // Leaves stand open beside their doorways, at a right angle to the wall, where nothing is in their way.
  void hang_doors() {
    for (const EmptyRoom::Doorway& doorway : room_.doorways) ways_.push_back(way(doorway, doorway.width / 2 + 10));
    for (std::size_t i = 0; i < room_.doorways.size(); ++i) {
      const EmptyRoom::Doorway& doorway = room_.doorways[i];
      if (!doorway.leaf) continue;
      const auto [dx, dy] = turned(kWallFace, doorway.width / 2 + 4, doorway.turns);
      Group group = put(kLeaf, doorway.x + dx, doorway.y + dy, doorway.turns);
      const Box box = group.box;
      const Box wide = std::exchange(ways_[i], way(doorway, doorway.width / 2));
      accept(std::move(group), box);
      ways_[i] = wide;
    }
  }

  // What is kept free in front of a doorway.
  static Box way(const EmptyRoom::Doorway& doorway, int half_width) {
    const auto [ax, ay] = turned(0, -half_width, doorway.turns);
    const auto [bx, by] = turned(kDoorSpace, half_width, doorway.turns);
    return {doorway.x + std::min(ax, bx), doorway.y + std::min(ay, by), doorway.x + std::max(ax, bx),
            doorway.y + std::max(ay, by)};
  }

  // Tries places along the walls; the group's x axis points into the room.
  void put_at_wall(const GroupPlan& plan) {
    constexpr int kTries = 12;
    const Box& in = room_.inside;
    for (int i = 0; i < kTries; ++i) {
      const int turns = random_.between(0, 3);
      // on the west wall, the south, the east and the north
      const bool vertical = turns % 2 == 0;
      const int along =
          vertical ? 5 * random_.between(in.y0 / 5, in.y1 / 5) : 5 * random_.between(in.x0 / 5, in.x1 / 5);
      const int x = vertical ? (turns == 0 ? in.x0 : in.x1) : along;
      const int y = vertical ? along : (turns == 1 ? in.y0 : in.y1);
      Group group = put(plan, x, y, turns);
      Box front = group.box;
      switch (turns) {
        case 0: front.x1 += apron_; break;
        case 1: front.y1 += apron_; break;
        case 2: front.x0 -= apron_; break;
        default: front.y0 -= apron_;
      }
      if (accept(std::move(group), front)) return;
    }
  }

  // Tries places with space all around.
  void put_in_the_middle(const GroupPlan& plan, int tries) {
    const Box& in = room_.inside;
    for (int i = 0; i < tries; ++i) {
      const int x = 5 * random_.between(in.x0 / 5, in.x1 / 5);
      const int y = 5 * random_.between(in.y0 / 5, in.y1 / 5);
      Group group = put(plan, x, y, random_.between(0, 3));
      const Box& b = group.box;
      const Box around{b.x0 - apron_, b.y0 - apron_, b.x1 + apron_, b.y1 + apron_};
      if (accept(std::move(group), around)) return;
    }
  }

  // A group at a place, and the box around it.
  Group put(const GroupPlan& plan, int x, int y, int turns) {
    Group group;
    group.box = {x, y, x, y};
    for (const Part& part : plan.parts()) {
      const auto [dx, dy] = turned(part.x, part.y, turns);
      const int careless = part.careless == 0 ? 0 : random_.between(-part.careless, part.careless);
      Object object{.name = {}, .category = part.category, .shape = part.shape, .pose = {}, .prisms = prisms_of(part)};
      object.pose = {in_metres(x + dx), in_metres(y + dy), heading(turns + part.turns, careless)};
      for (const Prism& prism : object.prisms) {
        const auto [low, high] = bounds(solid_of(prism, object.pose, 0));
        Box& b = group.box;
        b = {std::min(b.x0, static_cast<int>(std::floor(100.0 * low.x))),
             std::min(b.y0, static_cast<int>(std::floor(100.0 * low.y))),
             std::max(b.x1, static_cast<int>(std::ceil(100.0 * high.x))),
             std::max(b.y1, static_cast<int>(std::ceil(100.0 * high.y)))};
      }
      group.objects.push_back(std::move(object));
    }
    return group;
  }

  // Keeps a group if it and the space that it needs (`with_space`) are free.
  bool accept(Group group, const Box& with_space) {
    const auto hits = [](const std::vector<Box>& boxes, const Box& b) {
      return std::ranges::any_of(boxes, [&](const Box& other) { return other.overlaps(b); });
    };
    // rounding outwards costs a centimetre, and so may a wall
    const Box slim{group.box.x0 + 1, group.box.y0 + 1, group.box.x1 - 1, group.box.y1 - 1};
    if (!room_.inside.contains(slim) || hits(ways_, group.box) || room_.keep_free.overlaps(group.box)) return false;
    if (hits(spaces_, group.box) || hits(boxes_, with_space)) return false;
    boxes_.push_back(group.box);
    spaces_.push_back(with_space);
    groups_.push_back(std::move(group));
    return true;
  }

  const EmptyRoom& room_;
  double difficulty_;
  RandomStream& random_;
  int apron_;  // [cm] in front of what stands at a wall
  std::vector<Box> ways_;
  std::vector<Box> boxes_;
  std::vector<Box> spaces_;
  std::vector<Group> groups_;
};

}  // namespace

RoomUse furnish(const EmptyRoom& room, double difficulty, RandomStream& random) {
  return Furnisher(room, difficulty, random).furnish();
}

}  // namespace threewe::scene
