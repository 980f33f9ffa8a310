"""What peers are given in files, and what is made of their answers (benchmarks/peers_bench.py)."""

import importlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from threewe import LaserScan, Pose2D
from threewe.slam.log import Log

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
SHARED = ("course", "env_steps", "peers_given", "peers_tables", "world")


@pytest.fixture(autouse=True)
def benchmarks_importable(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS / "peers"))
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    yield
    for name in SHARED:
        sys.modules.pop(name, None)


def plan(who, query, seconds, length, cost=0.0, blocked=0.0):
    judged = {"length": length, "cost": cost, "blocked": blocked}
    return {"kind": "plan", "who": who, "differs": "", "size": "campus", "query": query, "seconds": seconds, **judged}


def test_the_export_benchmark_finds_what_it_measures():
    command = [sys.executable, BENCHMARKS / "record/lerobot_export.py", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "--episodes" in done.stdout


def test_a_course_is_read_as_it_was_written(tmp_path):
    (tmp_path / "yard.pgm").write_bytes(b"P5 3 2 255\n" + bytes([0, 255, 10, 255, 0, 255]))
    (tmp_path / "yard.txt").write_text("course yard 0.05 yard.pgm\nquery 0.1 0.05 1.5 2\nquery 1 2 3 4\n")
    course = importlib.import_module("course").Course.read(tmp_path / "yard.txt")
    assert (course.name, course.resolution, course.width, course.height) == ("yard", 0.05, 3, 2)
    assert list(course.free) == [0, 255, 10, 255, 0, 255]  # 10 is a line's end in the header
    assert course.queries == [((0.1, 0.05), (1.5, 2.0)), ((1.0, 2.0), (3.0, 4.0))]


def test_a_log_is_handed_over_with_its_scanner_turned_as_it_is(tmp_path):
    log = Log(base_from_lidar=Pose2D(0.1, 0.0, 0.5))
    log.add(1.5, LaserScan(np.float32([1.0, 2.0, 80.0]), -1.0, 0.5, 0.0, 80.0), Pose2D(1.0, 2.0, 0.25))
    importlib.import_module("peers_given").write_log(log, "yard", tmp_path / "yard.txt")
    head, scan = (line.split() for line in (tmp_path / "yard.txt").read_text().splitlines())
    assert head[:2] == ["log", "yard"]
    # beams spread over 1 rad; their middle looks 0.5 rad to the right of the scanner, which looks 0.5 rad to the left
    assert [float(word) for word in head[2:]] == pytest.approx([1.0, 80.0, 0.1, 0.0, 0.0])
    assert [float(word) for word in scan[1:]] == [1.5, 1.0, 2.0, 0.25, 1.0, 2.0, 80.0]


def test_a_planner_is_compared_with_ours_on_the_queries_that_it_got():
    tables = importlib.import_module("peers_tables")
    results = [plan("ours", query, 0.001 * (1 + query), 11.0, 50.0) for query in range(9)]
    results += [plan("ours, the first plan", query, 0.01, 11.0, 50.0) for query in range(9)]
    results += [plan("ours, the shortest way", query, 0.001, 10.0, 60.0) for query in range(9)]
    results += [plan("other", 0, 0.1, 12.0, 75.0, 0.2), plan("other", 1, 0.2, 0.0), plan("other", 2, 0.4, 14.0, 100.0)]
    plans = {}
    for result in results:
        plans.setdefault(result["who"], {})[result["query"]] = result
    cells = tables.plan_cells(plans["other"], plans).split()
    # three plans, of which one found no way; 200 ms beside 2 ms and 10 ms; lengths of 1.2 and 1.4, costs of 1.5 and 2
    assert cells == ["3", "67%", "200", "200", "100", "/", "20", "1.300", "1.75"]
    assert "0.20 m of a way is blocked" in tables.plan_words(plans["other"])
    assert "/" not in tables.plan_cells(plans["ours"], plans)


def test_a_planner_that_finds_nothing_has_no_length():
    tables = importlib.import_module("peers_tables")
    plans = {who: {0: plan(who, 0, 0.002, 10.0, 10.0)} for who in ("ours", "ours, the first plan")}
    lost = {0: plan("lost", 0, 3.0, 0.0)}
    assert tables.plan_cells(lost, plans).split() == ["1", "0%", "3,000", "3,000", "1,500", "/", "1,500"]


def test_a_map_has_its_error_and_its_speed():
    tables = importlib.import_module("peers_tables")
    ours = {"who": "ours", "seconds": [0.5, 0.25, 1.0], "data_seconds": 100.0}
    ours |= {"translation": (0.01, 0.02), "rotation": (0.1, 0.2)}
    assert tables.map_cells(ours, ours).split() == ["0.0100", "+-", "0.0200", "0.10", "+-", "0.20", "200"]
    assert tables.map_cells({**ours, "who": "other", "seconds": [2.0]}, ours).split()[-2:] == ["50", "4.0"]
    assert not tables.map_cells(None, ours).strip()
