"""What the centre-point network is to say of a labelled picture, and how far it is from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from pipeline.perception.config import STRIDE
from pipeline.perception.network import REGRESSED
from pipeline.perception.studio import Label

Array = NDArray[np.float32]
AROUND = (-1, 0, 1)  # cells about the centre that must know the offsets too


@dataclass(frozen=True)
class Targets:
    """Targets of one picture, or stacked of many.

    Attributes:
        heat: (classes, rows, columns), 1 in the cell of a centre.
        offsets: (6, rows, columns) as the network regresses them.
        known: (rows, columns), 1 where the offsets count.
    """

    heat: Array
    offsets: Array
    known: Array


def targets_of(
    labels: list[Label],
    names: tuple[str, ...],
    size: tuple[int, int],
    scale: float,
    sigma: float,
) -> Targets:
    """Draw the targets of a picture.

    Args:
        labels: What is true.
        names: Classes, in the order of the heat maps.
        size: Width and height of the network's input [pixels].
        scale: Input pixels for each pixel of the labels.
        sigma: Standard deviation of a bump [cells].
    """
    columns, rows = size[0] // STRIDE, size[1] // STRIDE
    heat = np.zeros((len(names), rows, columns), np.float32)
    offsets = np.zeros((REGRESSED, rows, columns), np.float32)
    known = np.zeros((rows, columns), np.float32)
    nearest = np.full((rows, columns), np.inf)
    across, down = np.arange(columns) + 0.5, np.arange(rows) + 0.5
    for label in labels:
        u, v = np.array(label.centroid) * scale / STRIDE
        x0, y0, x1, y1 = np.array(label.box) * scale / STRIDE
        column, row = min(int(u), columns - 1), min(int(v), rows - 1)
        far = (across[None, :] - u) ** 2 + (down[:, None] - v) ** 2
        bump = np.exp(-0.5 * far / sigma**2)
        bump[row, column] = 1.0
        kind = names.index(label.name)
        heat[kind] = np.maximum(heat[kind], bump)
        for i in (row + step for step in AROUND):
            for j in (column + step for step in AROUND):
                if 0 <= i < rows and 0 <= j < columns and far[i, j] < nearest[i, j]:
                    nearest[i, j], known[i, j] = far[i, j], 1.0
                    shift = (u - across[j], v - down[i])
                    offsets[:, i, j] = (*shift, u - x0, v - y0, x1 - u, y1 - v)
    return Targets(heat, offsets, known)


def loss(
    logits: Tensor,
    regressed: Tensor,
    targets: tuple[Tensor, Tensor, Tensor],
    offset_weight: float,
    box_weight: float,
) -> Tensor:
    """Focal loss of the centres and absolute errors of the offsets (Zhou et al., eq. 1-3).

    Args:
        logits: (N, classes, rows, columns).
        regressed: (N, 6, rows, columns), cells.
        targets: Heat, offsets and where they are known, stacked.
        offset_weight: Of the centroid's error.
        box_weight: Of the box sides' error.

    Returns:
        A scalar: for each object, the mean over the batch.
    """
    heat, offsets, known = targets
    centre = heat.eq(1.0)
    likely = torch.sigmoid(logits)
    hit = functional.logsigmoid(logits) * (1.0 - likely) ** 2
    miss = functional.logsigmoid(-logits) * likely**2 * (1.0 - heat) ** 4
    objects = centre.sum().clamp(min=1)
    focal = -torch.where(centre, hit, miss).sum() / objects
    errors = ((regressed - offsets).abs() * known[:, None]).sum(dim=(0, 2, 3))
    cells = known.sum().clamp(min=1)
    return focal + (offset_weight * errors[:2].sum() + box_weight * errors[2:].sum()) / cells
