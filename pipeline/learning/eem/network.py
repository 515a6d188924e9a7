"""Equivariant message passing on a robot's points: a conditional variational autoencoder.

Limoyo, Maric, Giamou, Alexson, Petrovic and Kelly, *Euclidean Equivariant Models for Generative
Graphical Inverse Kinematics*, 2023, after their *Generative Graphical Inverse Kinematics*. Layers
are those of Satorras, Hoogeboom and Welling, *E(n) Equivariant Graph Neural Networks*, ICML 2021.
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import silu

from pipeline.learning.eem.config import EemModel
from pipeline.learning.eem.geometry import PointGraph
from pipeline.learning.networks import SamplingNetwork, perceptron
from robots import Robot

GRAPHS = 512  # of one pass when draws are made: each has some hundred edges
KINDS = 9  # values of `PointGraph.kinds`
LEAST_LOG_SCALE, LARGEST_LOG_SCALE = -6.0, 3.0


class Normals(NamedTuple):
    """Normal distributions of latents (N, U, latent)."""

    mean: Tensor
    log_scale: Tensor


class EquivariantLayer(nn.Module):
    """Messages of all pairs of points, which change features and move points along differences.

    Turned, mirrored or shifted points give the same features and points turned, mirrored or shifted
    alike. The first layer of the messages is a sum over sender, receiver and edge, so that it costs
    a product a point and not one a pair. Moves are summed over the other points, not averaged: a
    point goes where a few of them say, and an average over twenty would ask for weights of twenty.

    Args:
        width: Features of a point, and neurons.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.receiver = nn.Linear(width, width)
        self.sender = nn.Linear(width, width, bias=False)
        self.edge = nn.Linear(3, width, bias=False)  # whether constant, that distance, now
        self.second = nn.Linear(width, width)
        self.move = nn.Linear(width, 1, bias=False)
        self.update = perceptron([2 * width, width, width], nn.SiLU)
        nn.init.xavier_uniform_(self.move.weight, gain=0.1)

    def forward(
        self, features: Tensor, points: Tensor, edges: Tensor, movable: Tensor | None
    ) -> tuple[Tensor, Tensor]:
        """Return features (N, P, width) and points (N, P, 3), moved where ``movable`` (P, 1).

        With None points stay, and no move is computed.
        """
        others = points.shape[1] - 1
        difference = points.unsqueeze(2) - points.unsqueeze(1)
        distance = (difference.square().sum(dim=3, keepdim=True) + 1e-8).sqrt()
        edge = torch.cat((edges.expand(len(points), -1, -1, -1), distance), dim=3)
        pairs = self.receiver(features).unsqueeze(2) + self.sender(features).unsqueeze(1)
        messages = silu(self.second(silu(pairs + self.edge(edge))))
        gathered = messages.sum(dim=2) / others
        features = features + self.update(torch.cat((features, gathered), dim=2))
        if movable is None:
            return features, points
        pull = (self.move(messages) / (distance + 1)).squeeze(3)
        # The sum of pull (x_i - x_j) over j, without an array of all pairs in space.
        step = pull.sum(dim=2, keepdim=True) * points - pull @ points
        return features, points + movable * step


class EquivariantStack(nn.Module):
    """Layers one behind the other.

    Args:
        inputs: Features that a point comes with.
        width: Features of a point in between.
        layers: Layers.
    """

    def __init__(self, inputs: int, width: int, layers: int) -> None:
        super().__init__()
        self.entry = nn.Linear(inputs, width)
        self.layers = nn.ModuleList(EquivariantLayer(width) for _ in range(layers))

    def forward(
        self, features: Tensor, points: Tensor, edges: Tensor, movable: Tensor | None
    ) -> tuple[Tensor, Tensor]:
        """Return features (N, P, width) and points (N, P, 3) behind the last layer."""
        values = self.entry(features)
        for layer in self.layers:
            values, points = layer(values, points, edges, movable)
        return values, points


class Eem(SamplingNetwork):
    """Encoder, prior and decoder, whose weights have the same shapes for every robot.

    Args:
        robot: The robot.
        model: Features of a point (`width`), layers, latents of a point.
    """

    def __init__(self, robot: Robot, model: EemModel) -> None:
        graph = PointGraph(robot)
        super().__init__(robot, normals=len(graph.unknown) * model.latent)
        self.graph, self.latent = graph, model.latent
        self.reconstruction_weight = model.reconstruction_weight
        sizes = (model.width, model.layers)
        self.encoder = EquivariantStack(KINDS, *sizes)
        self.prior = EquivariantStack(KINDS, *sizes)
        self.decoder = EquivariantStack(KINDS + model.latent, *sizes)
        self.posterior_exit = nn.Linear(model.width, 2 * model.latent)
        self.prior_exit = nn.Linear(model.width, 2 * model.latent)

    def priors(self, given: Tensor) -> Normals:
        """Return the latents' distribution given the points of poses, `PointGraph.given`."""
        return self._normals(self.prior, self.prior_exit, given)

    def posteriors(self, points: Tensor) -> Normals:
        """Return the latents' distribution given all points (N, P, 3)."""
        return self._normals(self.encoder, self.posterior_exit, points)

    def decoded(self, given: Tensor, latents: Tensor) -> Tensor:
        """Return points (N, P, 3): those that poses determine as they are, others as decoded.

        Args:
            given: (N, P, 3), see `PointGraph.given`.
            latents: (N, U, latent) of the points that poses do not determine.
        """
        every = given.new_zeros(len(given), self.graph.count, self.latent)
        every = every.index_copy(1, self.graph.unknown, latents)
        kinds = self.graph.kinds.expand(len(given), -1, -1)
        features = torch.cat((kinds, every), dim=2)
        movable = (self.graph.fixed == 0).float().unsqueeze(1)
        _, points = self.decoder(features, given, self.graph.edges, movable)
        return points

    def draws(self, poses: Tensor, latents: Tensor) -> Tensor:
        """See `SamplingNetwork.draws`."""
        count = latents.shape[1]
        given = self.graph.given(poses)
        prior = self.priors(given)
        shape = (len(poses), count, *prior.mean.shape[1:])
        normals = latents.to(poses.device).expand(len(poses), -1, -1).reshape(shape)
        drawn = prior.mean.unsqueeze(1) + prior.log_scale.exp().unsqueeze(1) * normals
        graphs = given.repeat_interleave(count, dim=0).split(GRAPHS)
        parts = zip(graphs, drawn.flatten(0, 1).split(GRAPHS), strict=True)
        joints = torch.cat([self.graph.joints(self.decoded(*part)) for part in parts])
        return self.inside(self.unit(joints)).unflatten(0, (len(poses), count))

    def _normals(self, stack: EquivariantStack, last: nn.Linear, points: Tensor) -> Normals:
        kinds = self.graph.kinds.expand(len(points), -1, -1)
        features, _ = stack(kinds, points, self.graph.edges, None)
        mean, log_scale = last(features[:, self.graph.unknown]).chunk(2, dim=2)
        return Normals(mean, log_scale.clamp(LEAST_LOG_SCALE, LARGEST_LOG_SCALE))


def divergence(of: Normals, other: Normals) -> Tensor:
    """Return the Kullback-Leibler divergences (N,) of normal distributions (N, U, latent)."""
    ratio = of.log_scale - other.log_scale
    moved = (of.mean - other.mean) * torch.exp(-other.log_scale)
    return (0.5 * (torch.exp(2 * ratio) + moved.square() - 1) - ratio).sum(dim=(1, 2))
