"""Case files with a mistake, and what is said of each."""

import copy
import math

from ruamel.yaml import YAML

from drakesep.case_file.reader import builtin_cases


VEGA = YAML(typ="safe").load(builtin_cases()["vega"])


def changed(path: str, value=...):
    """VEGA with the value at a dotted path changed, or taken out."""
    data = copy.deepcopy(VEGA)
    *parents, last = (
        path.split(".", 3)
        if "dispersions" not in path
        else (
            "dispersions",
            path.removeprefix("dispersions."),
        )
    )
    place = data
    for parent in parents:
        place = place[parent]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return data


BAD = {
    "unknown key": (
        changed("bodies.payload.mass", 1.0),
        "bodies.payload: unknown key 'mass'; did you mean 'mass_kg'?",
    ),
    "unknown top key": (
        changed("boddies", {}),
        "unknown key 'boddies'; did you mean 'bodies'?",
    ),
    "missing key": (
        changed("bodies.payload.mass_kg"),
        "bodies.payload: mass_kg: missing, as are solid and model",
    ),
    "a section without a value": (
        changed("recontact", None),
        "recontact: must have a value, got none",
    ),
    "an entry without a value": (
        changed("loads", {"gust": {"torque_N_m": [0.0, None, 0.0]}}),
        "loads.gust.torque_N_m (entry 2): must have a value, got none",
    ),
    "wrong type": (
        changed("bodies.payload.mass_kg", "heavy"),
        "bodies.payload.mass_kg: must be a number, got 'heavy'",
    ),
    "number as text": (
        changed("bodies.payload.mass_kg", "1860"),
        "bodies.payload.mass_kg: must be a number, got '1860'",
    ),
    "yes for a number": (
        changed("bodies.payload.mass_kg", True),
        "bodies.payload.mass_kg: must be a number, got True",
    ),
    "NaN": (
        changed("bodies.payload.mass_kg", math.nan),
        "bodies.payload.mass_kg: must be finite, got nan",
    ),
    "infinity": (
        changed("before_separation.rate_deg_s", [0.0, math.inf, 0.0]),
        "before_separation.rate_deg_s (entry 2): must be finite, got inf",
    ),
    "two entries": (
        changed("bodies.payload.cg_mm", [1.0, 2.0]),
        "bodies.payload.cg_mm: must be 3 numbers, got [1.0, 2.0]",
    ),
    "negative mass": (
        changed("bodies.payload.mass_kg", -3),
        "bodies.payload.mass_kg: must be > 0, got -3",
    ),
    "zero stroke": (
        changed("attachments.attachment_2.spring.stroke_mm", 0),
        "attachments.attachment_2.spring.stroke_mm: must be > 0, got 0",
    ),
    "impossible inertia": (
        changed("bodies.payload.inertia_kg_m2.xx", 10),
        "payload: inertia must have principal moments that obey the triangle",
    ),
    "indefinite inertia": (
        changed("bodies.payload.inertia_kg_m2.xy", 5000),
        "payload: inertia must be positive definite",
    ),
    "no design mass": (
        changed("attachments.attachment_1.spring.design_mass_kg"),
        "attachments.attachment_1.spring: design_mass_kg: missing; law: time needs it",
    ),
    "design mass too many": (
        changed("attachments.attachment_1.spring.law", "displacement"),
        "attachments.attachment_1.spring: design_mass_kg: law: displacement has none",
    ),
    "damper of a timed spring": (
        changed("attachments.attachment_1.spring.damping_N_s_m", 1.0),
        "attachments.attachment_1.spring: damping_N_s_m: law: time has none",
    ),
    "unknown law": (
        changed("attachments.attachment_1.spring.law", "force"),
        "attachments.attachment_1.spring.law: must be 'time', 'displacement', 't",
    ),
    "no such body": (
        changed("attachments.attachment_1.B", "payloud"),
        "attachment_1: unknown body 'payloud'; did you mean 'payload'?",
    ),
    "no such pair": (
        changed("pair.A", "lv"),
        "pair: unknown body 'lv'; known: launch_vehicle, payload",
    ),
    "late release": (
        changed("attachments.attachment_1.release_time_s", 3.5),
        "attachment_1: release time must lie before the end of the run at 3",
    ),
    "short run": (
        changed("run.duration_s", 0.1),
        "duration must be longer than it takes the springs",
    ),
    "non-physical tolerance": (
        changed("dispersions.payload.mass_kg", 1900),
        "dispersions: payload.mass_kg ± 1900: payload: mass must be > 0, got -40",
    ),
    "zero tolerance": (
        changed("dispersions.payload.mass_kg", 0),
        "dispersions.payload.mass_kg: must be finite and > 0, got 0",
    ),
    "unknown tolerance": (
        changed("dispersions.payload.mas_kg", 20),
        "dispersions: unknown parameter 'payload.mas_kg'; did you mean 'payload.mass",
    ),
    "unknown integrator": (
        changed("run.integrator", "runge_kutta4"),
        "run.integrator: must be 'runge_kutta5', 'runge_kutta3', 'bogacki_shampine3'",
    ),
    "zero accuracy": (changed("run.accuracy", 0.0), "run.accuracy: must be > 0, got 0"),
    "unknown quantity": (
        changed("requirements", [{"quantity": "speed", "at_least": 1.0}]),
        "requirements (entry 1).quantity: unknown quantity 'speed'; did you mean",
    ),
    "no limit": (
        changed("requirements", [{"quantity": "rate_after_separation_deg_s"}]),
        "requirements (entry 1): must have 'at_most', 'at_least' or both, got none",
    ),
    "one limit of three": (
        changed(
            "requirements",
            [{"quantity": "rate_after_separation_deg_s", "at_most": 1.5}],
        ),
        "requirements (entry 1): must have 3 limits, got 1.5",
    ),
    "one body": (
        changed("bodies", {"payload": VEGA["bodies"]["payload"]}),
        "bodies: dictionary should have at least 2 items",
    ),
    "NaN as a limit": (
        changed(
            "requirements",
            [
                {
                    "quantity": "longitudinal_speed_after_separation_m_s",
                    "at_least": math.nan,
                }
            ],
        ),
        "requirements (entry 1).at_least (entry 1): must be finite, got nan",
    ),
    "name that leaves its folder": (
        changed("name", "../../elsewhere"),
        "name: must be made of letters, digits, _ and -, got '../../elsewhere'",
    ),
    "number for a section": (
        changed("bodies.payload.inertia_kg_m2", 60),
        "bodies.payload.inertia_kg_m2: must be a mapping of keys, got 60",
    ),
    "infinite release": (
        changed("attachments.attachment_1.release_time_s", float("inf")),
        "attachments.attachment_1.release_time_s: must be a finite number, or never, "
        "got inf",
    ),
    "negative release": (
        changed("attachments.attachment_1.release_time_s", -0.1),
        "attachment_1: release time must be >= 0, got -0.1",
    ),
    "negative limit": (
        changed(
            "requirements",
            [{"quantity": "rate_after_separation_deg_s", "at_most": [1.0, -2.0, 1.0]}],
        ),
        "requirements: rate_after_separation_y_deg_s: at_most must be >= 0, got -2",
    ),
    "requirement twice": (
        changed("requirements", 2 * VEGA["requirements"][:1]),
        "requirements: rate_after_separation_x_deg_s: at_most must stand once, or "
        "each time with an id of its own, got none twice",
    ),
    "band that holds nothing": (
        changed(
            "requirements",
            [
                {
                    "quantity": "longitudinal_speed_m_s",
                    "when": "after_separation",
                    "at_least": 1.0,
                    "at_most": 0.3,
                }
            ],
        ),
        "requirements (entry 1): at_least must not be above at_most, got 1 and 0.3",
    ),
    "share without confidence": (
        changed(
            "requirements",
            [
                {
                    "quantity": "rate_after_separation_deg_s",
                    "at_most": [9.0] * 3,
                    "share": 0.99865,
                }
            ],
        ),
        "requirements (entry 1): rate_after_separation_deg_s: must have share and "
        "confidence, got no confidence",
    ),
    "share in per cent": (
        changed(
            "requirements",
            [
                {
                    **{"quantity": "rate_after_separation_deg_s", "at_most": [9.0] * 3},
                    **{"share": 99.865, "confidence": 0.9},
                }
            ],
        ),
        "requirements (entry 1).share: must be less than 1, got 99.865",
    ),
    "one side of two": (
        changed(
            "requirements",
            [
                {
                    **{"quantity": "longitudinal_speed_m_s", "at_least": 1.0},
                    **{"share": 0.9973, "confidence": 0.9, "sides": "two"},
                }
            ],
        ),
        "requirements: longitudinal_speed_m_s: at_least of two sides must stand with "
        "one from above, of the same id, share and confidence",
    ),
    "time of a metric that says it": (
        changed(
            "requirements",
            [
                {
                    "quantity": "rate_after_separation_deg_s",
                    "when": "at_end",
                    "at_most": [1.0, 1.0, 1.0],
                }
            ],
        ),
        "requirements (entry 1): rate_after_separation_deg_s has no 'when': its name",
    ),
    "no limit at all": (
        changed(
            "requirements",
            [{"quantity": "rate_deg_s", "at_most": [None, None, None]}],
        ),
        "requirements (entry 1): must have a limit that is no null, got none",
    ),
    "stretch of time backwards": (
        changed(
            "requirements",
            [
                {
                    "quantity": "rate_deg_s",
                    "when": {"from_s": 2.0, "to_s": 1.0},
                    "at_most": [1.0, None, None],
                }
            ],
        ),
        "requirements (entry 1).when.seconds: to_s must be > from_s, got 2 to 1",
    ),
    "published twice": (
        changed("published", 2 * VEGA["published"][:1]),
        "published: label 'paper_L1_Linf' must stand once",
    ),
    "published under our label": (
        changed("published", [{**VEGA["published"][0], "label": "worst_L1"}]),
        "published: label 'worst_L1' is taken by our own runs",
    ),
    "published with a bad mark": (
        changed(
            "published",
            [{**VEGA["published"][0], "values": {"payload.mass_kg": "Q"}}],
        ),
        "published (entry 1).values.payload.mass_kg: must be M, m or a number, got 'Q'",
    ),
    "published but impossible": (
        changed(
            "published",
            [{**VEGA["published"][0], "values": {"payload.inertia_xx_kg_m2": 1.0}}],
        ),
        "published: paper_L1_Linf: payload: inertia must have principal moments",
    ),
    "published without what it is the worst of": (
        changed("objectives"),
        "published: worst cases of the paper's objectives need 'objectives: paper'",
    ),
    "objectives of others": (
        changed("objectives", "L1"),
        "objectives: must be 'paper', got 'L1'",
    ),
    "Drake's own name": (
        changed("bodies", {**VEGA["bodies"], "world": VEGA["bodies"]["payload"]}),
        "names must differ, got 'world' 2 times (it is reserved)",
    ),
    "not a mapping": ([1, 2], "must be a mapping of keys, got [1, 2]"),
}
