"""Trains the pin model on drawn pictures: `python -m deploy.model.train --minutes 45 --out FOLDER`.

Pictures are drawn while training, so none is seen twice. The rate follows the clock, not a number of steps: a slower
machine ends in time with a worse model.
"""

from __future__ import annotations

import argparse
import copy
import math
import pickle
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
import torch.distributed as dist
from torch.utils.data import DataLoader, IterableDataset

from deploy.model.loss import detection_loss
from deploy.model.network import PinNet
from deploy.model.scenes import Bank, make_bank, make_scene
from deploy.model.sim_frames import FrameBank, make_frames
from deploy.model.targets import FRAME_TOP, HEIGHT, WIDTH, assign

PAD_GREY = 114
Sample = tuple[np.ndarray, np.ndarray]


class DrawnPictures(IterableDataset[Sample]):
    """Endless: (uint8 RGB (3, 256, 320), targets (cells, 6))."""

    def __init__(self, bank: Bank, frames: FrameBank | None, frame_share: float, seed: int) -> None:
        self._bank, self._frames, self._share, self._seed = bank, frames, frame_share, seed

    def __iter__(self) -> Iterator[Sample]:
        cv2.setNumThreads(1)
        info = torch.utils.data.get_worker_info()
        rng = np.random.default_rng([self._seed, info.id if info else 0])
        while True:
            if self._frames is not None and rng.random() < self._share:
                scene = self._frames.draw(rng)
            else:
                scene = make_scene(self._bank, rng)
            shift = np.array([0, FRAME_TOP, 0, FRAME_TOP], np.float32)
            padded = np.full((HEIGHT, WIDTH, 3), PAD_GREY, np.uint8)
            padded[FRAME_TOP : FRAME_TOP + scene.image_bgr.shape[0]] = scene.image_bgr[:, :, ::-1]
            yield (
                np.ascontiguousarray(padded.transpose(2, 0, 1)),
                assign(scene.boxes + shift, scene.ignored + shift),
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=45.0)
    parser.add_argument("--out", type=Path, required=True, help="folder for checkpoints")
    parser.add_argument("--start-from", type=Path, help="checkpoint to go on from")
    parser.add_argument("--batch", type=int, default=32)
    parser.add_argument("--rate", type=float, default=3e-3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--processes", type=int, default=2, help="that share each step's pictures, one thread each"
    )
    parser.add_argument("--bank", type=int, nargs=4, default=(1800, 1500, 1500, 1500),
                        metavar=("PINS", "ODD", "BACKGROUNDS", "FRAMES"))  # fmt: skip
    parser.add_argument("--parts", type=Path, help="file that keeps the parts for the next run")
    parser.add_argument(
        "--frame-share", type=float, default=0.3, help="of pictures from the simulator's renderer"
    )
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    cv2.setNumThreads(1)
    begin_s = time.monotonic()
    bank, frames = _parts(arguments)
    print(f"had the parts after {time.monotonic() - begin_s:.0f} s", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        # Forked, so that all share the parts in memory.
        torch.multiprocessing.start_processes(
            _work,
            (arguments, bank, frames, f"file://{folder}/meet"),
            arguments.processes,
            start_method="fork",
        )


def _work(rank: int, arguments: argparse.Namespace, bank: Bank, frames: FrameBank | None, meet: str) -> None:
    """One of several processes: on a busy machine, waiting once a step is cheaper than once an operation."""
    torch.set_num_threads(1)
    torch.manual_seed(arguments.seed)
    dist.init_process_group("gloo", init_method=meet, rank=rank, world_size=arguments.processes)
    pictures = DrawnPictures(bank, frames, arguments.frame_share, arguments.seed * 100 + rank)
    loader = DataLoader(pictures, arguments.batch // arguments.processes, num_workers=1, prefetch_factor=4)
    _train(loader, arguments, rank)
    dist.destroy_process_group()


def _parts(arguments: argparse.Namespace) -> tuple[Bank, FrameBank | None]:
    """What pictures are put together from: drawn, or as drawn by an earlier run."""
    kept: Path | None = arguments.parts
    if kept is not None and kept.is_file():
        with kept.open("rb") as file:
            return pickle.load(file)  # type: ignore[no-any-return]
    rng = np.random.default_rng(arguments.seed)
    parts = (
        make_bank(rng, *arguments.bank[:3]),
        make_frames(rng, arguments.bank[3]) if arguments.bank[3] else None,
    )
    if kept is not None:
        with kept.open("wb") as file:
            pickle.dump(parts, file)
    return parts


def _train(loader: DataLoader[Sample], arguments: argparse.Namespace, rank: int) -> None:
    net = PinNet().to(memory_format=torch.channels_last).train()  # type: ignore[call-overload]
    if arguments.start_from is not None:
        net.load_state_dict(torch.load(arguments.start_from, weights_only=True))
    average = copy.deepcopy(net)
    if rank == 0:
        print(f"{sum(p.numel() for p in net.parameters())} parameters", flush=True)
    optimiser = torch.optim.AdamW(net.parameters(), lr=arguments.rate, weight_decay=0.02)
    begin_s = saved_s = told_s = time.monotonic()
    limit_s = 60.0 * arguments.minutes
    sums: dict[str, float] = {}
    step = since = 0
    for images, targets in loader:
        share = _agreed((time.monotonic() - begin_s) / limit_s)
        if share >= 1.0:
            break
        rate = (
            arguments.rate
            * min(1.0, (step + 1) / 100)
            * (0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * share)))
        )
        for group in optimiser.param_groups:
            group["lr"] = rate
        x = images.to(memory_format=torch.channels_last).float() / 255.0
        with torch.autocast("cpu", dtype=torch.bfloat16):
            outputs = net(x)
        loss, parts = detection_loss(outputs, targets)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        _average_gradients(net, arguments.processes)
        torch.nn.utils.clip_grad_norm_(net.parameters(), 5.0)
        optimiser.step()
        step, since = step + 1, since + 1
        if rank > 0:
            continue
        _follow(average, net, min(0.998, step / (step + 20)))
        for name, value in parts.items():
            sums[name] = sums.get(name, 0.0) + value
        now_s = time.monotonic()
        if now_s - told_s > 20.0:
            text = "  ".join(f"{name} {value / since:.4f}" for name, value in sums.items())
            print(f"{now_s - begin_s:5.0f} s  step {step}  rate {rate:.5f}  {text}", flush=True)
            sums, since, told_s = {}, 0, now_s
        if now_s - saved_s > 120.0:
            torch.save(average.state_dict(), arguments.out / "average.pt")
            saved_s = now_s
    if rank > 0:
        return
    torch.save(average.state_dict(), arguments.out / "average.pt")
    torch.save(net.state_dict(), arguments.out / "last.pt")
    print(f"{step} steps of {arguments.batch} pictures", flush=True)


def _agreed(share: float) -> float:
    """Rank 0's clock decides, so that all stop at the same step."""
    value = torch.tensor([share])
    dist.broadcast(value, 0)
    return float(value)


def _average_gradients(net: PinNet, processes: int) -> None:
    gradients = [p.grad for p in net.parameters() if p.grad is not None]
    flat = torch.cat([gradient.flatten() for gradient in gradients])
    dist.all_reduce(flat)
    at = 0
    for gradient in gradients:
        gradient.copy_((flat[at : at + gradient.numel()] / processes).view_as(gradient))
        at += gradient.numel()


@torch.no_grad()
def _follow(average: PinNet, net: PinNet, keep: float) -> None:
    """The running mean of the weights, which is what gets exported."""
    for mean, new in zip(average.state_dict().values(), net.state_dict().values()):
        if mean.dtype.is_floating_point:
            mean.mul_(keep).add_(new, alpha=1.0 - keep)
        else:
            mean.copy_(new)


if __name__ == "__main__":
    main()
