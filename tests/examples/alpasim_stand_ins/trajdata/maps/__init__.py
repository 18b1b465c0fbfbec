from trajdata.maps import vec_map_elements  # noqa: F401


class VectorMap:
    """Only a name: without the reader of maps AlpaSim's Artifact has none."""
