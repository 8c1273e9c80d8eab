"""The pin model: a small convolutional network with three heads, one for each size of pin.

Plain 3x3 and 1x1 convolutions with ReLU and nearest-neighbour upsampling: every inference engine has them, OpenCV 4.6's
included, and INT8 quantisation takes them well.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

STRIDES = (8, 16, 32)
WIDTH, HEIGHT = 320, 256
PRIOR = 0.01
"""Score of every cell before training, as in Lin and others, *Focal loss for dense object detection*, 2017."""


def conv(inputs: int, outputs: int, size: int = 3, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False),
        nn.BatchNorm2d(outputs, momentum=0.05),
        nn.ReLU(inplace=True),
    )


class Residual(nn.Module):
    def __init__(self, channels: int) -> None:
        super().__init__()
        self.body = nn.Sequential(conv(channels, channels // 2, 1), conv(channels // 2, channels, 3))

    def forward(self, x: Tensor) -> Tensor:
        return x + self.body(x)


class Head(nn.Module):
    """(logit, l, t, r, b): distances from the cell's centre to the box's edges in strides, never negative."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.body = conv(channels, channels)
        self.score = nn.Conv2d(channels, 1, 1)
        self.edges = nn.Conv2d(channels, 4, 1)
        nn.init.constant_(self.score.bias, -torch.log(torch.tensor((1 - PRIOR) / PRIOR)).item())  # type: ignore[arg-type]
        nn.init.constant_(self.edges.bias, 2.0)  # type: ignore[arg-type]
        nn.init.normal_(self.edges.weight, std=0.01)

    def forward(self, x: Tensor) -> Tensor:
        x = self.body(x)
        edges = self.edges(x)
        # A slope below zero keeps a gradient while training; the exported model has the plain ReLU.
        edges = nn.functional.leaky_relu(edges, 0.1) if self.training else torch.relu(edges)
        return torch.cat([self.score(x), edges], 1)


class PinNet(nn.Module):
    """Input (N, 3, 256, 320) RGB 0..1; outputs one (N, 5, 256 / s, 320 / s) for each stride s."""

    def __init__(self, width: int = 64) -> None:
        super().__init__()
        self.stem = nn.Sequential(conv(3, 16, 3, 2), conv(16, 24, 3, 2), Residual(24))
        self.stage8 = nn.Sequential(conv(24, 48, 3, 2), Residual(48), Residual(48))
        self.stage16 = nn.Sequential(conv(48, 96, 3, 2), Residual(96), Residual(96))
        self.stage32 = nn.Sequential(conv(96, 128, 3, 2), Residual(128), Residual(128))
        self.side8, self.side16, self.side32 = conv(48, width, 1), conv(96, width, 1), conv(128, width, 1)
        self.up = nn.Upsample(scale_factor=2, mode="nearest")
        self.heads = nn.ModuleList(Head(width) for _ in STRIDES)

    def forward(self, x: Tensor) -> list[Tensor]:
        c8 = self.stage8(self.stem(x))
        c16 = self.stage16(c8)
        p32 = self.side32(self.stage32(c16))
        p16 = self.side16(c16) + self.up(p32)
        p8 = self.side8(c8) + self.up(p16)
        return [head(p) for head, p in zip(self.heads, (p8, p16, p32))]
