"""The card of pose sets in Croissant, the JSON-LD format in which data sets are found and loaded.

Croissant Format Specification 1.0 (MLCommons, 2024), http://mlcommons.org/croissant/1.0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pipeline.data.dataset import POSE_COLUMNS, joint_columns

if TYPE_CHECKING:
    from robots import Robot

CROISSANT = "croissant.json"
VERSION = "1.0.0"  # of what the columns are
LICENCE = "https://opensource.org/license/mit"
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
CITE = (
    "J.-G. Habekost, C. Gäde, P. Allgeuer, S. Wermter: Inverse Kinematics for Neuro-Robotic "
    "Grasping with Humanoid Embodied Agents. IROS 2024. Poses: cycleik-bench."
)


def croissant(card: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    """Describe the pose sets of a robot in Croissant.

    Args:
        card: Of the pose sets, with ``splits`` and ``files``.
        robot: Whose they are.
    """
    splits, tip = card["splits"], robot.description.tip
    described = _columns(robot)
    return {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": f"cycleik-bench-{robot.name}",
        "description": (
            f"Reachable poses of link {tip} of the robot {robot.name} in the frame of "
            f"{robot.description.base}, and the joint configurations that they were made from by "
            "forward kinematics: uniform within the joint limits, free of self-collision; "
            + ", ".join(f"{facts['poses']} for {name}" for name, facts in splits.items())
            + "."
        ),
        "version": VERSION,
        "license": LICENCE,
        "citeAs": CITE,
        "isLiveDataset": False,
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": f"{split}.parquet",
                "name": f"{split}.parquet",
                "contentUrl": f"{split}.parquet",
                "encodingFormat": "application/x-parquet",
                "sha256": card["files"][f"{split}.parquet"],
            }
            for split in splits
        ],
        "recordSet": [_records(split, described) for split in splits],
    }


def _records(split: str, described: Sequence[tuple[str, str]]) -> dict[str, Any]:
    fields = [
        {
            "@type": "cr:Field",
            "@id": f"{split}/{column}",
            "name": f"{split}/{column}",
            "description": text,
            "dataType": "sc:Float",
            "source": {
                "fileObject": {"@id": f"{split}.parquet"},
                "extract": {"column": column},
            },
        }
        for column, text in described
    ]
    return {"@type": "cr:RecordSet", "@id": split, "name": split, "field": fields}


def _columns(robot: Robot) -> list[tuple[str, str]]:
    """Columns of a split and what they are."""
    what = f"of {robot.description.tip} in the frame of {robot.description.base}"
    texts = [f"position {what}, {axis} [m]" for axis in "xyz"]
    texts += [f"unit quaternion {what}, {part}; w is not negative" for part in "wxyz"]
    units = ["m" if slides else "rad" for slides in robot.sliding]
    texts += [f"joint {name} [{unit}]" for name, unit in zip(robot.joint_names, units, strict=True)]
    return list(zip([*POSE_COLUMNS, *joint_columns(robot)], texts, strict=True))
