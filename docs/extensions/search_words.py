"""Words under which the search lists a page first, whether or not they stand on it."""

_WORDS = {
    "README": "install, installation, pip, Bowden cable, Bowden, friction, sheath",
    "docs/plugin": "backlash, spool, stiction, slack, attributes, muscle",
    "docs/theory": "hysteresis, capstan, dead zone, equivalent backlash, apparent stiffness",
    "docs/recording": "CSV, CSV format, rosbag, ROS bag, MCAP, units, file format, recording",
    "docs/diagnosis": "identifiability, system identification, indistinguishable, cross-validation",
    "docs/gpu": "gpu, CUDA, Warp, JAX",
    "docs/environments": "reinforcement learning, gymnasium, dm_control, sim-to-real, RL",
    "docs/c": "ROS, ROS 2, C++",
    "docs/your_rig": "tutorial, getting started",
    "docs/commands": "command line, CLI",
}


def _index(app, page: str, source: list[str]) -> None:
    """Add index entries below the heading; the search ranks them before titles and text."""
    if page in _WORDS:
        head, heading, rest = source[0].partition("# ")
        title, _, text = rest.partition("\n")
        words = ", ".join(f"!{word}" for word in _WORDS[page].split(", "))  # ! as a main entry
        entry = f"\n```{{index}} {words}\n```\n"
        source[0] = f"{head}{heading}{title}\n{entry}{text}"


def setup(app):
    """Add the entries when a page is read."""
    app.connect("source-read", _index)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
