"""Forged bundles: a genuine one, changed in one of many ways, each of which is false or no bundle at all."""

import copy
import io
import json
import random
import struct
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from threewe.benchmark.agents import has_source
from threewe.benchmark.bundle import EARLIEST, KINDS, LARGEST, pack, read_bundle, text_of

Results = dict[str, Any]
Files = dict[str, bytes]


class Forger:
    """Changes one genuine bundle, by a seed."""

    def __init__(self, genuine: Path, seed: int) -> None:
        bundle = read_bundle(genuine)
        self.draw = random.Random(seed)
        self.results: Results = copy.deepcopy(bundle.results)
        self.files: Files = dict(bundle.files)

    def forged(self) -> tuple[str, bytes]:
        """The name of the way in which it is forged, and the bundle."""
        change = self.draw.choice(WAYS)
        content = change(self)
        return change.__name__, content if content is not None else self.packed()

    def packed(self) -> bytes:
        return pack({**self.files, "results.json": text_of(self.results)})

    def row(self) -> dict[str, Any]:
        return self.draw.choice(self.results["episode_results"])

    def commands(self) -> tuple[str, np.ndarray]:
        names = sorted(name for name in self.files if name.startswith("commands/"))
        name = self.draw.choice(names)
        return name, np.frombuffer(self.files[name], "<f8").reshape(-1, 3).copy()

    def tick(self, commands: np.ndarray) -> int:
        """One whose command moves the robot."""
        moving = np.flatnonzero(np.abs(commands).max(axis=1) > 0.1)
        return int(self.draw.choice(moving[: len(moving) // 2 + 1]))

    def archive(self, names: dict[str, bytes], *, compression: int = zipfile.ZIP_STORED, date: Any = EARLIEST) -> bytes:
        """A zip of any files, in their order."""
        written = io.BytesIO()
        with zipfile.ZipFile(written, "w") as archive:
            for name, content in names.items():
                info = zipfile.ZipInfo(name, date)
                info.create_system, info.external_attr = 3, 0o644 << 16
                archive.writestr(info, content, compression)
        return written.getvalue()

    def unpacked(self) -> dict[str, bytes]:
        """All files of the genuine bundle, in order."""
        with zipfile.ZipFile(io.BytesIO(self.packed())) as archive:
            return {name: archive.read(name) for name in archive.namelist()}


def other_metric(forger: Forger) -> None:
    metrics = forger.row()["metrics"]
    name = forger.draw.choice(sorted(metrics))
    metrics[name] = metrics[name] + 1e-9 if isinstance(metrics[name], float | int) else metrics[name][1:]


def success_for_failure(forger: Forger) -> None:
    metrics = forger.row()["metrics"]
    name = "success" if "success" in metrics else "coverage"
    metrics[name] = 1.0 - metrics[name]


def other_trajectory(forger: Forger) -> None:
    trajectory = forger.row()["trajectory"]
    pose = forger.draw.choice(trajectory)
    pose[forger.draw.randrange(3)] += forger.draw.choice([-0.001, 0.001])


def shorter_trajectory(forger: Forger) -> None:
    forger.row()["trajectory"].pop()


def other_episode_seed(forger: Forger) -> None:
    forger.row()["episode"]["seed"] += 1


def other_index(forger: Forger) -> None:
    forger.row()["episode"]["index"] += forger.draw.choice([-1, 1])


def other_scene(forger: Forger) -> None:
    others = {"office_v2", "apartment_v1", "no_such_scene"} - set(forger.results["scenes"])
    forger.results["scenes"] = [forger.draw.choice(sorted(others))]


def other_settings(forger: Forger) -> None:
    name, value = forger.draw.choice(
        [("randomization", "mild"), ("noise", "ideal"), ("hardware", "turtlebot_like"), ("backend", "my_backend")]
    )
    forger.results["settings"][name] = value


def unknown_setting(forger: Forger) -> None:
    forger.results["settings"]["gate"] = "limits"


def truncated_log(forger: Forger) -> None:
    name, commands = forger.commands()
    forger.files[name] = commands[: -forger.draw.randint(1, 200)].tobytes()


def truncated_log_and_claim(forger: Forger) -> None:
    number = forger.draw.randrange(len(forger.results["episode_results"]))
    name = f"commands/{number:05}.f64"
    row = forger.results["episode_results"][number]
    row["ticks"] -= min(forger.draw.randint(20, 200), row["ticks"] - 1)
    forger.files[name] = forger.files[name][: 24 * row["ticks"]]


def longer_log(forger: Forger) -> None:
    number = forger.draw.randrange(len(forger.results["episode_results"]))
    forger.results["episode_results"][number]["ticks"] += 10
    forger.files[f"commands/{number:05}.f64"] += bytes(240)


def torn_log(forger: Forger) -> None:
    name, _ = forger.commands()
    forger.files[name] = forger.files[name][:-1]


def no_log(forger: Forger) -> None:
    name, _ = forger.commands()
    del forger.files[name]


def swapped_rows(forger: Forger) -> None:
    forger.results["episode_results"].reverse()


def swapped_logs(forger: Forger) -> None:
    one, other = "commands/00000.f64", "commands/00001.f64"
    forger.files[one], forger.files[other] = forger.files[other], forger.files[one]


def fewer_episodes(forger: Forger) -> None:
    forger.results["episode_results"].pop()


def more_episodes(forger: Forger) -> None:
    forger.results["episodes"] += 1


def no_count(forger: Forger) -> None:
    forger.results["episodes"] = forger.draw.choice([0, -1, True, "2", 2.0, None])


def too_fast(forger: Forger) -> None:
    name, commands = forger.commands()
    commands[forger.tick(commands) :, 0] *= 1.3
    commands[forger.tick(commands), 0] = 0.6
    forger.files[name] = commands.tobytes()


def too_abrupt(forger: Forger) -> None:
    name, commands = forger.commands()
    tick = forger.tick(commands)
    commands[tick] = -commands[tick - 1] if commands[tick - 1].any() else [0.0, 0.0, 0.9]
    commands[tick + 1] = commands[tick] + [0.3, 0.0, -0.9]
    forger.files[name] = commands.tobytes()


def not_finite(forger: Forger) -> None:
    name, commands = forger.commands()
    commands[forger.tick(commands), forger.draw.randrange(3)] = forger.draw.choice([np.nan, np.inf])
    forger.files[name] = commands.tobytes()


def other_commands(forger: Forger) -> None:
    name, commands = forger.commands()
    tick = forger.tick(commands)
    commands[tick : tick + 25] *= 0.9  # for half a second: more than a trajectory's rounding
    forger.files[name] = commands.tobytes()


def other_end(forger: Forger) -> None:
    row = forger.row()
    row["end"] = forger.draw.choice([end for end in ("stop", "time", "failure", "never") if end != row["end"]])


def other_summary(forger: Forger) -> None:
    figures = forger.results["summary"]["all"]
    figure = figures[forger.draw.choice(sorted(figures))]
    figure[forger.draw.choice(["value", "low", "high"])] += 0.01


def other_set(forger: Forger) -> None:
    name = forger.draw.choice(["reactive_v1", "pointnav_test_v1", "../pointnav_val_v1", "/etc/passwd", "none"])
    forger.results["episode_set"] = name


def other_hash(forger: Forger) -> None:
    forger.results["episode_hash"] = "0" * 64


def closed_track(forger: Forger) -> None:
    forger.results[forger.draw.choice(["track", "repeats", "official"])] = "closed"


def other_agent(forger: Forger) -> None:
    name, value = forger.draw.choice([("kind", "yardstick"), ("name", "x" * 1000), ("name", 7), ("source", None)])
    forger.results["agent"][name] = value


def other_format(forger: Forger) -> None:
    forger.results["format"] = forger.draw.choice(["threewe-benchmark/2", None, 1])


def other_type(forger: Forger) -> None:
    """Equal to what it was, but not the same."""
    first = forger.results["episode_results"][0]
    place, name, value = forger.draw.choice(
        [
            (forger.results, "official", int(forger.results["official"])),
            (first["metrics"], "contacts", int(first["metrics"]["contacts"])),
            (forger.results["settings"], "seed", float(forger.results["settings"]["seed"])),
            (first, "ticks", float(first["ticks"])),
        ]
    )
    place[name] = value


def extra_claim(forger: Forger) -> None:
    forger.results["rank"] = 1


def missing_claim(forger: Forger) -> None:
    del forger.results[forger.draw.choice(sorted(set(forger.results) - {"library"}))]


def other_leaf(forger: Forger) -> None:
    """Anything that can be checked is something else."""
    theirs = has_source(forger.results["agent"]["name"])
    leaves = [leaf for leaf in leaves_of(forger.results) if not is_a_word(leaf, theirs)]
    *path, last = forger.draw.choice(leaves)
    place = forger.results
    for step in path:
        place = place[step]
    strange = [None, True, -1, 1e308, "text", [], {}, [[]], [None]]
    place[last] = forger.draw.choice([value for value in strange if value != place[last]])


def leaves_of(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The ways to all that is no list and no object."""
    if isinstance(value, dict | list):
        for step in value if isinstance(value, dict) else range(len(value)):
            yield from leaves_of(value[step], (*path, step))
    else:
        yield path


def is_a_word(path: tuple[Any, ...], theirs: bool) -> bool:
    """What no replay can tell: where it was, what it failed of, and who it was unless that came with 3we."""
    given = path[0] == "library" or path[-1] in ("failure", "control_rate") or path == ("settings", "seed")
    return given or (theirs and path[0] == "agent")


def unmarked_privilege(forger: Forger) -> None:
    """As if an agent that comes with 3we knew less, or more, than it does; all that follows from it is right."""
    agent = forger.results["agent"]
    agent["privileged"] = not agent["privileged"]
    forger.results["official"] = not agent["privileged"]
    forger.results["localization"] = "as the privileged agent chose" if agent["privileged"] else "the robot's own"


def other_source(forger: Forger) -> None:
    forger.results["agent"]["source"] = forger.draw.choice(["0" * 64, "none"])


def agent_of_no_kind(forger: Forger) -> None:
    forger.results["agent"]["name"] = forger.draw.choice(["", "navigater", "vlm@nowhere:x y", "my.module:Agent"])


def no_library(forger: Forger) -> None:
    forger.results["library"] = forger.draw.choice([None, {"version": 1}, "none"])


def talk_of_no_model(forger: Forger) -> bytes:
    forger.files["talk/00000.jsonl"] = forger.draw.choice([b"", b"{}\n", b'{"format": "threewe-talk/1"}\n'])
    return forger.packed()


def other_actions(forger: Forger) -> None:
    """Not those of an agent that acts, or of one that is none."""
    number = forger.draw.randrange(len(forger.results["episode_results"]))
    name = f"actions/{number:05}.f32"
    if name not in forger.files:
        forger.files[name] = forger.draw.choice([b"", bytes(12), bytes(12 * 50)])
        return
    actions = np.frombuffer(forger.files[name], "<f4").reshape(-1, 3).copy()
    stopped, strange = actions.copy(), actions.copy()
    stopped[10:16] = 0.0
    strange[forger.draw.randrange(len(actions)), 1] = forger.draw.choice([np.nan, -np.inf])
    forged = [actions[:10], np.vstack([actions, actions]), stopped, strange, None]
    chosen = forger.draw.choice(forged)
    if chosen is None:
        del forger.files[name]
    else:
        forger.files[name] = chosen.tobytes()


def extra_log(forger: Forger) -> None:
    forger.files["commands/00099.f64"] = bytes(24)


def other_library(forger: Forger) -> None:
    junk = forger.draw.choice([{"junk": "x"}, {"version": "x" * 100_000}, {"machine": ["one"]}])
    forger.results["library"] = {**forger.results["library"], **junk}


def unprintable(forger: Forger) -> None:
    """A terminal would obey it."""
    text = forger.draw.choice(["\x1b[2J", "\x07", "\x9b2J", "\u202e", "\ud800", "two\nlines"])
    place, name = forger.draw.choice([(forger.results["agent"], "name"), (forger.results["library"], "machine")])
    place[name] += text


def not_canonical(forger: Forger) -> bytes:
    text = text_of(forger.results)
    old, new = forger.draw.choice(
        [
            (b"{\n", b'{\n "official": true,\n'),  # a key twice
            (b"{\n", b'{\n "official": "YES", "summary": {"all": {"success": {"value": 9}}},\n'),
            (b'": ', b'":'),
            (b"\n ", b"\n  "),
            (b'"track"', b'"\\u0074rack"'),
            (b'"control_rate": 10.0', b'"control_rate": 1e1'),
            (text, text + b"\n"),
            (text, b"\xef\xbb\xbf" + text),
        ]
    )
    return pack({**forger.files, "results.json": text.replace(old, new, 1)})


def not_a_rate(forger: Forger) -> bytes:
    rate = forger.draw.choice([b"1e999", b"9" * 400, b"-1e999", b"NaN", b"Infinity", b"0.5", b"true"])
    text = text_of(forger.results).replace(b'"control_rate": 10.0', b'"control_rate": ' + rate, 1)
    return pack({**forger.files, "results.json": text})


def oversized(forger: Forger) -> bytes:
    if forger.draw.random() < 0.5:
        return forger.packed() + bytes(LARGEST)
    size = struct.pack("<II", LARGEST, LARGEST)  # as the table of contents has it, and nothing is there
    content = bytearray(forger.packed())
    entry = content.rindex(b"PK\x01\x02")
    content[entry + 20 : entry + 28] = size
    return bytes(content)


def path_trick(forger: Forger) -> bytes:
    name = forger.draw.choice(["../evil.py", "/etc/passwd", "commands/../x", "commands\\x", "C:x", "a/./b", "é", ""])
    return pack({**forger.files, "results.json": text_of(forger.results), name or " ": b"x"})


def bomb(forger: Forger) -> bytes:
    size = forger.draw.choice([1 << 16, 1 << 22])
    return forger.archive({**forger.unpacked(), "commands/00099.f64": bytes(size)}, compression=zipfile.ZIP_DEFLATED)


def name_twice(forger: Forger) -> bytes:
    written = io.BytesIO(forger.packed())
    with zipfile.ZipFile(written, "a") as archive:
        info = zipfile.ZipInfo("commands/00000.f64", EARLIEST)
        archive.NameToInfo.clear()  # which would warn
        archive.writestr(info, bytes(24))
    return written.getvalue()


def not_in_order(forger: Forger) -> bytes:
    return forger.archive(dict(reversed(forger.unpacked().items())))


def dated(forger: Forger) -> bytes:
    return forger.archive(forger.unpacked(), date=(2026, 1, 1, 0, 0, 0))


def something_behind(forger: Forger) -> bytes:
    return forger.packed() + forger.draw.randbytes(forger.draw.randint(1, 100))


def something_before(forger: Forger) -> bytes:
    return forger.draw.randbytes(forger.draw.randint(1, 100)) + forger.packed()


def cut_off(forger: Forger) -> bytes:
    content = forger.packed()
    return content[: forger.draw.randrange(len(content))]


def flipped_byte(forger: Forger) -> bytes:
    content = bytearray(forger.packed())
    content[forger.draw.randrange(len(content))] ^= 1 << forger.draw.randrange(8)
    return bytes(content)


def other_manifest(forger: Forger) -> bytes:
    files = forger.unpacked()
    manifest = json.loads(files["manifest.json"])
    name = forger.draw.choice(sorted(manifest["files"]))
    if forger.draw.random() < 0.5:
        manifest["files"][name] = "0" * 64
    else:
        del manifest["files"][name]
    return forger.archive({**files, "manifest.json": text_of(manifest)})


def no_manifest(forger: Forger) -> bytes:
    files = forger.unpacked()
    del files["manifest.json"]
    return forger.archive(files)


def no_json(forger: Forger) -> bytes:
    text = forger.draw.choice([b"", b"[]", b"{", b'{"format": NaN}', b"[" * 100_000, b"\xff"])
    return pack({**forger.files, "results.json": text})


def no_archive(forger: Forger) -> bytes:
    return forger.draw.randbytes(forger.draw.randint(0, 1000))


WAYS: list[Callable[[Forger], bytes | None]] = [
    other_metric,
    success_for_failure,
    other_trajectory,
    shorter_trajectory,
    other_episode_seed,
    other_index,
    other_scene,
    other_settings,
    unknown_setting,
    truncated_log,
    truncated_log_and_claim,
    longer_log,
    torn_log,
    no_log,
    swapped_rows,
    swapped_logs,
    fewer_episodes,
    more_episodes,
    no_count,
    too_fast,
    too_abrupt,
    not_finite,
    other_commands,
    other_end,
    other_summary,
    other_set,
    other_hash,
    closed_track,
    other_agent,
    unmarked_privilege,
    other_source,
    agent_of_no_kind,
    other_format,
    other_type,
    extra_claim,
    other_leaf,
    other_leaf,
    other_leaf,
    missing_claim,
    no_library,
    other_actions,
    extra_log,
    talk_of_no_model,
    other_library,
    unprintable,
    not_canonical,
    not_a_rate,
    oversized,
    path_trick,
    bomb,
    name_twice,
    not_in_order,
    dated,
    something_behind,
    something_before,
    cut_off,
    flipped_byte,
    other_manifest,
    no_manifest,
    no_json,
    no_archive,
]

assert set(KINDS) == {"commands", "actions", "grid", "talk"}, "another kind of file wants another forgery"
