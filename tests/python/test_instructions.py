"""Instructions: what a sentence makes a robot do, and what it says where it cannot."""

import math
from pathlib import Path

import command_line
import pytest
import threewe
from threewe import Pose2D, Robot, Scene, sync
from threewe._core import places_of_scene
from threewe.cli import app
from threewe.errors import ConfigError, ContractError, EmergencyStopError, HardwareError, SafetyError
from typer.testing import CliRunner


def test_a_plant_is_found_in_an_office_that_was_never_seen() -> None:
    with sync.Robot(scene="office_v2", seed=3) as robot:
        result = robot.execute_instruction("find the plant")
        truth = robot.simulation
        assert truth is not None
        at = truth.true_pose()
        plants = [thing.pose for thing in truth.scene.objects if thing.category == "plant"]
        assert result.success, result
        assert result.verified
        assert "plant" in result.answer
        assert min(math.hypot(plant.x - at.x, plant.y - at.y) for plant in plants) < 1.3
        assert [step.skill for step in result.steps] == ["search"]
        assert truth.max_collision_speed() <= 0.05
        assert robot.get_things()


def test_the_same_instruction_drives_the_same_way() -> None:
    def drive() -> tuple[float, float, str]:
        with sync.Robot(scene="office_v2", seed=5) as robot:
            result = robot.execute_instruction("turn left, move forward 50 cm, then look around")
            return result.distance, result.duration, repr([(t.id, t.position, t.kinds) for t in robot.get_things()])

    assert drive() == drive()


def test_places_are_where_they_were_named() -> None:
    with sync.Robot() as robot:
        robot.name_place("dock")
        robot.name_place("square", [(1.5, -0.5), (2.5, -0.5), (2.5, 0.5), (1.5, 0.5)])
        dock, square = robot.get_places()
        assert (dock.name, square.name) == ("dock", "square")
        assert dock.contains((2.4, 0))
        assert not dock.contains((2.6, 0))
        assert square.contains((1.6, 0.4))
        assert not square.contains((1.4, 0.4))
        there = robot.execute_instruction("go to the square")
        assert there.success
        assert math.hypot(robot.get_pose().x - 2.0, robot.get_pose().y) < 0.5
        assert robot.execute_instruction("go to the dock, then wait 2 seconds").success
        assert math.hypot(robot.get_pose().x, robot.get_pose().y) < 0.5
        answer = robot.execute_instruction("where are you?")
        assert "in the dock" in answer.answer


@pytest.mark.parametrize(
    ("text", "reason", "detail"),
    [
        ("drive through the wall", "refused", "obstacle"),
        ("go to the garage", "not_understood", "garage"),
        ("go to the office", "ambiguous", "office 1; or office 2"),
        ("go to the bathroom", "not_found", "bathroom"),
        ("", "not_understood", ""),
    ],
)
def test_what_is_not_done_says_why_and_the_robot_stands(text: str, reason: str, detail: str) -> None:
    with sync.Robot() as robot:
        robot.name_place("office 1", [(1, 1), (2, 1), (2, 2)])
        robot.name_place("office 2", [(3, 1), (4, 1), (4, 2)])
        result = robot.execute_instruction(text)
        assert not result.success
        assert result.reason == reason
        assert detail in result.detail
        assert result.distance == 0.0


def test_a_budget_ends_a_search() -> None:
    with sync.Robot() as robot:
        result = robot.execute_instruction("find the bed", timeout=20.0)
        assert result.reason == "budget"
        assert 20.0 <= result.duration < 21.0
        robot.sleep(0.5)
        assert abs(robot.get_velocity().vx) < 0.05


def test_bad_input_is_one_error() -> None:
    with sync.Robot() as robot:
        with pytest.raises(ContractError, match="instruction"):
            robot.execute_instruction(7)  # type: ignore[arg-type]
        with pytest.raises(ContractError, match="1000"):
            robot.execute_instruction("go " * 500)
        with pytest.raises(ContractError, match="max_steps"):
            robot.execute_instruction("look around", max_steps=0)
        with pytest.raises(ContractError, match="start"):
            robot.name_place("start")
        with pytest.raises(ContractError, match="three points"):
            robot.name_place("line", [(0, 0), (1, 1)])
        robot.emergency_stop()
        with pytest.raises(EmergencyStopError):
            robot.execute_instruction("look around")


@pytest.mark.parametrize(
    ("text", "skill"),
    [
        ("look around", "look"),
        ("turn left, then find the plant", "search"),
        ("is there a plant?", "search"),
        ("list things", "list_things"),
        ("Turn left, take the door on your right and stop at the plant.", "follow"),
    ],
)
def test_what_needs_a_camera_is_an_error_without_one(text: str, skill: str) -> None:
    with sync.Robot(hardware="turtlebot_like") as robot:
        with pytest.raises(HardwareError, match=f"'turtlebot_like' has no camera, which {skill}.* needs"):
            robot.execute_instruction(text)
        assert robot.get_pose().theta == pytest.approx(0.0, abs=0.05)


def test_the_rest_works_without_a_camera(tmp_path: Path) -> None:
    with sync.Robot(hardware="turtlebot_like") as robot:
        robot.name_place("dock")
        assert [place.name for place in robot.get_places()] == ["dock"]
        assert robot.get_things() == []
        assert "rotate" in [skill.name for skill in robot.get_skills()]
        result = robot.execute_instruction("turn left 30 degrees, then move forward 20 cm")
        assert result.success, result
        assert [step.picture.shape for step in result.steps] == [(0, 0, 3)] * 2
        assert result.camera is None
        assert robot.execute_skill("rotate", degrees=30).success
        assert "in the dock" in robot.execute_instruction("where are you?").answer
        route = robot.execute_instruction("Turn left, take the door on your right and stop.")
        assert route.reason == "not_found", route
        result.save(tmp_path / "run.html")
    assert "data:image/jpeg" not in (tmp_path / "run.html").read_text(encoding="utf-8")


def test_a_step_has_its_arguments_by_name() -> None:
    with sync.Robot() as robot:
        result = robot.execute_instruction("turn left 90 degrees, then wait 2 seconds, then stop")
        assert [(step.skill, step.arguments) for step in result.steps] == [
            ("rotate", {"angle": math.pi / 2}),
            ("wait", {"duration": 2.0}),
            ("done", {}),
        ]


async def _one_at_a_time() -> None:
    import asyncio

    async with Robot() as robot:
        first = asyncio.ensure_future(robot.execute_instruction("look around"))
        await robot.sleep(0.5)
        with pytest.raises(SafetyError, match="instruction"):
            await robot.execute_instruction("look around")
        first.cancel()
        with pytest.raises(asyncio.CancelledError):
            await first
        assert (await robot.execute_instruction("turn left")).success


def test_one_instruction_at_a_time_and_a_cancelled_one_ends() -> None:
    import asyncio

    asyncio.run(_one_at_a_time())


def test_a_page_shows_map_way_and_the_picture_of_each_step(tmp_path: Path) -> None:
    with sync.Robot(scene="office_v2", seed=3) as robot:
        robot.name_place("<dock>")
        result = robot.execute_instruction("turn left, then find the plant")
    assert [step.skill for step in result.steps] == ["rotate", "search"]
    assert all(step.picture.shape == (480, 640, 3) for step in result.steps)
    assert not (result.steps[0].picture == result.steps[1].picture).all()
    assert len(result.way) > 10
    result.save(tmp_path / "run.html")
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert page.count("data:image/jpeg;base64,") == 2
    assert page.count("data:image/png;base64,") == 1
    assert result.answer in page
    assert not result.conversation
    assert "Conversation" not in page
    assert "http" not in page.replace("http-equiv", "")


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [("run.pdf", ContractError, "must end in .html"), ("missing/run.html", ConfigError, "cannot be written")],
)
def test_a_page_that_cannot_be_written_is_one_error(
    tmp_path: Path, name: str, error: type[Exception], message: str
) -> None:
    with sync.Robot() as robot:
        result = robot.execute_instruction("drive through the <b>wall</b>")
    with pytest.raises(error, match=message):
        result.save(tmp_path / name)


def test_words_of_a_page_are_no_markup(tmp_path: Path) -> None:
    with sync.Robot() as robot:
        result = robot.execute_instruction("go to the <script>")
    result.save(tmp_path / "run.html")
    assert "<script>" not in (tmp_path / "run.html").read_text(encoding="utf-8")


def test_the_command_refuses_a_page_of_another_kind_before_it_drives() -> None:
    done = command_line.threewe("instruct", "wait 1 s", "--report", "a.txt")
    assert done.returncode != 0
    assert "a.txt must end in .html" in done.stderr
    assert done.stdout == ""


def test_a_route_is_followed_by_its_words_through_rooms_with_names() -> None:
    start = Pose2D(-2.7, 1.0, math.pi / 2)  # in the kitchen of an apartment, before its door
    route = "Go through the door into the hall, turn right, then enter the children's room. Stop just inside."
    with sync.Robot(scene="apartment_v1", seed=2, start_pose=start, initial_pose=start) as robot:
        for place in places_of_scene(Scene.load("apartment_v1")):
            robot.name_place(place.name, place.polygon)
        result = robot.execute_instruction(route)
        assert robot.simulation is not None
        at = robot.simulation.true_pose()
        assert result.success, result
        assert result.answer == "I am in the children's room."
        assert [step.skill for step in result.steps] == ["follow"]
        assert 1.7 < at.x < 4.7
        assert 3.4 < at.y < 5.3


@pytest.mark.parametrize(
    ("route", "reason", "detail"),
    [
        ("Go through the door and enter the kichen.", "not_found", "did you mean 'kitchen'"),
        (
            "Leave the hall through the door into the study. Stop just inside.",
            "not_found",
            "way out of the kitchen",
        ),
        ("Turn left, then stop in the middle of the study.", "not_found", "this is the kitchen, not the study"),
    ],
)
def test_a_route_that_makes_no_sense_here_says_why(route: str, reason: str, detail: str) -> None:
    start = Pose2D(-2.7, 1.0, math.pi / 2)
    with sync.Robot(scene="apartment_v1", start_pose=start, initial_pose=start) as robot:
        for place in places_of_scene(Scene.load("apartment_v1")):
            robot.name_place(place.name, place.polygon)
        result = robot.execute_instruction(route)
        assert (result.success, result.reason) == (False, reason), result
        assert detail in result.detail


def test_a_route_without_places_is_not_found() -> None:
    with sync.Robot() as robot:
        result = robot.execute_instruction("Turn left, take the door on your right and stop at the plant.")
        assert result.reason == "not_found"
        assert "none of the places" in result.detail


def test_places_are_saved_and_loaded_beside_a_map(tmp_path: Path) -> None:
    file = tmp_path / "home.yaml"
    with sync.Robot() as robot:
        robot.name_place("dock")
        robot.name_place("café: 'old'", [(1.5, -0.5), (2.5, -0.5), (2.5, 0.5)])
        robot.save_places(file)
        kept = robot.get_places()
        with pytest.raises(ConfigError, match=r"ends in \.yaml"):
            robot.save_places(tmp_path / "places.txt")
    with sync.Robot() as robot:
        robot.name_place("home")
        loaded = robot.load_places(file)
        assert [(p.name, p.origin) for p in loaded] == [(p.name, "given") for p in kept]
        assert [p.name for p in robot.get_places()] == ["home", "dock", "café: 'old'"]
        assert robot.get_places()[2].polygon == [(1.5, -0.5), (2.5, -0.5), (2.5, 0.5)]
        assert robot.execute_instruction("go to the dock").success

        file.write_text("version: 1\nplaces:\n  - {name: a, point: [0, 0]}\n  - {name: a, point: [1, 0]}\n")
        with pytest.raises(ConfigError, match=r"home.yaml:4: .*'a' is there already"):
            robot.load_places(file)
        assert len(robot.get_places()) == 3


def test_the_rooms_of_a_scene_are_places_of_its_map(tmp_path: Path) -> None:
    files = threewe.export("apartment_v1", "3we_standard_v2", "map", tmp_path, places=True)
    assert files[-1].name == "places.yaml"
    start = Pose2D(-2.7, 1.0, 0.0)
    with sync.Robot(scene="apartment_v1", map=tmp_path / "map.yaml", start_pose=start, initial_pose=start) as robot:
        assert "children's room" in [place.name for place in robot.load_places(files[-1])]
        assert "in the kitchen" in robot.execute_instruction("where are you?").answer
        with pytest.raises(ContractError, match=r"on the map that was given, got the point \(99, 0\)"):
            robot.name_place("far", [(0, 0), (99, 0), (0, 5)])
        files[-1].write_text("version: 1\nplaces: [{name: far, point: [99, 0]}]\n")
        with pytest.raises(ConfigError, match=r"places.yaml:2: .*outside of the map"):
            robot.load_places(files[-1])
    with pytest.raises(ConfigError, match="with the format 'map'"):
        threewe.export("apartment_v1", "3we_standard_v2", "usd", tmp_path, places=True)


def test_the_command_line_takes_a_map_and_its_places(tmp_path: Path) -> None:
    run = CliRunner()
    made = run.invoke(app, ["export", "--scene", "apartment_v1", "--format", "map", "--places", "-o", str(tmp_path)])
    assert made.exit_code == 0, made.output
    given = ["--scene", "apartment_v1", "--map", str(tmp_path / "map.yaml"), "--places", str(tmp_path / "places.yaml")]
    done = run.invoke(app, ["instruct", "go to the kitchen", *given])
    assert done.exit_code == 0, done.output
    assert "move_to_place(place=kitchen): done" in done.output


@pytest.mark.parametrize(("text", "reason"), [("move forward 2 m", "refused"), ("move back 10 cm", "done")])
def test_what_is_driven_straight_on_stays_out_of_zones(text: str, reason: str) -> None:
    with sync.Robot() as robot:
        robot.set_zones([threewe.Zone([(1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)])])
        result = robot.execute_instruction(text)
        assert result.reason == reason, result
        assert ("zone" in result.detail) == (reason == "refused")
