"""Shared-memory channels between the processes: `channels` is the way in, docs/shared-memory.md the protocol."""
