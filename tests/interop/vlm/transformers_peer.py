"""A vision model of random weights behind `transformers serve`, in its own Python: it babbles, and ignores tools.

Arguments: a folder for the model, a port of this machine. It knows nothing of 3we.
"""

import os
import sys
from pathlib import Path

from tokenizers import Tokenizer, decoders, models, pre_tokenizers
from transformers import (
    CLIPImageProcessorPil,
    CLIPVisionConfig,
    LlamaConfig,
    LlavaConfig,
    LlavaForConditionalGeneration,
    LlavaProcessor,
    PreTrainedTokenizerFast,
    set_seed,
)

SIDE, PATCH = 48, 8  # [px]
ENDS = 16  # tokens that end an answer, so that it babbles shortly
CHAT = (
    "{% for message in messages %}{{ message['role'] }}: {% if message['content'] is string %}"
    "{{ message['content'] }}{% else %}{% for part in message['content'] %}"
    "{% if part['type'] == 'text' %}{{ part['text'] }}{% else %}<image>{% endif %}{% endfor %}{% endif %}\n"
    "{% endfor %}{% if add_generation_prompt %}assistant: {% endif %}"
)


def main() -> None:
    """Writes the model, and becomes its server."""
    folder, port = Path(sys.argv[1]), sys.argv[2]
    write(folder)
    program = str(Path(sys.executable).with_name("transformers"))
    options = ["--host", "127.0.0.1", "--port", port, "--device", "cpu", "--log-level", "warning"]
    settings = {"HF_HUB_OFFLINE": "1", "OMP_NUM_THREADS": "1"}  # so small a model is slower in several threads
    os.execve(program, [program, "serve", str(folder), *options], {**os.environ, **settings})


def write(folder: Path) -> None:
    """A LLaVA of 0.2 million random weights, whose tokens are bytes."""
    set_seed(7)
    special = ["<pad>", "<s>", "</s>", "<image>"]
    alphabet = sorted(pre_tokenizers.ByteLevel.alphabet())
    vocabulary = {token: index for index, token in enumerate([*special, *alphabet])}
    tokens = Tokenizer(models.BPE(vocab=vocabulary, merges=[]))
    tokens.pre_tokenizer = pre_tokenizers.ByteLevel(add_prefix_space=False)
    tokens.decoder = decoders.ByteLevel()
    names = {"pad_token": "<pad>", "bos_token": "<s>", "eos_token": "</s>"}
    tokenizer = PreTrainedTokenizerFast(tokenizer_object=tokens, additional_special_tokens=["<image>"], **names)
    tokenizer.chat_template = CHAT
    size = {"height": SIDE, "width": SIDE}
    pictures = CLIPImageProcessorPil(size=size, crop_size=size)
    layout = {"patch_size": PATCH, "vision_feature_select_strategy": "default", "num_additional_image_tokens": 1}
    LlavaProcessor(pictures, tokenizer, chat_template=CHAT, **layout).save_pretrained(folder)
    layers = {"hidden_size": 64, "intermediate_size": 128, "num_hidden_layers": 2, "num_attention_heads": 2}
    text = LlamaConfig(vocab_size=len(vocabulary), num_key_value_heads=2, max_position_embeddings=8192, **layers)
    sight = CLIPVisionConfig(image_size=SIDE, patch_size=PATCH, projection_dim=64, **layers)
    config = LlavaConfig(
        text_config=text, vision_config=sight, image_token_index=vocabulary["<image>"], tie_word_embeddings=False
    )
    config.pad_token_id, config.eos_token_id = 0, 2
    model = LlavaForConditionalGeneration(config)
    model.generation_config.do_sample = True
    model.generation_config.eos_token_id = [2, *range(4, 4 + ENDS)]
    print(f"{sum(p.numel() for p in model.parameters())} weights", flush=True)
    model.save_pretrained(folder)


if __name__ == "__main__":
    main()
