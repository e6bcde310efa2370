"""Room for deep recursion: code nested a thousand deep is translated and compiled by functions that call themselves."""

import sys
import threading
from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")

STACK = 1 << 29  # bytes; only what is used is ever taken from memory. Clang needs some 10 kB a level
FRAMES = 50_000  # calls of Python inside each other: three to six a level
_lock = threading.Lock()  # stack size and limit of recursion are one for all threads
_running = 0
_usual = sys.getrecursionlimit()


def with_deep_stack(function: Callable[..., T], *arguments: Any) -> T:
    """What the function gives, called in a thread with a large stack; what it raises is raised here."""
    given: list[T] = []
    raised: list[BaseException] = []

    def run() -> None:
        try:
            given.append(function(*arguments))
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run, name="sdfprt deep stack", daemon=True)
    _widen(thread)
    try:
        thread.join()
    finally:
        _narrow()
    if raised:
        raise raised[0]
    return given[0]


def _widen(thread: threading.Thread) -> None:
    """Start a thread with the large stack, and let Python go as deep."""
    global _running, _usual
    with _lock:
        if _running == 0:
            _usual = sys.getrecursionlimit()
            sys.setrecursionlimit(max(FRAMES, _usual))
        before = threading.stack_size(STACK)
        try:
            thread.start()
        finally:
            threading.stack_size(before)
        _running += 1


def _narrow() -> None:
    """Python's usual limit again, once no thread needs the other."""
    global _running
    with _lock:
        _running -= 1
        if _running == 0:
            sys.setrecursionlimit(_usual)
