"""A small Hugging Face Hub on this machine: repositories, commits, tags and large files, with faults on demand."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import unquote, urlsplit

TOKEN = "hf_SecretOfTheTests"
PUBLIC = r"/(?:api/)?(?:datasets/|models/|(?!api/))([^/]+/[^/]+)(?=/(?:revision|resolve|tree)|$)"
"""What may be read without a token."""


def git_sha1(content: bytes) -> str:
    return hashlib.sha1(b"blob %d\0" % len(content) + content).hexdigest()


@dataclass
class Repo:
    private: bool = False
    commits: dict[str, dict[str, bytes]] = field(default_factory=dict)
    refs: dict[str, str] = field(default_factory=dict)

    def commit(self, files: dict[str, bytes]) -> str:
        sha = hashlib.sha1(f"{id(self)} {len(self.commits)}".encode()).hexdigest()
        self.commits[sha] = files
        self.refs["main"] = sha
        return sha

    def resolve(self, revision: str) -> str | None:
        return revision if revision in self.commits else self.refs.get(revision)

    @property
    def files(self) -> dict[str, bytes]:
        return self.commits[self.refs["main"]]


class Hub:
    """What it has, and what it does wrong."""

    def __init__(self) -> None:
        self.repos: dict[str, Repo] = {}
        self.objects: dict[str, bytes] = {}
        self.large = 10**9
        """[bytes] from which a file is sent to the store of large files"""
        self.requests: list[str] = []
        self.status: dict[str, int] = {}
        """By a pattern of `METHOD path`: what to answer instead."""
        self.break_off: dict[str, int] = {}
        """By such a pattern: how many requests are served before the connection is cut."""
        self.spoil: Callable[[str, bytes], bytes] = lambda _, content: content
        self.extra: list[dict[str, Any]] = []
        """Files that a listing names besides those that there are."""
        self.lock = threading.Lock()
        self.url = ""

    def count(self, pattern: str) -> int:
        return sum(bool(re.search(pattern, request)) for request in self.requests)


@contextmanager
def running(hub: Hub) -> Iterator[Hub]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), type("Handler", (_Handler,), {"hub": hub}))
    server.daemon_threads = True
    hub.url = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield hub
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class _Handler(BaseHTTPRequestHandler):
    hub: Hub
    protocol_version = "HTTP/1.1"
    wbufsize, disable_nagle_algorithm = -1, True  # or else each answer waits for 40 ms

    def log_message(self, *_: object) -> None:
        pass

    def _serve(self) -> None:
        path = unquote(urlsplit(self.path).path)
        request = f"{self.command} {path}"
        body = self._body()
        with self.hub.lock:
            self.hub.requests.append(request)
            for pattern, left in self.hub.break_off.items():
                if re.search(pattern, request):
                    self.hub.break_off[pattern] = left - 1
                    if left <= 0:
                        self.close_connection = True
                        self.connection.close()
                        return None
            status = next((code for pattern, code in self.hub.status.items() if re.search(pattern, request)), None)
            if status is not None:
                return self._answer(status, {"error": "as the test wants it"})
            if not path.startswith("/lfs/") and self.headers.get("authorization") != f"Bearer {TOKEN}":
                public = re.match(PUBLIC, path)
                repo = self.hub.repos.get(public[1]) if public else None
                if repo is None or repo.private:
                    return self._answer(401, {"error": "Invalid username or password."}, code="RepoNotFound")
            for pattern, method in ROUTES.items():
                if match := re.fullmatch(pattern, request):
                    return method(self, body, *match.groups())
        return self._answer(404, {"error": "not found"})

    do_GET = do_POST = do_PUT = do_HEAD = do_DELETE = _serve  # noqa: N815

    def _body(self) -> bytes:
        if self.headers.get("transfer-encoding") == "chunked":
            parts = []
            while size := int(self.rfile.readline(), 16):
                parts.append(self.rfile.read(size))
                self.rfile.readline()
            self.rfile.readline()
            return b"".join(parts)
        return self.rfile.read(int(self.headers.get("content-length") or 0))

    def _answer(self, status: int, content: Any, code: str = "", **headers: str) -> None:
        body = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), value)
        if code:
            self.send_header("X-Error-Code", code)
        if "Content_Length" not in headers:
            self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _repo(self, name: str) -> Repo | None:
        repo = self.hub.repos.get(name)
        if repo is None:
            self._answer(404, {"error": "Repository not found"}, code="RepoNotFound")
        return repo

    def create(self, body: bytes) -> None:
        wanted = json.loads(body)
        name = f"{wanted['organization']}/{wanted['name']}"
        assert wanted["type"] == "dataset"
        url = f"{self.hub.url}/datasets/{name}"
        if name in self.hub.repos:
            return self._answer(409, {"error": "exists", "url": url})
        repo = self.hub.repos[name] = Repo(wanted.get("visibility") == "private" or wanted.get("private") is True)
        repo.commit({".gitattributes": b"*.mp4 filter=lfs\n"})
        return self._answer(200, {"url": url, "name": name})

    def validate_yaml(self, _: bytes) -> None:
        self._answer(200, {"warnings": [], "errors": []})

    def preupload(self, body: bytes, name: str) -> None:
        if repo := self._repo(name):
            files = []
            for file in json.loads(body)["files"]:
                large = file["size"] >= self.hub.large
                known = repo.files.get(file["path"])
                digest = None
                if known is not None:
                    digest = hashlib.sha256(known).hexdigest() if large else git_sha1(known)
                mode = "lfs" if large else "regular"
                files.append({"path": file["path"], "uploadMode": mode, "shouldIgnore": False, "oid": digest})
            self._answer(200, {"files": files})

    def batch(self, body: bytes, name: str) -> None:
        if self._repo(name):
            objects = []
            for wanted in json.loads(body)["objects"]:
                answer: dict[str, Any] = {"oid": wanted["oid"], "size": wanted["size"]}
                if wanted["oid"] not in self.hub.objects:
                    href = f"{self.hub.url}/lfs/{wanted['oid']}"
                    answer["actions"] = {"upload": {"href": href}, "verify": {"href": f"{href}/verify"}}
                objects.append(answer)
            self._answer(200, {"transfer": "basic", "objects": objects})

    def put(self, body: bytes, oid: str) -> None:
        assert hashlib.sha256(body).hexdigest() == oid
        self.hub.objects[oid] = body
        self._answer(200, {})

    def verify(self, body: bytes, oid: str) -> None:
        self._answer(200 if len(self.hub.objects[oid]) == json.loads(body)["size"] else 400, {})

    def commit(self, body: bytes, name: str) -> None:
        if repo := self._repo(name):
            files = dict(repo.files)
            for line in body.splitlines():
                entry = json.loads(line)
                value = entry["value"]
                if entry["key"] == "file":
                    files[value["path"]] = base64.b64decode(value["content"])
                elif entry["key"] == "lfsFile":
                    files[value["path"]] = self.hub.objects[value["oid"]]
                elif entry["key"] == "deletedFile":
                    del files[value["path"]]
            sha = repo.commit(files)
            self._answer(200, {"commitUrl": f"{self.hub.url}/datasets/{name}/commit/{sha}", "commitOid": sha})

    def tag(self, body: bytes, name: str, revision: str) -> None:
        if repo := self._repo(name):
            repo.refs[json.loads(body)["tag"]] = repo.refs[revision]
            self._answer(200, {})

    def untag(self, _: bytes, name: str, tag: str) -> None:
        if repo := self._repo(name):
            if repo.refs.pop(tag, None) is None:
                return self._answer(404, {"error": "no such tag"}, code="RevisionNotFound")
            self._answer(200, {})
        return None

    def info(self, _: bytes, name: str, revision: str | None = None) -> None:
        if repo := self._repo(name):
            sha = repo.resolve(revision or "main")
            if sha is None:
                return self._answer(404, {"error": "Invalid rev id"}, code="RevisionNotFound")
            siblings = [self._sibling(path, content) for path, content in repo.commits[sha].items()]
            listing = [*siblings, *self.hub.extra]
            self._answer(200, {"id": name, "sha": sha, "private": repo.private, "siblings": listing, "tags": []})
        return None

    def _sibling(self, path: str, content: bytes) -> dict[str, Any]:
        known: dict[str, Any] = {"rfilename": path, "size": len(content), "blobId": git_sha1(content)}
        if len(content) >= self.hub.large:
            sha256 = hashlib.sha256(content).hexdigest()
            known |= {"blobId": "0" * 40, "lfs": {"sha256": sha256, "size": len(content), "pointerSize": 130}}
        return known

    def tree(self, _: bytes, name: str, revision: str) -> None:
        if repo := self._repo(name):
            files = repo.commits[repo.resolve(revision) or ""]
            found = [
                {"type": "file", "path": path, "size": len(content), "oid": git_sha1(content)}
                for path, content in files.items()
            ]
            self._answer(200, found)

    def download(self, _: bytes, name: str, revision: str, path: str) -> None:
        if repo := self._repo(name):
            sha = repo.resolve(revision)
            if sha is None or path not in repo.commits[sha]:
                return self._answer(404, {"error": "Entry not found"}, code="EntryNotFound")
            content = self.hub.spoil(path, repo.commits[sha][path])
            etag = f'"{git_sha1(repo.commits[sha][path])}"'
            start = int((self.headers.get("range") or "bytes=0-")[6:].partition("-")[0])
            part = content[start:]
            extra = {"Content_Range": f"bytes {start}-{len(content) - 1}/{len(content)}"} if start else {}
            self._answer(206 if start else 200, part, X_Repo_Commit=sha, ETag=etag, **extra)
        return None


REPO = "([^/]+/[^/]+)"
ROUTES: dict[str, Callable[..., None]] = {
    "POST /api/repos/create": _Handler.create,
    "POST /api/validate-yaml": _Handler.validate_yaml,
    f"POST /api/datasets/{REPO}/preupload/main": _Handler.preupload,
    f"POST /datasets/{REPO}\\.git/info/lfs/objects/batch": _Handler.batch,
    "PUT /lfs/([0-9a-f]+)": _Handler.put,
    "POST /lfs/([0-9a-f]+)/verify": _Handler.verify,
    f"POST /api/datasets/{REPO}/commit/main": _Handler.commit,
    f"POST /api/datasets/{REPO}/tag/(.+)": _Handler.tag,
    f"DELETE /api/datasets/{REPO}/tag/(.+)": _Handler.untag,
    f"GET /api/datasets/{REPO}": _Handler.info,
    f"GET /api/datasets/{REPO}/revision/(.+)": _Handler.info,
    f"GET /api/datasets/{REPO}/tree/(.+)": _Handler.tree,
    f"GET /api/models/{REPO}": _Handler.info,
    f"GET /api/models/{REPO}/revision/(.+)": _Handler.info,
    f"(?:GET|HEAD) /{REPO}/resolve/([^/]+)/(.+)": _Handler.download,
    f"(?:GET|HEAD) /datasets/{REPO}/resolve/([^/]+)/(.+)": _Handler.download,
}
