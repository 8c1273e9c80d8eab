"""What training makes small: scores away from the overlap they stand for, edges away from the pin's.

Quality focal loss (Li and others, *Generalized focal loss*, 2020): a cell's score learns the overlap its box reaches,
so that non-maximum suppression keeps the best box. The height has a term of its own: the range is made of it.
"""

from __future__ import annotations

import torch
from torch import Tensor

EDGE_WEIGHT, HEIGHT_WEIGHT = 2.0, 4.0
SMOOTH = 0.02


def detection_loss(outputs: list[Tensor], targets: Tensor) -> tuple[Tensor, dict[str, float]]:
    """`outputs` as the network gives them, `targets` (N, cells, 6) as `targets.assign` does."""
    flat = torch.cat([o.float().flatten(2).transpose(1, 2) for o in outputs], 1)
    state, goal = targets[..., 0], targets[..., 1:5]
    positive = state > 0.5
    count = positive.sum().clamp(min=1.0)
    edges, wanted = flat[..., 1:][positive], goal[positive]
    giou, iou = _overlap(edges, wanted)
    quality = torch.zeros_like(state)
    quality[positive] = iou.detach().clamp(0.0, 1.0)
    logit = flat[..., 0]
    score = torch.sigmoid(logit)
    weight = (quality - score).abs().pow(2.0) * (state > -0.5)
    scores = torch.nn.functional.binary_cross_entropy_with_logits(logit, quality, reduction="none")
    score_loss = (weight.detach() * scores).sum() / count
    edge_loss = (1.0 - giou).sum() / count
    height = (edges[:, 1] + edges[:, 3]).clamp(min=0.05) / (wanted[:, 1] + wanted[:, 3]).clamp(min=0.05)
    log_ratio = torch.log(height).abs()
    height_loss = (
        torch.where(log_ratio < SMOOTH, 0.5 * log_ratio**2 / SMOOTH, log_ratio - 0.5 * SMOOTH).sum() / count
    )
    total = score_loss + EDGE_WEIGHT * edge_loss + HEIGHT_WEIGHT * height_loss
    parts = {"score": score_loss.item(), "edges": edge_loss.item(), "height": height_loss.item()}
    return total, parts


def _overlap(edges: Tensor, wanted: Tensor) -> tuple[Tensor, Tensor]:
    """Generalised and plain intersection over union of boxes round the same point."""
    kept = edges.clamp(min=0.0)
    common = torch.minimum(kept[:, :2], wanted[:, :2]) + torch.minimum(kept[:, 2:], wanted[:, 2:])
    hull = torch.maximum(edges[:, :2], wanted[:, :2]) + torch.maximum(edges[:, 2:], wanted[:, 2:])
    inner = common[:, 0] * common[:, 1]
    first = (edges[:, 0] + edges[:, 2]).clamp(min=0.01) * (edges[:, 1] + edges[:, 3]).clamp(min=0.01)
    second = (wanted[:, 0] + wanted[:, 2]) * (wanted[:, 1] + wanted[:, 3])
    union = (first + second - inner).clamp(min=1e-3)
    iou = inner / union
    outer = (hull[:, 0] * hull[:, 1]).clamp(min=1e-3)
    return iou - (outer - union).clamp(min=0.0) / outer, iou
