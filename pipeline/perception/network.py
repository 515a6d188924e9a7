"""A small centre-point network (X. Zhou, D. Wang, P. Kraehenbuehl, Objects as Points, 2019)."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from pipeline.perception.config import NetworkConfig

REGRESSED = 6  # du, dv of the centroid, then left, top, right, bottom from the centroid to the box


class CentreNetwork(nn.Module):
    """Where the centres of objects are, cell by cell.

    An encoder halves the picture four times; what the coarsest level has seen of the surroundings
    is added to the level of an eighth, from which everything is read.

    Attributes:
        names: Classes, in the order of the heat maps.
        config: Size of the network.
    """

    def __init__(self, names: tuple[str, ...], config: NetworkConfig) -> None:
        """Make the layers.

        Args:
            names: Classes.
            config: Size of input and layers.
        """
        super().__init__()
        self.names, self.config = tuple(names), config
        half, quarter, eighth, sixteenth = config.channels
        self.fine = nn.Sequential(
            _layer(3, half, 2),
            _layer(half, quarter, 2),
            _layer(quarter, quarter),
            _layer(quarter, eighth, 2),
            _layer(eighth, eighth),
            _layer(eighth, eighth),
        )
        self.coarse = nn.Sequential(
            _layer(eighth, sixteenth, 2),
            _layer(sixteenth, sixteenth),
            _layer(sixteenth, sixteenth),
            nn.Conv2d(sixteenth, eighth, 1),
        )
        self.head = nn.Sequential(
            _layer(eighth, eighth),
            _layer(eighth, eighth),
            nn.Conv2d(eighth, len(names) + REGRESSED, 1),
        )
        last = self.head[-1]
        assert isinstance(last, nn.Conv2d) and last.bias is not None
        nn.init.zeros_(last.bias)
        nn.init.constant_(last.bias[: len(names)], -4.0)  # rare at first: 0.02, cf. focal loss

    def forward(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """Read pictures.

        Args:
            images: (N, 3, height, width), 0 to 1.

        Returns:
            Logits of a centre (N, classes, height / 8, width / 8), and the centroid from the middle
            of the cell and the sides of the box from the centroid, all in cells, (N, 6, ...).
        """
        fine = self.fine(2.0 * images - 1.0)
        coarse = functional.interpolate(self.coarse(fine), scale_factor=2.0, mode="nearest")
        answer = self.head(fine + coarse)
        return answer[:, : len(self.names)], answer[:, len(self.names) :]


def _layer(inputs: int, outputs: int, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )
