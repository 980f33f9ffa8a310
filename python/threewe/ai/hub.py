"""Policies on the Hugging Face Hub: only what a policy consists of is fetched, checked, and kept by its commit."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from threewe._arguments import as_text
from threewe._extras import needed_for
from threewe.ai.checkpoint import CONFIG, PROCESSORS, WEIGHTS
from threewe.ai.folder import DESCRIPTION, ENCODER, GRAPH, HEAD, LARGEST
from threewe.errors import ConfigError

if TYPE_CHECKING:
    from threewe.data.hub import RemoteFile

FILES = (DESCRIPTION, GRAPH, HEAD, ENCODER, CONFIG, WEIGHTS, *PROCESSORS, "README.md")
"""Of a policy, ours or LeRobot's; with the tensors that processor files name."""
STATES = re.compile(r"policy_(pre|post)processor_\w+\.safetensors")


def is_hub_id(source: str | os.PathLike[str]) -> bool:
    """Whether it may name a repository of the Hub, and no folder here."""
    named = isinstance(source, str) and re.fullmatch(r"[\w-][\w.-]{0,95}/[\w-][\w.-]{0,95}", source, re.ASCII)
    return bool(named) and not Path(source).exists() and not Path(source).parent.exists()


def local_policy(source: str | os.PathLike[str], revision: str | None) -> str | os.PathLike[str]:
    """What was named, or the folder of what it names on the Hub. Raises ConfigError, ConnectionError."""
    if is_hub_id(source):
        return fetch_policy(str(source), None if revision is None else as_text("revision", revision))
    if revision is not None:
        raise ConfigError(f"{source}: revision={revision!r} is of a repository of the Hub, user/name; this is a folder")
    return source


def fetch_policy(repo_id: str, revision: str | None) -> Path:
    """The folder of a policy of the Hub, as it is at a branch, tag or commit, `main` where left out.

    A commit that is kept here already needs no network. Raises ConfigError, ConnectionError.
    """
    kept = _kept() / repo_id.replace("/", "--")
    if revision is not None and re.fullmatch("[0-9a-f]{40}", revision) and (kept / revision).is_dir():
        return kept / revision
    with needed_for("a policy of the Hub", "data"):
        from threewe.data.hub import download, hub_api
        from threewe.data.hub_errors import hub_errors

    elsewhere = f"hf download {repo_id} --local-dir policy"
    if commits := sorted(path.name for path in kept.glob("[0-9a-f]" * 40)):
        again = f"revision='{commits[-1]}' is kept here; another: where there is a network, {elsewhere}"
    else:
        again = f"where there is a network, {elsewhere}; then pass the folder: from_pretrained('policy')"
    api = hub_api(None)
    with hub_errors(repo_id, "pulling", again, "policy"):
        info = api.model_info(repo_id, revision=revision, files_metadata=True)
        commit, files = str(info.sha), _listing(repo_id, info.siblings or [])
        target = kept / commit
        if target.is_dir():
            return target
        partial = kept / f".{commit}.partial"
        partial.mkdir(parents=True, exist_ok=True)
        download(api, repo_id, commit, files, partial, None, "model")
    shutil.rmtree(partial / ".cache", ignore_errors=True)
    partial.rename(target)
    return target


def _kept() -> Path:
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache, "threewe", "policies")


def _listing(repo_id: str, siblings: Sequence[object]) -> list[RemoteFile]:
    """A policy's files, which all are in the top folder."""
    from threewe.data.hub import RemoteFile

    found = []
    for sibling in siblings:
        name, size, lfs = (getattr(sibling, each, None) for each in ("rfilename", "size", "lfs"))
        if name not in FILES and not STATES.fullmatch(str(name)):
            continue
        if not isinstance(size, int) or not 0 <= size <= LARGEST * 2:
            raise ConfigError(f"'{repo_id}': {name!r} is {size!r} bytes: not pulled")
        sha256 = lfs.sha256 if lfs is not None else None
        found.append(RemoteFile(PurePosixPath(str(name)), size, sha256, getattr(sibling, "blob_id", None)))
    names = {str(file.path) for file in found}
    if not {DESCRIPTION, CONFIG} & names:
        raise ConfigError(f"'{repo_id}' is no policy: it has neither {DESCRIPTION} nor {CONFIG}")
    return found
