class MapElementType:
    """Only a name."""


class RoadLane:
    """Only a name."""


class RoadEdge:
    """Only a name."""


class WaitLine:
    """Only a name."""
