"""ROS 2 messages: type hashes and bytes on the wire, against the independent ones of rosbags."""

import random
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore
from threewe import ContractError, _core

STORES = {"humble": Stores.ROS2_HUMBLE, "jazzy": Stores.ROS2_JAZZY, "kilted": Stores.ROS2_KILTED}
TYPES = _core.ros2_message_types()
# rosbags hashes the `char` of a .msg file as another type than ROS does: its Gid, and what contains one.
HASHED_OTHERWISE = [name for name in TYPES if name.startswith("rmw_dds_common/")]
# What others have published of those.
PARTICIPANT = "RIHS01_91a0593bacdcc50ea9bdcf849a938b128412cc1ea821245c663bcd26f83c295e"

# What rosbags has not: the messages of services and actions, as ROS 2 makes them of .srv and .action files.
NAV2 = "nav2_msgs/action"
UUID = "unique_identifier_msgs/UUID goal_id"
ACTIONS = {
    "action_msgs/srv/CancelGoal_Request": "action_msgs/GoalInfo goal_info",
    "action_msgs/srv/CancelGoal_Response": "int8 return_code\naction_msgs/GoalInfo[] goals_canceling",
    f"{NAV2}/NavigateToPose_Goal": "geometry_msgs/PoseStamped pose\nstring behavior_tree",
    f"{NAV2}/NavigateToPose_Result": "uint16 error_code\nstring error_msg",
    f"{NAV2}/NavigateToPose_Feedback": "geometry_msgs/PoseStamped current_pose\n"
    "builtin_interfaces/Duration navigation_time\nbuiltin_interfaces/Duration estimated_time_remaining\n"
    "int16 number_of_recoveries\nfloat32 distance_remaining",
    f"{NAV2}/FollowPath_Goal": "nav_msgs/Path path\nstring controller_id\nstring goal_checker_id\n"
    "string progress_checker_id",
    f"{NAV2}/FollowPath_Result": "std_msgs/Empty result\nuint16 error_code\nstring error_msg",
    f"{NAV2}/FollowPath_Feedback": "float32 distance_to_goal\nfloat32 speed",
    "nav2_msgs/msg/MissedWaypoint": "uint32 index\ngeometry_msgs/PoseStamped goal\nuint16 error_code",
    f"{NAV2}/FollowWaypoints_Goal": "uint32 number_of_loops\nuint32 goal_index\ngeometry_msgs/PoseStamped[] poses",
    f"{NAV2}/FollowWaypoints_Result": "nav2_msgs/MissedWaypoint[] missed_waypoints\n"
    "uint16 error_code\nstring error_msg",
    f"{NAV2}/FollowWaypoints_Feedback": "uint32 current_waypoint",
    **{
        f"{NAV2}/{action}_{name}": fields.replace("ACTION", f"{NAV2}/{action}")
        for action in ("NavigateToPose", "FollowPath", "FollowWaypoints")
        for name, fields in {
            "SendGoal_Request": f"{UUID}\nACTION_Goal goal",
            "SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp",
            "GetResult_Request": UUID,
            "GetResult_Response": "int8 status\nACTION_Result result",
            "FeedbackMessage": f"{UUID}\nACTION_Feedback feedback",
        }.items()
    },
}
ACTIONS_OF_HUMBLE = {
    f"{NAV2}/NavigateToPose_Result": "std_msgs/Empty result",
    f"{NAV2}/FollowPath_Goal": "nav_msgs/Path path\nstring controller_id\nstring goal_checker_id",
    f"{NAV2}/FollowPath_Result": "std_msgs/Empty result",
    f"{NAV2}/FollowWaypoints_Goal": "geometry_msgs/PoseStamped[] poses",
    f"{NAV2}/FollowWaypoints_Result": "int32[] missed_waypoints",
}
ACTIONS_OF_KILTED = {
    "nav2_msgs/msg/WaypointStatus": "uint8 waypoint_status\nuint32 waypoint_index\n"
    "geometry_msgs/PoseStamped waypoint_pose\nuint16 error_code\nstring error_msg",
    f"{NAV2}/FollowWaypoints_Result": "nav2_msgs/WaypointStatus[] missed_waypoints\n"
    "uint16 error_code\nstring error_msg",
}


@pytest.fixture(scope="module", params=STORES)
def store(request: pytest.FixtureRequest) -> tuple[str, Typestore]:
    store = get_typestore(STORES[request.param])
    actions = ACTIONS | {"humble": ACTIONS_OF_HUMBLE, "kilted": ACTIONS_OF_KILTED}.get(request.param, {})
    for name, fields in actions.items():
        (definition,) = get_types_from_msg(fields, name).values()  # which takes a service's for a message
        store.register({name: definition})
    return request.param, store


def test_hashes_are_those_of_rosbags(store: tuple[str, Typestore]) -> None:
    distribution, types = store
    compared = [name for name in TYPES if name in types.types and name not in HASHED_OTHERWISE]
    wrong = [n for n in compared if _core.ros2_type_hash(n, distribution) != types.hash_rihs01(n)]
    assert not wrong
    assert len(compared) == len(TYPES) - len(HASHED_OTHERWISE)


def test_the_hash_of_who_is_in_the_graph_is_the_published_one() -> None:
    name = "rmw_dds_common/msg/ParticipantEntitiesInfo"
    assert _core.ros2_type_hash(name, "jazzy") == _core.ros2_type_hash(name, "kilted") == PARTICIPANT
    assert _core.ros2_type_hash(name, "humble") != PARTICIPANT


@pytest.mark.parametrize("name", [name for name in TYPES if name not in HASHED_OTHERWISE])
def test_messages_are_the_same_bytes(name: str, store: tuple[str, Typestore]) -> None:
    distribution, types = store
    for seed in range(20):
        message = random_message(types, name, random.Random(seed))
        little = bytes(types.serialize_cdr(message, name, little_endian=True))
        big = bytes(types.serialize_cdr(message, name, little_endian=False))
        assert _core.ros2_recode(name, distribution, little) == little, f"seed {seed}"
        assert _core.ros2_recode(name, distribution, big) == little, f"seed {seed}"


@pytest.mark.parametrize("name", TYPES)
def test_what_is_cut_off_is_refused(name: str, store: tuple[str, Typestore]) -> None:
    distribution, types = store
    whole = bytes(types.serialize_cdr(random_message(types, name, random.Random(1)), name))
    for size in range(len(whole)):
        with pytest.raises(ContractError):
            _core.ros2_recode(name, distribution, whole[:size])


def test_a_length_beyond_the_end_allocates_nothing() -> None:
    with pytest.raises(ContractError, match=r"data has 4294967295 elements"):
        _core.ros2_recode("std_msgs/msg/String", "jazzy", b"\0\1\0\0" + b"\xff" * 8)


def test_what_is_left_over_is_refused() -> None:
    _core.ros2_recode("std_msgs/msg/Bool", "jazzy", b"\0\1\0\0\1\0\0\0")  # padded, as some do
    with pytest.raises(ContractError, match="4 bytes are left over"):
        _core.ros2_recode("std_msgs/msg/Bool", "jazzy", b"\0\1\0\0\1\0\0\0\0")


def test_other_encodings_are_refused() -> None:
    with pytest.raises(ContractError, match="plain CDR"):
        _core.ros2_recode("std_msgs/msg/Bool", "jazzy", b"\0\7\0\0\1\0\0\0")


def random_message(types: Typestore, name: str, draw: random.Random) -> Any:
    """A message whose members all have values that differ, and sequences of any length."""
    fields = types.get_msgdef(name).fields
    return types.types[name](**{field: random_value(types, kind, draw) for field, kind in fields})


def random_value(types: Typestore, kind: Any, draw: random.Random) -> Any:
    node, details = kind
    if node.name == "BASE":
        base, limit = details
        if base == "string":
            return "".join(draw.choice("abc_/") for _ in range(draw.randrange(min(limit or 9, 9))))
        return base == "bool" and draw.random() < 0.5 if base == "bool" else number(base, draw)
    if node.name == "NAME":
        return random_message(types, details, draw)
    element, size = details
    count = size if node.name == "ARRAY" else draw.randrange(4)
    values = [random_value(types, element, draw) for _ in range(count)]
    plain = element[0].name == "BASE" and element[1][0] not in ("string", "bool")
    return np.array(values, dtype=dtype(element[1][0])) if plain else values


def dtype(base: str) -> str:
    return {"octet": "int8", "byte": "int8", "char": "uint8"}.get(base, base)


def number(base: str, draw: random.Random) -> Any:
    kind = np.dtype(dtype(base))
    if kind.kind == "f":
        return kind.type(draw.uniform(-1e6, 1e6)).item()
    limits = np.iinfo(kind)
    return draw.randint(int(limits.min), int(limits.max))
