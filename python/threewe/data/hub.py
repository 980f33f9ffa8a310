"""Datasets on the Hugging Face Hub: push and pull.

`upload_folder` is what `huggingface_hub` offers for all sizes: called again after a break it skips what is committed
and what was uploaded; from 2.0 on it also commits in batches while it uploads. `upload_large_folder` is no more in
2.x, and kept notes of its own in the dataset. The tag `v3.0` is set last, so that LeRobot never loads half a push.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from threewe._arguments import as_file, as_text
from threewe.data.hub_card import write_card
from threewe.data.hub_dataset import FOLDERS, VERSION, open_whole
from threewe.data.hub_errors import HOW_TO_LOG_IN, hub_errors, not_a_repo_id
from threewe.errors import ConfigError

if TYPE_CHECKING:
    from huggingface_hub import HfApi

OnProgress = Callable[[float], object]
"""Called with the share of the bytes that has arrived, 0 to 1."""

PATTERNS = [f"{folder}/*" for folder in FOLDERS]
TOP_FILES = ("README.md", "preview.jpg")
DOWNLOADS_AT_ONCE = 8
MOST_FILES = 100_000


def push(
    dataset_dir: str | os.PathLike[str],
    repo_id: str,
    *,
    private: bool = False,
    license: str | None = None,
    token: str | None = None,
) -> str:
    """Publishes a LeRobot v3.0 dataset: its files, a card with a preview picture, and the tag that LeRobot looks for.

    Only `meta`, `data`, `videos` and `images` are uploaded, and the README.md where the dataset has one. Files of the
    dataset on the Hub that are not in the folder any more are deleted there. Broken off, it goes on where it was when
    it is called again.

    Args:
        dataset_dir: the dataset's folder.
        repo_id: `user/name` or `organization/name`; made where it does not exist.
        private: whether only its owner sees it; a dataset that exists and is public is refused then.
        license: such as `cc-by-4.0` or `apache-2.0`, for the card.
        token: of the Hub; the one that `hf auth login` has stored, or HF_TOKEN, where left out.

    Returns:
        Where it is: a URL.

    Raises:
        ConfigError: no dataset, a wrong repository id, no token, or a server that refuses.
        ConnectionError: no connection, or one that broke off.
    """
    if license is not None and not re.fullmatch(r"[a-z0-9][a-z0-9.+-]*", license):
        raise ConfigError(f"license must be an identifier such as cc-by-4.0 or apache-2.0, not {license!r}")
    _check_repo_id(repo_id)
    dataset = open_whole(as_file("dataset_dir", dataset_dir))
    api = hub_api(token)
    if api.token is None:
        raise ConfigError(f"no token of the Hub: {HOW_TO_LOG_IN}")
    with hub_errors(repo_id, "pushing", "push again, it goes on where it was"):
        url = api.create_repo(repo_id, repo_type="dataset", private=private, exist_ok=True)
        if private and not api.dataset_info(repo_id).private:
            raise ConfigError(
                f"'{repo_id}' exists and is public: make it private in its settings first, or take a new name"
            )
        api.upload_folder(
            repo_id=repo_id,
            repo_type="dataset",
            folder_path=dataset.root,
            allow_patterns=list(PATTERNS),
            delete_patterns=list(PATTERNS),
            commit_message=f"Upload {len(dataset)} episodes, {dataset.info.total_frames} frames",
        )
        with tempfile.TemporaryDirectory() as folder:
            write_card(dataset, repo_id, license, Path(folder))
            api.upload_folder(
                repo_id=repo_id, repo_type="dataset", folder_path=folder, commit_message="Write the dataset card"
            )
        _tag(api, repo_id)
    return str(url)


def pull(
    repo_id: str,
    directory: str | os.PathLike[str],
    *,
    revision: str | None = None,
    token: str | None = None,
    on_progress: OnProgress | None = None,
) -> Path:
    """Downloads a LeRobot v3.0 dataset, and checks size and hash of every file and that the dataset is whole.

    It arrives in a hidden folder next to `directory`, which gets its name when all is there and right. Broken off, it
    goes on where it was when it is called again.

    Args:
        repo_id: `user/name` or `organization/name`.
        directory: the dataset's folder; must not exist, or be empty.
        revision: a branch, tag or commit; the tag `v3.0`, or `main` without one, where left out.
        token: see `push`; public datasets need none.
        on_progress: called with the share that has arrived, 0 to 1.

    Returns:
        The folder.

    Raises:
        ConfigError: a folder that is in use, a wrong repository id, a server that refuses, or a dataset that is none.
        ConnectionError: no connection, or one that broke off.
    """
    _check_repo_id(repo_id)
    target = as_file("directory", directory).absolute()
    if target.is_symlink() or (target.exists() and (not target.is_dir() or any(target.iterdir()))):
        raise ConfigError(f"{target}: exists already; name a folder that does not, or an empty one")
    if not target.parent.is_dir():
        raise ConfigError(f"{target.parent}: no such folder")
    partial = target.with_name(f".{target.name}.partial")
    for path in (partial, *partial.rglob("*")):
        if path.is_symlink():  # what is written there would go elsewhere
            raise ConfigError(f"{path}: a symbolic link; remove it")
    api = hub_api(token)
    with hub_errors(repo_id, "pulling", "pull again, it goes on where it was"):
        commit, files = _listing(api, repo_id, revision)
        _check_space(target.parent, files)
        download(api, repo_id, commit, files, partial, on_progress, "dataset")
    _keep_only(partial, files)
    open_whole(partial)
    with suppress(FileNotFoundError):
        target.rmdir()
    partial.rename(target)
    return target


@dataclass(frozen=True)
class RemoteFile:
    """A file on the Hub."""

    path: PurePosixPath
    size: int
    """[bytes]"""
    sha256: str | None
    """of its content, where the Hub knows it"""
    git_sha1: str | None
    """of its content as a git object"""


def hub_api(token: str | None) -> HfApi:
    """The Hub by a token, or by the one that is stored."""
    from huggingface_hub import HfApi, get_token

    # Both are read now, not when the package is imported.
    return HfApi(endpoint=os.environ.get("HF_ENDPOINT"), token=token or get_token(), library_name="threewe")


def _check_repo_id(repo_id: str) -> None:
    if not re.fullmatch(r"[\w.-]{1,96}/[\w.-]{1,96}", as_text("repo_id", repo_id), re.ASCII):
        raise not_a_repo_id(repo_id)


def _tag(api: HfApi, repo_id: str) -> None:
    """Sets the tag to what is on the main branch now."""
    from huggingface_hub.errors import RevisionNotFoundError

    with suppress(RevisionNotFoundError):
        api.delete_tag(repo_id, tag=VERSION, repo_type="dataset")
    api.create_tag(repo_id, tag=VERSION, repo_type="dataset")


def _listing(api: HfApi, repo_id: str, revision: str | None) -> tuple[str, list[RemoteFile]]:
    """The commit and its files; none of their names leads out of a folder."""
    from huggingface_hub.errors import RevisionNotFoundError

    try:
        info = api.dataset_info(repo_id, revision=revision or VERSION, files_metadata=True)
    except RevisionNotFoundError:
        if revision is not None:
            raise
        info = api.dataset_info(repo_id, files_metadata=True)
    files = []
    for sibling in info.siblings or []:
        path = PurePosixPath(sibling.rfilename)
        if path.parts[:1] not in {(folder,) for folder in FOLDERS} and sibling.rfilename not in TOP_FILES:
            continue
        if path.is_absolute() or ".." in path.parts or "\\" in sibling.rfilename or "\0" in sibling.rfilename:
            raise ConfigError(f"'{repo_id}' has a file with the dangerous name {sibling.rfilename!r}: not pulled")
        if not isinstance(sibling.size, int) or sibling.size < 0:
            raise ConfigError(f"'{repo_id}': the server does not say how long {sibling.rfilename!r} is: not pulled")
        sha256 = sibling.lfs.sha256 if sibling.lfs is not None else None
        files.append(RemoteFile(path, sibling.size, sha256, sibling.blob_id))
    if not info.sha or not any(file.path == PurePosixPath("meta/info.json") for file in files):
        raise ConfigError(f"'{repo_id}' is not a LeRobot dataset: it has no meta/info.json")
    if len(files) > MOST_FILES:
        raise ConfigError(f"'{repo_id}' has {len(files)} files, more than {MOST_FILES}: not pulled")
    return info.sha, files


def _check_space(folder: Path, files: Sequence[RemoteFile]) -> None:
    needed, free = sum(file.size for file in files), shutil.disk_usage(folder).free
    if needed > free:
        raise ConfigError(f"{folder}: the dataset needs {needed / 1e9:.1f} GB, {free / 1e9:.1f} GB are free")


def download(
    api: HfApi,
    repo_id: str,
    commit: str,
    files: Sequence[RemoteFile],
    folder: Path,
    on_progress: OnProgress | None,
    repo_type: str,
) -> None:
    """Fetches what is not there yet, and checks each file. Raises ConfigError, and what `huggingface_hub` raises."""
    from huggingface_hub.utils.tqdm import are_progress_bars_disabled, disable_progress_bars, enable_progress_bars

    def fetch(file: RemoteFile) -> int:
        local = folder / file.path
        if not local.is_file() or not _is(local, file):
            local.unlink(missing_ok=True)
            api.hf_hub_download(repo_id, str(file.path), repo_type=repo_type, revision=commit, local_dir=folder)
            if not _is(local, file):
                local.unlink(missing_ok=True)
                raise ConfigError(f"{file.path} of '{repo_id}' did not arrive as the server announced it: pull again")
        return file.size

    total, done = max(1, sum(file.size for file in files)), 0
    were_disabled = are_progress_bars_disabled()
    disable_progress_bars()  # one for each of many files, all at once, tell little
    pool = ThreadPoolExecutor(DOWNLOADS_AT_ONCE)
    try:
        for fetched in as_completed([pool.submit(fetch, file) for file in files]):
            done += fetched.result()
            if on_progress is not None:
                on_progress(done / total)
    finally:
        pool.shutdown(cancel_futures=True)
        if not were_disabled:
            enable_progress_bars()


def _is(path: Path, file: RemoteFile) -> bool:
    """Whether a file has the announced size and content."""
    if path.is_symlink() or path.stat().st_size != file.size:
        return False
    with path.open("rb") as content:
        if file.sha256 is not None:
            return hashlib.file_digest(content, "sha256").hexdigest() == file.sha256
        if file.git_sha1 is not None:
            digest = hashlib.sha1(b"blob %d\0" % file.size, usedforsecurity=False)
            while part := content.read(2**20):
                digest.update(part)
            return digest.hexdigest() == file.git_sha1
    return True


def _keep_only(folder: Path, files: Sequence[RemoteFile]) -> None:
    """Removes what an earlier attempt at another revision has left, and the notes of the downloader."""
    shutil.rmtree(folder / ".cache", ignore_errors=True)
    wanted = {folder / file.path for file in files}
    for path in sorted(folder.rglob("*"), reverse=True):  # what is inside a folder comes before it
        if path.is_symlink() or (path.is_file() and path not in wanted):
            path.unlink()
        elif path.is_dir() and not any(path.iterdir()):
            path.rmdir()
