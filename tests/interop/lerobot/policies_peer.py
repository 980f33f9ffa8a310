"""LeRobot 0.6.1 at work: trains policies and runs them, in its own Python. It knows nothing of 3we.

Each line on its input is a JSON object with `do` and arguments; it ends its answer with a line that begins with @.
"""

import json
import os
import sys
import time
import traceback
from pathlib import Path

os.environ["HF_HUB_OFFLINE"] = "1"  # whatever would be downloaded, fails

import numpy as np
import torch
from safetensors.torch import load_file

from lerobot.configs.policies import PreTrainedConfig
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.policies.factory import get_policy_class, make_policy_config, make_pre_post_processors

torch.set_num_threads(1)


def train(root, kind, options, inputs, numbers, steps):
    """A policy of drawn weights that learns a function of its inputs for some steps of two observations each."""
    torch.manual_seed(1)
    features = {name: PolicyFeature(FeatureType(each["type"]), tuple(each["shape"])) for name, each in inputs.items()}
    actions = {"action": PolicyFeature(FeatureType.ACTION, (numbers,))}
    options = {name: tuple(each) if isinstance(each, list) else each for name, each in options.items()}
    config = make_policy_config(
        kind, device="cpu", push_to_hub=False, input_features=features, output_features=actions, **options
    )
    policy = get_policy_class(kind)(config)
    rng = np.random.default_rng(1)
    statistics = {}
    for name, feature in {**features, **actions}.items():
        size = (3, 1, 1) if feature.type is FeatureType.VISUAL else feature.shape
        middle, spread = rng.normal(0.3, 0.1, size), rng.uniform(0.2, 0.5, size)
        named = {"mean": middle, "std": spread, "min": middle - spread, "max": middle + spread}
        statistics[name] = {key: np.asarray(value, np.float32) for key, value in named.items()}
    before, after = make_pre_post_processors(config, dataset_stats=statistics)
    # at higher rates, such few steps leave actions that hardly differ from one another
    optimizer = torch.optim.AdamW(policy.parameters(), lr=3e-6)
    policy.train()
    length = len(config.action_delta_indices)
    losses = []
    for _ in range(steps):
        light = torch.rand(2)  # pictures differ in it
        batch = {
            name: torch.rand(2, *feature.shape) * light.reshape(2, *[1] * len(feature.shape))
            for name, feature in features.items()
        }
        seen = batch[next(iter(features))].flatten(1).mean(1)
        target = torch.sin(seen[:, None, None] * 20 + torch.arange(length)[None, :, None] / 3 + torch.arange(numbers))
        batch.setdefault(
            "observation.state", torch.zeros(2, 1)
        )  # ACT asks it for its device, whether it takes it or not
        batch |= {"action": target, "action_is_pad": torch.zeros(2, length, dtype=torch.bool)}
        loss, _ = policy.forward(batch)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    policy.save_pretrained(root)
    before.save_pretrained(root)
    after.save_pretrained(root)
    low, high = statistics["action"]["min"], statistics["action"]["max"]
    weights = sum(each.numel() for each in policy.parameters())
    return {"losses": losses, "weights": weights, "range": (high - low).tolist()}


def backbone(root):
    """A folder with a vision-language model of drawn weights for SmolVLA; its words are letters."""
    from tokenizers import Tokenizer, models, pre_tokenizers
    from transformers import PreTrainedTokenizerFast

    marks = {
        "fake_image_token": "<fake_token_around_image>",
        "image_token": "<image>",
        "global_image_token": "<global-img>",
        "end_of_utterance_token": "<end_of_utterance>",
    }
    words = ["<pad>", "<s>", "</s>", "<unk>", *marks.values(), *"abcdefghijklmnopqrstuvwxyz .\n"]
    vocabulary = {word: i for i, word in enumerate(words)}
    tokenizer = Tokenizer(models.WordLevel(vocabulary, unk_token="<unk>"))
    tokenizer.pre_tokenizer = pre_tokenizers.Split("", "isolated")
    special = dict(zip(("pad_token", "bos_token", "eos_token", "unk_token"), words, strict=False))
    fast = PreTrainedTokenizerFast(tokenizer_object=tokenizer, extra_special_tokens=marks, **special)
    fast.save_pretrained(root)
    text = {"model_type": "llama", "hidden_size": 96, "intermediate_size": 256, "num_hidden_layers": 2}
    text |= {"num_attention_heads": 4, "num_key_value_heads": 2, "head_dim": 24, "vocab_size": len(words)}
    vision = {"model_type": "smolvlm_vision", "hidden_size": 64, "intermediate_size": 128, "num_hidden_layers": 1}
    vision |= {"num_attention_heads": 2, "image_size": 64, "patch_size": 16}
    model = {"model_type": "smolvlm", "architectures": ["SmolVLMForConditionalGeneration"], "scale_factor": 4}
    model |= {"image_token_id": vocabulary["<image>"], "pad_token_id": 0, "text_config": text, "vision_config": vision}
    pictures = {"image_processor_type": "SmolVLMImageProcessor", "size": {"longest_edge": 64}}
    processor = {"processor_class": "SmolVLMProcessor", "image_seq_len": 1}
    for name, content in (
        ("config", model),
        ("preprocessor_config", {**pictures, "max_image_size": {"longest_edge": 64}}),
        ("processor_config", processor),
    ):
        Path(root, f"{name}.json").write_text(json.dumps(content))
    return {}


def predict(root, arrays, out, task=None, committed=None):
    """Chunks for observations, whose keys are `number/name`, of batches of one; after actions that are committed."""
    config = PreTrainedConfig.from_pretrained(root)
    policy = get_policy_class(config.type).from_pretrained(root).eval()
    before, after = make_pre_post_processors(config, pretrained_path=root)
    given = np.load(arrays)
    count = 1 + max(int(key.split("/")[0]) for key in given.files)
    found, options = {}, {}
    if committed is not None:  # normalised by hand
        (statistics,) = Path(root).glob("policy_postprocessor_*.safetensors")
        action = {name: value for name, value in load_file(statistics).items() if name.startswith("action.")}
        left = (torch.tensor(committed) - action["action.mean"]) / action["action.std"]
        options = {"prev_chunk_left_over": left[None], "inference_delay": len(committed)}
    began = time.process_time()
    for i in range(count):
        own = {key.split("/", 1)[1]: torch.from_numpy(given[key]) for key in given.files if key.startswith(f"{i}/")}
        batch = before(own if task is None else {**own, "task": [task]})
        torch.manual_seed(0)
        batch.setdefault("observation.state", torch.zeros(1, 1))
        with torch.no_grad():
            found[str(i)] = after(policy.predict_action_chunk(batch, **options))[0].numpy()
    np.savez(out, **found)
    return {"seconds": time.process_time() - began}


def main():
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {
                "answer": {"train": train, "predict": predict, "backbone": backbone}[request.pop("do")](**request)
            }
        except Exception:
            answer = {"error": traceback.format_exc()}
        print("\n@" + json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
