"""A line on stderr where kernels are compiled, and none where they are not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numba import njit

from robots import compile_notice
from robots.compile_notice import CompileNotice


def compiling(module: str) -> Any:
    function = SimpleNamespace(__module__=module)
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function)})


def seconds(monkeypatch: pytest.MonkeyPatch, times: list[float]) -> None:
    monkeypatch.setattr(compile_notice.time, "monotonic", lambda: times.pop(0))


def test_a_line_comes_after_a_second_and_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    notice = CompileNotice()
    kernel, inner = compiling("robots.kinematics"), compiling("numba.np")
    seconds(monkeypatch, [0.0, 0.1, 0.2, 0.3, 2.0, 3.0, 4.0, 5.0, 9.0])
    notice.on_start(kernel)
    notice.on_start(inner)
    notice.on_end(inner)
    assert capsys.readouterr().err == ""
    notice.on_end(kernel)
    assert capsys.readouterr().err == "compiling kernels, once: some seconds each\n"
    notice.on_start(kernel)
    notice.on_end(kernel)
    assert capsys.readouterr().err == ""


def test_a_terminal_sees_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    notice = CompileNotice()
    kernel, inner = compiling("robots.kinematics"), compiling("robots.frames")
    seconds(monkeypatch, [0.0, 0.0, 0.5, 3.2, 5.8])
    for event in (kernel, inner):
        notice.on_start(event)
    for event in (inner, kernel):
        notice.on_end(event)
    said = capsys.readouterr().err
    assert "\rcompiling kernels, once: 1 functions, 3 s" in said
    assert said.endswith("2 functions, 6 s \n")


@pytest.mark.parametrize("silent", [True, False])
def test_kernels_of_others_and_silent_workers_say_nothing(
    silent: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    notice = CompileNotice()
    notice.silent = silent
    event = compiling("robots.frames" if silent else "ssik.solvers")
    seconds(monkeypatch, [0.0, 5.0, 10.0, 15.0])
    notice.on_start(event)
    notice.on_end(event)
    assert capsys.readouterr().err == ""


def test_numba_calls_it(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []
    compile_notice.announce_compiling()
    monkeypatch.setattr(CompileNotice, "on_start", lambda self, event: seen.append(event))
    monkeypatch.setattr(CompileNotice, "on_end", lambda self, event: None)
    njit(lambda x: x + 1)(np.float64(1.0))
    assert len(seen) >= 1
