"""The browser console: the operator's view models over one WebSocket, and a page that draws them.

No ROS, no decision: it reads shared memory as the panel does, and says words into the same command ring. Heavy work
(checking missions, reading recordings) happens in helper processes, so that this one stays small and answers at once.
"""
