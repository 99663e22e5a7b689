"""Pool of local worker processes, each a new interpreter that neither forks nor runs the main script.

The pools of the standard library either fork, which a process with running threads (MKL, OpenMP) must not do, or run
the main script again in every worker, which needs a ``__main__`` guard and fails from standard input. Here a worker is
``python -c`` that reads tasks from its standard input and writes replies, so that it ends with its parent in any case.

Serialised scenes and cases for other processes, and the function that solves them there.

A scene is sent without factors (`Model.__getstate__`) but with the inverse of its condensed stiffness. A process keeps
the last scene, so that further cases are sent alone; a process without the scene requests it.
"""

from __future__ import annotations

import io
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from queue import SimpleQueue
from types import FunctionType
from typing import IO, Any

from fecontact.bodies.body import Body
from fecontact.common.errors import FecontactError, InputError
from fecontact.contact.model import SceneModel
from fecontact.scene.local_search import SearchHistory
from fecontact.scene.sweep_case import Solved, solved_case

#: Environment variables for the number of threads of the numerical libraries.
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")

_START = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from fecontact.scene.workers import serve; serve()"


class FreshInterpreters(Executor):
    """An executor whose workers are separate interpreters.

    They share the cores: by default each of n workers starts cores / n threads. Submitted functions must be importable;
    those of the main script are not.

    Parameters
    ----------
    workers : int

    Examples
    --------
    >>> import math
    >>> with FreshInterpreters(1) as pool:
    ...     pool.submit(math.hypot, 3.0, 4.0).result()
    5.0
    """

    def __init__(self, workers: int) -> None:
        if not sys.executable:
            raise InputError(
                "Several processes need a Python interpreter to start (sys.executable); leave processes=1."
            )
        self._environment = os.environ | {
            name: str(max(1, (os.cpu_count() or 1) // workers)) for name in THREADS if name not in os.environ
        }
        self._own = threading.local()
        self._started: list[subprocess.Popen[bytes]] = []
        self._threads = ThreadPoolExecutor(workers, "fecontact-worker")

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call a function in a worker."""
        return self._threads.submit(self._asked, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers after the submitted tasks."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        if wait:
            for process in self._started:
                _close(process)

    def __exit__(self, kind: Any, value: Any, trace: Any) -> None:
        if kind is not None:
            # running tasks are no longer awaited
            for process in self._started:
                process.kill()
        self.shutdown(cancel_futures=kind is not None)

    def _asked(self, fn: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        """Reply of this thread's own worker."""
        if not hasattr(self._own, "process"):
            self._own.process = self._start()
        process = self._own.process
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            _write(process.stdin, pickle.dumps((fn, args, kwargs)))
            reply = _read(process.stdout)
        except (BrokenPipeError, EOFError):
            code = process.wait()
            raise FecontactError(
                f"A worker process has ended (exit {code}) before its task was done; if it was killed for lack of "
                "memory, use fewer processes.",
                code="worker-ended",
            ) from None
        good, value = pickle.loads(reply)
        if good:
            return value
        raise value

    def _start(self) -> subprocess.Popen[bytes]:
        path = json.dumps([entry for entry in sys.path if isinstance(entry, str)])
        process = subprocess.Popen(
            [sys.executable, "-c", _START, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=self._environment
        )
        self._started.append(process)
        return process


def _close(process: subprocess.Popen[bytes]) -> None:
    for pipe in (process.stdin, process.stdout):
        assert pipe is not None
        with suppress(OSError):  # the worker has ended with unread input
            pipe.close()
    process.wait()


def serve() -> None:
    """Run tasks from standard input in turn until it ends; then exit at once."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # interrupts are handled by the parent
    tasks, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    # output and input of libraries must not mix with the messages
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)
    waiting: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_listen, args=(tasks, waiting), daemon=True).start()
    while True:
        _write(replies, _reply(waiting.get()))


def _listen(tasks: IO[bytes], waiting: SimpleQueue[bytes]) -> None:
    try:
        while True:
            waiting.put(_read(tasks))
    except EOFError:
        os._exit(0)


def _reply(task: bytes) -> bytes:
    try:
        fn, args, kwargs = pickle.loads(task)
        return pickle.dumps((True, fn(*args, **kwargs)))
    except BaseException as error:
        if not isinstance(error, FecontactError):
            error.add_note(f"In a worker process:\n{traceback.format_exc()}")
        try:
            return pickle.dumps((False, error))
        except Exception:
            return pickle.dumps((False, RuntimeError(traceback.format_exc())))


def _write(pipe: IO[bytes], data: bytes) -> None:
    pipe.write(len(data).to_bytes(8, "little"))
    pipe.write(data)
    pipe.flush()


def _read(pipe: IO[bytes]) -> bytes:
    size = int.from_bytes(_exactly(pipe, 8), "little")
    return _exactly(pipe, size)


def _exactly(pipe: IO[bytes], size: int) -> bytes:
    data = pipe.read(size)
    if len(data) < size:
        raise EOFError
    return data


REMEDY = (
    "Define it in a module that other processes can import (not in the main script, a notebook or by lambda), or "
    "leave out processes= and executor=."
)

#: Last scene sent to this thread and its search history, with the scene's token.
_KEPT = threading.local()


class _Pickler(pickle.Pickler):
    """Bodies known to the receiver are sent as numbers; objects of the main script are refused."""

    def __init__(self, file: io.BytesIO, bodies: Sequence[Body]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._numbers = {id(body): k for k, body in enumerate(bodies)}

    def persistent_id(self, thing: Any) -> int | None:
        return self._numbers.get(id(thing))

    def reducer_override(self, thing: Any) -> Any:
        if isinstance(thing, (FunctionType, type)) and thing.__module__ == "__main__":
            raise pickle.PicklingError(f"{thing.__qualname__} is defined in the main script")
        return NotImplemented


class _Unpickler(pickle.Unpickler):
    def __init__(self, data: bytes, bodies: Sequence[Body]) -> None:
        super().__init__(io.BytesIO(data))
        self._bodies = bodies

    def persistent_load(self, number: int) -> Body:
        return self._bodies[number]


def _packed(thing: Any, bodies: Sequence[Body] = ()) -> bytes:
    _Pickler(file := io.BytesIO(), bodies).dump(thing)
    return file.getvalue()


def packed_scene(scene: SceneModel, history: SearchHistory) -> bytes:
    """Scene and search history as bytes.

    Raises
    ------
    InputError
        If it cannot be sent; the message names the body.
    """
    try:
        return _packed((scene, history))
    except Exception as error:
        for body in scene.bodies:
            try:
                _packed(body)
            except Exception as its:
                raise InputError(f"The body {body.name!r} cannot be sent to other processes: {its}. {REMEDY}") from its
        raise InputError(f"The scene cannot be sent to other processes: {error}. {REMEDY}") from error


def packed_case(name: str, case: Mapping[str, Any], bodies: Sequence[Body]) -> bytes:
    """Case as bytes, for a receiver that has its scene.

    Raises
    ------
    InputError
        If it cannot be sent.
    """
    try:
        return _packed(dict(case), bodies)
    except Exception as error:
        raise InputError(f"The case {name!r} cannot be sent to other processes: {error}. {REMEDY}") from error


def solved_there(token: str, case: bytes, scene: bytes | None = None) -> Solved | None:
    """Row and kept fields of a case for the scene of a token; None if the scene is neither sent nor kept."""
    if getattr(_KEPT, "token", None) != token:
        if scene is None:
            return None
        _KEPT.scene, _KEPT.history = pickle.loads(scene)
        _KEPT.token = token
    return solved_case(_KEPT.scene, _Unpickler(case, _KEPT.scene.bodies).load(), _KEPT.history)
