"""Tree snapshots as py_trees_ros_interfaces messages. Field by field, so that a missing one is an error here."""

from __future__ import annotations

from typing import Any
from uuid import UUID

from target_nav.app.ros_clock import RosClock
from target_nav.app.ros_convert import stamp_to_msg
from target_nav.app.tick_statistics import TickStatistics
from target_nav.mission.snapshot_types import BehaviourSnapshot, TreeSnapshot


class SnapshotMessages:
    """Builds messages, in one thread; imports their types when it is made, so this module can be imported without ROS.

    What of a behaviour does not change is kept from one message to the next: it is most of the cost.
    """

    def __init__(self, clock: RosClock) -> None:
        from diagnostic_msgs.msg import KeyValue as DiagnosticKeyValue
        from py_trees_ros_interfaces.msg import ActivityItem, Behaviour, BehaviourTree, KeyValue, Statistics
        from unique_identifier_msgs import msg as unique_identifier

        self._clock = clock
        self._behaviour_type, self._tree_type, self._access_type = Behaviour, BehaviourTree, KeyValue
        self._activity_type, self._statistics_type = ActivityItem, Statistics
        self._uuid_type, self._variable_type = unique_identifier.UUID, DiagnosticKeyValue
        self._behaviours: dict[UUID, Any] = {}
        self._uuids: dict[UUID, Any] = {}
        self._last: tuple[TreeSnapshot, list[Any]] | None = None

    def tree(
        self,
        snapshot: TreeSnapshot,
        parameters: Any,
        statistics: TickStatistics,
        changed: bool | None = None,
    ) -> Any:
        """One BehaviourTree; blackboard and activity only if the stream's `parameters` ask for them.

        It holds until the next call only: messages share their parts.
        """
        message = self._tree_type(
            behaviours=self._all(snapshot),
            changed=snapshot.changed if changed is None else changed,
            statistics=self._statistics(statistics),
        )
        if parameters.blackboard_data:
            message.blackboard_on_visited_path = [
                self._variable_type(key=key, value=value)
                for key, value in snapshot.blackboard_on_visited_path
            ]
        if parameters.blackboard_activity:
            message.blackboard_activity = [
                self._activity_type(
                    key=item.key,
                    client_name=item.client_name,
                    activity_type=item.activity_type,
                    previous_value=item.previous_value,
                    current_value=item.current_value,
                )
                for item in snapshot.blackboard_activity
            ]
        return message

    def _all(self, snapshot: TreeSnapshot) -> list[Any]:
        if self._last is not None and self._last[0] is snapshot:
            return self._last[1]
        if len(self._behaviours) > len(snapshot.behaviours):
            # left over from a tree that was replaced
            self._behaviours.clear()
            self._uuids.clear()
        behaviours = [self._behaviour(b) for b in snapshot.behaviours]
        self._last = (snapshot, behaviours)
        return behaviours

    def _behaviour(self, b: BehaviourSnapshot) -> Any:
        message = self._behaviours.get(b.own_id)
        if message is None:
            message = self._behaviours[b.own_id] = self._behaviour_type(
                name=b.name,
                class_name=b.class_name,
                own_id=self._uuid(b.own_id),
                parent_id=self._uuid(b.parent_id),
                child_ids=[self._uuid(child) for child in b.child_ids],
                type=int(b.type),
                additional_detail=b.additional_detail,
                blackbox_level=b.blackbox_level,
                blackboard_access=[
                    self._access_type(key=key, value=mark) for key, mark in b.blackboard_access
                ],
            )
        message.tip_id = self._uuid(b.tip_id)
        message.current_child_id = self._uuid(b.current_child_id)
        message.status = int(b.status)
        message.message = b.message
        message.is_active = b.is_active
        return message

    def _statistics(self, s: TickStatistics) -> Any:
        return self._statistics_type(
            count=s.count,
            stamp=stamp_to_msg(s.stamp_s, self._clock),
            tick_duration=s.duration_s,
            tick_duration_average=s.duration_average_s,
            tick_duration_variance=s.duration_variance_s2,
            tick_interval=s.interval_s,
            tick_interval_average=s.interval_average_s,
            tick_interval_variance=s.interval_variance_s2,
        )

    def _uuid(self, value: UUID) -> Any:
        message = self._uuids.get(value)
        if message is None:
            message = self._uuids[value] = self._uuid_type(uuid=list(value.bytes))
        return message
