"""A language model of random weights behind llama.cpp's server, in its own Python: a grammar makes calls of nonsense.

Arguments: a folder for the model, a port of this machine. It knows nothing of 3we.
"""

import os
import sys
from pathlib import Path

import gguf
import numpy as np

WIDTH, FEED, LAYERS, HEADS, CONTEXT = 64, 128, 2, 2, 16384
ENDS = (2, 3 + ord('"'), 3 + ord("}"))  # tokens that end answers, texts and objects: likely ones, so that all are short


def main() -> None:
    """Writes the model, and becomes its server."""
    folder, port = Path(sys.argv[1]), sys.argv[2]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "random.gguf"
    write(path)
    options = ["--host", "127.0.0.1", "--port", port, "--n_ctx", str(CONTEXT), "--verbose", "false"]
    os.execv(sys.executable, [sys.executable, "-m", "llama_cpp.server", "--model", str(path), *options])


def write(path: Path) -> None:
    """A Llama whose tokens are bytes."""
    random = np.random.default_rng(7)
    tokens = ["<unk>", "<s>", "</s>", *(f"<0x{byte:02X}>" for byte in range(256))]
    kinds = [gguf.TokenType.UNKNOWN, gguf.TokenType.CONTROL, gguf.TokenType.CONTROL, *[gguf.TokenType.BYTE] * 256]
    model = gguf.GGUFWriter(path, "llama")
    model.add_context_length(CONTEXT)
    model.add_embedding_length(WIDTH)
    model.add_block_count(LAYERS)
    model.add_feed_forward_length(FEED)
    model.add_head_count(HEADS)
    model.add_head_count_kv(HEADS)
    model.add_layer_norm_rms_eps(1e-5)
    model.add_rope_dimension_count(WIDTH // HEADS)
    model.add_tokenizer_model("llama")
    model.add_token_list(tokens)
    model.add_token_scores([0.0] * len(tokens))
    model.add_token_types(kinds)
    model.add_bos_token_id(1)
    model.add_eos_token_id(2)
    model.add_unk_token_id(0)
    model.add_chat_template("{% for m in messages %}{{ m.role }}: {{ m.content }}\n{% endfor %}assistant: ")
    shapes = {"token_embd.weight": (len(tokens), WIDTH), "output.weight": (len(tokens), WIDTH), "output_norm.weight": 0}
    for i in range(LAYERS):
        for name in ("attn_q", "attn_k", "attn_v", "attn_output"):
            shapes[f"blk.{i}.{name}.weight"] = (WIDTH, WIDTH)
        shapes[f"blk.{i}.ffn_gate.weight"] = shapes[f"blk.{i}.ffn_up.weight"] = (FEED, WIDTH)
        shapes[f"blk.{i}.ffn_down.weight"] = (WIDTH, FEED)
        shapes[f"blk.{i}.attn_norm.weight"] = shapes[f"blk.{i}.ffn_norm.weight"] = 0
    for name, shape in shapes.items():
        weights = random.normal(0.3 if name == "token_embd.weight" else 0.0, 0.3, shape) if shape else np.ones(WIDTH)
        if name.endswith(("attn_output.weight", "ffn_down.weight")):
            weights *= 0.02  # so that the mean of embeddings comes through
        if name == "output.weight":
            weights *= 0.3
            weights[list(ENDS)] = 0.08  # along the mean of all embeddings
        model.add_tensor(name, weights.astype(np.float32))
    model.write_header_to_file()
    model.write_kv_data_to_file()
    model.write_tensors_to_file()
    model.close()


if __name__ == "__main__":
    main()
