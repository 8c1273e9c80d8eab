"""Groot2's side of the protocol, over ZeroMQ."""

from __future__ import annotations

import json
import struct
import xml.etree.ElementTree as ElementTree
from typing import Any

import msgpack
import zmq

PATIENCE_MS = 5000


class GrootClient:
    def __init__(self, port: int) -> None:
        self._context = zmq.Context()
        self._ask = self._socket(zmq.REQ, port)
        self._news = self._socket(zmq.SUB, port + 1)
        self._news.setsockopt(zmq.SUBSCRIBE, b"")
        self._number = 1000

    def _socket(self, kind: int, port: int) -> Any:
        socket = self._context.socket(kind)
        socket.setsockopt(zmq.LINGER, 0)
        socket.setsockopt(zmq.RCVTIMEO, PATIENCE_MS)
        socket.connect(f"tcp://127.0.0.1:{port}")
        return socket

    def raw(self, *parts: bytes) -> list[bytes]:
        self._ask.send_multipart(parts)
        answer: list[bytes] = self._ask.recv_multipart()
        return answer

    def ask(self, letter: str, *content: bytes) -> list[bytes]:
        """The answer's parts after its header, which is checked."""
        self._number += 1
        header = struct.pack("<BBI", 2, ord(letter), self._number)
        answer = self.raw(header, *content)
        if answer[0] != b"error":
            assert answer[0][:6] == header
            assert len(answer[0]) == 22
            return answer[1:]
        return answer

    def tree(self) -> ElementTree.Element:
        return ElementTree.fromstring(self.ask("T")[0])

    def tree_id(self) -> bytes:
        self._number += 1
        return self.raw(struct.pack("<BBI", 2, ord("S"), self._number))[0][6:]

    def statuses(self) -> dict[int, int]:
        (content,) = self.ask("S")
        return dict(struct.iter_unpack("<HB", content))

    def blackboard(self, names: str) -> Any:
        return msgpack.unpackb(self.ask("B", names.encode())[0])

    def hook(self, letter: str, **values: Any) -> list[bytes]:
        return self.ask(letter, json.dumps(values).encode())

    def breakpoint(self, uid: int, **changes: Any) -> list[bytes]:
        hook = {
            "enabled": True,
            "uid": uid,
            "mode": 0,
            "once": False,
            "desired_status": "SKIPPED",
            "position": 0,
        }
        return self.hook("I", **{**hook, **changes})

    def unlock(self, uid: int, status: str = "SKIPPED", remove: bool = False) -> list[bytes]:
        return self.hook("U", uid=uid, desired_status=status, position=0, remove_when_done=remove)

    def reached(self) -> int:
        """The node of the next breakpoint that is reached."""
        header, uid = self._news.recv_multipart()
        assert header[:2] == b"\x02N"
        return int(uid)

    def close(self) -> None:
        self._ask.close()
        self._news.close()
        self._context.term()


def nodes_of(root: ElementTree.Element) -> dict[int, tuple[str, str]]:
    """Tag and name of every node that has a number."""
    return {
        int(element.attrib["_uid"]): (element.tag, element.get("name") or element.get("ID") or "")
        for tree in root.iter("BehaviorTree")
        for element in tree.iter()
        if "_uid" in element.attrib
    }


def paths_of(root: ElementTree.Element) -> list[tuple[str, str]]:
    """Each tree and where it is used."""
    return [(tree.attrib["ID"], tree.attrib["_fullpath"]) for tree in root.iter("BehaviorTree")]
