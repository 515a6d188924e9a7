"""`demo`: a robot solves, plans and grasps with the networks that come with the project."""

from __future__ import annotations

import os
import sys
import time
import webbrowser

from pipeline.commands.arguments import command_parser, flag, split_keys, with_defaults
from pipeline.config import compose
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import run_stage

DESCRIPTION = """\
demo [robot=nicol] [open=false] [key=value ...]

Three minutes: solves a thousand poses with five solvers, plans twenty motions, grasps an object in
simulation and films it, and puts all of it on one page, with the networks that come with the
project (conf/profile/demo.yaml). The page is opened where there is a display.
"""
STAGES = (
    ("evaluate", "a thousand poses, five solvers"),
    ("plan", "twenty Bezier motions, three solvers"),
    ("grasp", "one object, picked and dropped, filmed"),
    ("report", "tables, figures and the page"),
)


def demo(arguments: list[str]) -> int:
    """Run the stages, say what each took, and open the page."""
    given = command_parser("demo", DESCRIPTION).takes_overrides().parse(arguments).overrides
    own, overrides = split_keys(given, ("open",))
    opens = flag("open", own.get("open", "true"))
    config = compose(["profile=demo", *with_defaults(overrides, {"robot": "nicol"})])
    for number, (stage, what) in enumerate(STAGES, start=1):
        began = time.monotonic()
        print(f"{number}/{len(STAGES)}  {stage:<9} {what}", file=sys.stderr, flush=True)
        run_stage(stage, config)
        print(f"     {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    folders = artifacts(config)
    films = sorted(folders.grasp(config.robot.name).glob("*.mp4"))
    page = folders.root / "report.html"
    for path in (*films, page):
        print(path)
    if opens and has_display():
        webbrowser.open(page.as_uri())
    return 0


def has_display() -> bool:
    """Whether a browser's window would be seen."""
    return sys.platform != "linux" or any(os.environ.get(k) for k in ("DISPLAY", "WAYLAND_DISPLAY"))
