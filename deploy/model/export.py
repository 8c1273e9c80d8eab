"""A checkpoint to the ONNX file that the robot runs: `python -m deploy.model.export CHECKPOINT OUT.onnx`.

Opset 12 by the classic exporter, batch norms folded, no Identity nodes: what OpenCV 4.6 reads without a crash.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import onnx
import torch

from deploy.model.network import HEIGHT, STRIDES, WIDTH, PinNet

OPSET = 12


def export(checkpoint: Path, out: Path, logit_shift: float = 0.0) -> None:
    """`logit_shift` is added to every score's logit: it puts the threshold chosen by evaluation at a score of 0.5."""
    net = PinNet()
    net.load_state_dict(torch.load(checkpoint, weights_only=True))
    net.eval()
    with torch.no_grad():
        for head in net.heads:
            head.score.bias += logit_shift  # type: ignore[union-attr, operator]
    names = [f"stride{stride}" for stride in STRIDES]
    sample = torch.full((1, 3, HEIGHT, WIDTH), 0.5)
    torch.onnx.export(
        net,
        (sample,),
        str(out),
        opset_version=OPSET,
        dynamo=False,
        input_names=["images"],
        output_names=names,
    )
    model = onnx.load(str(out))
    _drop_identities(model)
    model.doc_string = "one class, bowling_pin; heads (logit, l, t, r, b) in strides; see docs/model.md"
    onnx.checker.check_model(model)
    onnx.save(model, str(out))
    _compare(net, sample, out)


def _drop_identities(model: onnx.ModelProto) -> None:
    graph = model.graph
    for node in [node for node in graph.node if node.op_type == "Identity"]:
        for other in graph.node:
            for i, name in enumerate(other.input):
                if name == node.output[0]:
                    other.input[i] = node.input[0]
        graph.node.remove(node)


def _compare(net: PinNet, sample: torch.Tensor, out: Path) -> None:
    """The file must give what the network gives, by OpenCV."""
    import cv2

    rng = np.random.default_rng(0)
    picture = rng.random(sample.shape, np.float32)
    with torch.no_grad():
        wanted = net(torch.from_numpy(picture))
    reader = cv2.dnn.readNetFromONNX(str(out))
    reader.setInput(picture)
    given = sorted(reader.forward(reader.getUnconnectedOutLayersNames()), key=lambda head: -head.shape[2])
    for head, other in zip(wanted, given):
        difference = float(np.abs(head.numpy() - other).max())
        if difference > 1e-2:
            raise SystemExit(f"{out} differs from the checkpoint by {difference:g}")
    count = sum(p.numel() for p in net.parameters())
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB, {count} parameters, opset {OPSET}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkpoint", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--logit-shift", type=float, default=0.0)
    arguments = parser.parse_args()
    export(arguments.checkpoint, arguments.out, arguments.logit_shift)
