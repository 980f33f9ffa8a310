"""LeRobot 0.6.1 has our environment, in its own Python: its episodes are driven from elsewhere, action by action.

Each line on its input is a JSON object with `do` and arguments; it ends its answer with a line that begins with @.
"""

import base64
import json
import sys

import gymnasium

from lerobot.envs.configs import EnvConfig
from lerobot.utils.import_utils import register_third_party_plugins


def main():
    """Answers `reset` and `step`."""
    register_third_party_plugins()
    config = EnvConfig.get_choice_class("threewe")()
    env = gymnasium.make(f"{config.package_name}/{config.task}", **config.gym_kwargs).unwrapped
    for line in sys.stdin:
        request = json.loads(line)
        if request["do"] == "reset":
            observation, info = env.reset(seed=request["episode"])
            over = False
        else:
            observation, _, stopped, late, info = env.step(request["action"])
            over = stopped or late
        picture = observation["pixels"]["camera"]
        answer = {"shape": picture.shape, "picture": base64.b64encode(picture.tobytes()).decode(), "task": env.task}
        answer |= {"over": over, "success": bool(info["is_success"])}
        print("\n@" + json.dumps({"answer": answer}), flush=True)


if __name__ == "__main__":
    main()
