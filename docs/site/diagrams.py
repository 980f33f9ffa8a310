"""Draws the diagrams of the architecture and the glossary: `python docs/site/diagrams.py` writes docs/media/*.svg.

Each lies on a pale card of its own, so that it can be read on light and on dark pages alike.
"""

import math
from pathlib import Path

MEDIA = Path(__file__).resolve().parents[1] / "media"
INK, QUIET, LINE, CARD = "#1f2933", "#52606d", "#52606d", "#f5f7fa"
BLUE, GREEN, ORANGE, GREY, PINK = "#d6e6fb", "#d5f0dd", "#fde5c8", "#e4e7eb", "#fbdce8"


class Drawing:
    """Boxes, arrows and words on a card; lengths are pixels, y points down."""

    def __init__(self, width: int, height: int, title: str) -> None:
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
            f'font-family="Helvetica, Arial, sans-serif" font-size="14">',
            f"<title>{title}</title>",
            '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" '
            f'orient="auto-start-reverse"><path d="M0,0 L8,4 L0,8 z" fill="{LINE}"/></marker></defs>',
            f'<rect width="{width}" height="{height}" rx="10" fill="{CARD}"/>',
        ]

    def box(self, x: float, y: float, w: float, h: float, lines: str, fill: str, dashed: bool = False) -> None:
        """A box with lines of words in its middle; the first one is bold."""
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        self.parts.append(
            f'<rect x="{x}" y="{y}" width="{w}" height="{h}" rx="6" fill="{fill}" stroke="{LINE}"{dash}/>'
        )
        words = lines.split("\n")
        top = y + h / 2 - 9 * (len(words) - 1)
        for number, line in enumerate(words):
            self.words(x + w / 2, top + 18 * number + 5, line, bold=number == 0, color=INK if number == 0 else QUIET)

    def frame(self, x: float, y: float, w: float, h: float, label: str) -> None:
        """A dashed border around several boxes, with its name in the upper left corner."""
        self.parts.append(
            f'<rect x="{x}" y="{y}" width="{w}" height="{h}" rx="8" fill="none" stroke="{LINE}" '
            'stroke-dasharray="3 4"/>'
        )
        self.words(x + 10, y + 19, label, anchor="start", bold=True)

    def words(
        self, x: float, y: float, text: str, anchor: str = "middle", bold: bool = False, color: str = QUIET
    ) -> None:
        """One line of text; `y` is its base line."""
        weight = ' font-weight="bold"' if bold else ""
        self.parts.append(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="{color}"{weight}>{text}</text>')

    def arrow(self, *points: tuple[float, float], both: bool = False, dashed: bool = False) -> None:
        """A line through points, with a head at its end."""
        path = " ".join(f"{'L' if number else 'M'}{x:g},{y:g}" for number, (x, y) in enumerate(points))
        start = ' marker-start="url(#head)"' if both else ""
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        self.parts.append(
            f'<path d="{path}" fill="none" stroke="{LINE}" stroke-width="1.6" marker-end="url(#head)"{start}{dash}/>'
        )

    def axes(self, x: float, y: float, degrees: float, name: str, size: float = 42) -> None:
        """A frame in the plane: x red, y green (counter-clockwise from x)."""
        for turn, color, letter in ((0.0, "#c81e1e", "x"), (90.0, "#137333", "y")):
            angle = math.radians(degrees + turn)
            dx, dy = math.cos(angle), -math.sin(angle)
            self.parts.append(
                f'<path d="M{x:g},{y:g} l{size * dx:.1f},{size * dy:.1f}" stroke="{color}" stroke-width="3"/>'
            )
            self.words(round(x + (size + 10) * dx, 1), round(y + (size + 10) * dy + 4, 1), letter, color=color)
        self.words(x + 6, y + 20, name, anchor="start", bold=True, color=INK)

    def save(self, name: str) -> None:
        """Writes docs/media/<name>.svg."""
        (MEDIA / f"{name}.svg").write_text("\n".join([*self.parts, "</svg>"]) + "\n")


def data_flow() -> None:
    """From samples to a command, and who else has a say."""
    d = Drawing(
        780, 470, "Samples go from the backend through perception, localizer and navigator to the gate and back"
    )
    d.box(20, 20, 740, 52, "Your program\nPython, C++, command line, a learned policy", GREEN)
    d.frame(20, 140, 560, 168, "autonomy stack")
    d.box(35, 180, 160, 104, "Perception\nsensor faults, people,\nobstacle points", BLUE)
    d.box(220, 180, 160, 104, "Localizer\npose, covariance,\nmap, obstacles", BLUE)
    d.box(405, 180, 160, 104, "Navigator\ngoal, path, plan,\nrecovery", BLUE)
    d.box(625, 180, 135, 104, "Safety gate\nlimits, monitor,\nemergency stop", ORANGE)
    d.box(
        20,
        366,
        560,
        84,
        "Backend\nmock · mujoco · one of your own, on a robot or a simulator\nkeeps time, delivers samples, drives",
        GREY,
    )
    d.box(625, 366, 135, 84, "Truth service\nsimulators only,\nfor metrics", PINK, dashed=True)
    d.arrow((195, 232), (220, 232))
    d.arrow((380, 232), (405, 232))
    d.arrow((565, 232), (625, 232))
    d.arrow((115, 366), (115, 284))
    d.words(125, 338, "samples, stamped twice", anchor="start")
    d.arrow((692, 284), (692, 325), (520, 325), (520, 366))
    d.words(510, 352, "velocity, valid for 0.2 s", anchor="end")
    d.arrow((300, 180), (300, 72))
    d.words(292, 112, "pose, map, health", anchor="end")
    d.arrow((485, 72), (485, 180))
    d.words(477, 112, "goals, zones", anchor="end")
    d.arrow((692, 72), (692, 180))
    d.words(684, 112, "velocities, actions", anchor="end")
    d.arrow((580, 408), (625, 408), dashed=True)
    d.save("data_flow")


def frames() -> None:
    """Who is where in what."""
    d = Drawing(780, 400, "Frames: scene, map, odom, base and the sensors, seen from above")
    d.axes(90, 350, 0, "map", 60)
    d.axes(270, 280, 8, "odom", 52)
    d.parts.append(  # the robot, turned about its base
        f'<g transform="translate(560 190) rotate(-30)"><rect x="-95" y="-68" width="190" height="136" rx="12" '
        f'fill="{BLUE}" stroke="{LINE}"/></g>'
    )
    d.axes(560, 190, 30, "base", 46)
    d.axes(623, 154, 30, "", 30)
    d.words(632, 174, "lidar", anchor="start", bold=True, color=INK)
    d.axes(526, 131, 120, "", 26)
    d.words(545, 96, "ultrasonic_left", anchor="start", bold=True, color=INK)
    d.arrow((100, 343), (258, 286), dashed=True)
    d.words(180, 348, "map_from_odom", anchor="start", color=INK)
    d.words(180, 366, "jumps with corrections, while odom stays smooth", anchor="start")
    d.arrow((280, 274), (546, 194), dashed=True)
    d.words(320, 176, "odom_from_base", color=INK)
    d.words(320, 194, "wheels and gyro, 50 times a second")
    d.words(770, 320, "base_from_lidar, base_from_ultrasonic_left", anchor="end", color=INK)
    d.words(770, 338, "fixed, from the robot profile", anchor="end")
    d.words(20, 28, "From above: x ahead (red), y to the left (green), z up; angles counter-clockwise.", "start", True)
    d.words(20, 50, "a_from_b maps a point in b to a:", "start")
    d.words(20, 70, "map_from_lidar = map_from_odom * odom_from_base * base_from_lidar", "start", color=INK)
    d.save("frames")


def tick() -> None:
    """What happens in 20 ms of robot time."""
    d = Drawing(780, 370, "A tick of 20 ms: act, advance, sense, tell")
    heads = [(20, "1  act", ORANGE), (275, "2  advance", GREY), (530, "3  sense", BLUE)]
    texts = {
        20: [
            "for each robot, in order:",
            "· stand, if a sensor that it",
            "  needs is faulty",
            "· else the motion's navigator,",
            "  or the velocity that is held",
            "· gate: limits, monitor, stop",
            "· command, valid for 0.2 s",
        ],
        275: [
            "for the whole world, once:",
            "· lockstep: simulate 20 ms,",
            "  two steps of 10 ms",
            "· real time: wait for the next",
            "  multiple of 20 ms",
            "",
            "now = now + 20 ms",
        ],
        530: [
            "for each robot, in order:",
            "· poll samples, check them",
            "· health: drop faulty ones",
            "· localizer: pose, map",
            "· people, blind directions",
            "· observers get the tick",
            "· motions that ended, end",
        ],
    }
    for x, head, fill in heads:
        d.box(x, 60, 230, 220, "", fill)
        d.words(x + 14, 86, head, "start", True, INK)
        for number, line in enumerate(texts[x]):
            indent = 12 if line.startswith("  ") else 0
            d.words(x + 14 + indent, 114 + 24 * number, line.strip(), "start", color=INK)
    d.arrow((250, 170), (275, 170))
    d.arrow((505, 170), (530, 170))
    d.words(20, 34, "One tick: 20 ms of robot time", "start", True, INK)
    d.arrow((645, 280), (645, 310), (135, 310), (135, 280))
    d.words(390, 330, "4  waits that are due resume your program; the next tick begins only", color=INK)
    d.words(390, 350, "when nothing in it is ready to run and no `thinking` block is open", color=INK)
    d.save("tick")


def threads() -> None:
    """Which code runs on which thread."""
    d = Drawing(780, 500, "Threads: asyncio programs, programs without async, and batches of environments")
    d.words(20, 34, "async Robot", "start", True, INK)
    d.box(
        20,
        50,
        330,
        76,
        "event loop's thread\nyour tasks, then the pump: ticks in C++,\nthe interpreter lock released",
        GREEN,
    )
    d.box(
        470,
        50,
        290,
        76,
        "one thread per Python backend\nstep() every 20 ms, under a time limit;\nC++ backends run on the loop's",
        GREY,
    )
    d.arrow((350, 88), (470, 88), both=True)
    d.words(410, 78, "mailbox")
    d.words(20, 174, "threewe.sync.Robot", "start", True, INK)
    d.box(20, 190, 330, 60, "your thread\ncalls, and waits for the answer", GREEN)
    d.box(470, 190, 290, 60, "a loop's thread of its own\nruns the async Robot above", BLUE)
    d.arrow((350, 220), (470, 220), both=True)
    d.words(410, 210, "calls")
    d.words(20, 298, "VectorEnv(num_envs=N, num_threads=T)", "start", True, INK)
    d.box(20, 314, 330, 60, "your thread\nstep(): environments 0 .. N/T", GREEN)
    d.box(470, 314, 290, 60, "T - 1 workers\neach a fixed share of the environments", BLUE)
    d.arrow((350, 344), (470, 344), both=True)
    d.words(410, 334, "a barrier")
    d.words(
        20,
        420,
        "A world and its robots belong to one thread at a time; a second one gets a ContractError.",
        "start",
        color=INK,
    )
    d.words(
        20,
        444,
        "Different worlds are independent. Scenes, tables and profiles are const and shared by all.",
        "start",
        color=INK,
    )
    d.words(
        20,
        468,
        "Nothing depends on which thread ran it: results are the same bits with any number.",
        "start",
        color=INK,
    )
    d.save("threads")


def localization_state() -> None:
    """How far a robot knows where it is."""
    d = Drawing(780, 400, "The states of localization, and what leads from one to another")
    d.box(40, 70, 220, 76, "tracking\nscans fit the map\nat the estimated pose", GREEN)
    d.box(520, 70, 220, 76, "doubting\nthe prior map is contradicted;\nit is searched meanwhile", BLUE)
    d.box(40, 270, 220, 76, "lost\nthe pose is where it was last;\nthe whole map is searched", ORANGE)
    d.box(520, 270, 220, 76, "relocating\nthe search found one pose;\nlater scans must fit there", GREY)
    d.words(150, 30, "an initial pose, or a map of its own")
    d.arrow((150, 38), (150, 70))
    d.words(150, 388, "a prior map alone")
    d.arrow((150, 374), (150, 346))
    d.arrow((260, 92), (520, 92))
    d.words(390, 84, "prior map contradicted")
    d.arrow((520, 124), (260, 124))
    d.words(390, 142, "it agrees again, or relocalized")
    d.arrow((90, 146), (90, 270))
    d.words(84, 196, "no scan fits", "end")
    d.words(84, 214, "for 2 s", "end")
    d.arrow((180, 270), (180, 146))
    d.words(188, 214, "recognised", "start")
    d.arrow((620, 146), (620, 180), (290, 180), (250, 270))
    d.words(480, 172, "no scan fits for 2 s")
    d.arrow((260, 292), (520, 292))
    d.words(390, 284, "one pose found")
    d.arrow((520, 324), (260, 324))
    d.words(390, 342, "a scan does not fit there")
    d.arrow((560, 270), (560, 236), (300, 236), (226, 146))
    d.words(470, 228, "three scans fit there: relocalized")
    d.save("localization_state")


def draw_all() -> None:
    """Writes every diagram."""
    for draw in (data_flow, frames, tick, threads, localization_state):
        draw()


if __name__ == "__main__":
    draw_all()
