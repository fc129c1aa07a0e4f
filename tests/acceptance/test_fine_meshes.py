"""A stone of 51 200 triangles, as shape models of asteroids are, leaves a ring."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from separations import FREE

import drakesep
from drakesep.analysis import AnalysisCase
from drakesep.systems.model.parts import Cone, Mesh, Part
from drakesep.systems.model.separation import Attachment, Body, Separation
from drakesep.systems.model.springs import Spring


ROUND, ALONG = 320, 80
BORE, LENGTH = 0.68, 0.1
"""Of the ring, m; it ends where the stack's origin is."""
MIDDLE = np.array([0.3, 0.05, -0.08])
"""Of the stone while mated, m: it stands within the ring, beside its axis."""


def stone() -> tuple[np.ndarray, np.ndarray]:
    """Vertices, m, and triangles of a closed bumpy stone."""
    around = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    down = np.linspace(0.0, np.pi, ALONG + 2)[1:-1]
    theta, phi = (x.ravel() for x in np.meshgrid(down, around, indexing="ij"))
    ways = np.stack(
        [np.cos(theta), np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)], 1
    )
    ways = np.vstack([ways, [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    x, y, z = ways.T
    r = 0.55 * (1.0 + 0.08 * np.sin(5 * x) * np.cos(4 * y) + 0.02 * np.sin(11 * z))
    i, j = np.meshgrid(np.arange(ALONG - 1), np.arange(ROUND), indexing="ij")
    a, b = (i * ROUND + j).ravel(), (i * ROUND + (j + 1) % ROUND).ravel()
    side = np.vstack(
        [np.stack([a, a + ROUND, b], 1), np.stack([b, a + ROUND, b + ROUND], 1)]
    )
    k, after = np.arange(ROUND), (np.arange(ROUND) + 1) % ROUND
    top, foot = ALONG * ROUND, ALONG * ROUND + 1
    last = (ALONG - 1) * ROUND
    caps = [
        np.stack([np.full(ROUND, top), k, after], 1),
        np.stack([np.full(ROUND, foot), last + after, last + k], 1),
    ]
    return ways * r[:, None], np.vstack([side, *caps])


@pytest.fixture(scope="module")
def leaving(tmp_path_factory):
    vertices, triangles = stone()
    assert len(triangles) > 50_000
    path = tmp_path_factory.mktemp("stone") / "stone.obj"
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    path.write_text("\n".join(lines))
    ring = Part(
        name="ring",
        shape=Cone(
            radius_aft=BORE + 0.02,
            radius_fore=BORE + 0.02,
            length=LENGTH,
            thickness=0.02,
        ),
        p_BoGo_B=(-0.5 * LENGTH, 0.0, 0.0),
    )
    rock = Part(name="rock", shape=Mesh(file=path), p_BoGo_B=tuple(MIDDLE.tolist()))
    inertia = (150.0, 250.0, 250.0, 0.0, 0.0, 0.0)
    carrier = Body(
        name="carrier",
        mass=2000.0,
        p_BoBcm_B=(-1.2, 0.0, 0.0),
        I_BBcm_B=inertia,
        parts=(ring,),
    )
    # It turns about y as it leaves: its CG is off the push.
    craft = Body(
        name="craft",
        mass=500.0,
        p_BoBcm_B=(0.3, 0.0, 0.02),
        I_BBcm_B=inertia,
        parts=(rock,),
    )
    spring = Spring(name="push", force_max=800.0, stroke=0.1, design_mass=300.0)
    pad = Attachment(
        name="pad",
        A="carrier",
        B="craft",
        p_AoPad_A=(0.0, 0.0, 0.0),
        joint=FREE,
        spring=spring,
        release_time=0.0,
    )
    separation = Separation(
        bodies=(carrier, craft),
        attachments=(pad,),
        A="carrier",
        B="craft",
        duration=1.0,
    )
    return vertices, drakesep.clearance(AnalysisCase(separation=separation))


def vertices_to_ring(vertices, run) -> float:
    """How near the stone's vertices come to the hollow ring, m.

    Where vertices are within its length, nothing of the stone is nearer to the bore; at
    its rim, an edge of the stone may be, by (8 mm)^2 over eight times the gap.
    """
    trajectory, smallest = run.completed_trajectory, np.inf
    A, B = (trajectory.of(name) for name in ("carrier", "craft"))
    for a, b in zip(A, B, strict=True):
        R_WA, R_WB = (Rotation.from_quat(x[:4], scalar_first=True) for x in (a, b))
        at = R_WB.apply(vertices + MIDDLE) + b[4:7] - a[4:7]
        x, y, z = R_WA.apply(at, inverse=True).T
        beyond = np.maximum(np.maximum(x, -LENGTH - x), 0.0)
        gaps = np.hypot(np.maximum(BORE - np.hypot(y, z), 0.0), beyond)
        smallest = min(smallest, float(gaps.min()))
    return smallest


@pytest.mark.slow
def test_a_stone_of_many_triangles_leaves_a_ring(leaving):
    vertices, found = leaving
    [nearest] = found.found
    expected = vertices_to_ring(vertices, found.labelled.run)
    # Of edges beside vertices, facets of the ring and samples of 10 ms, which it drifts
    # aside by 0.1 mm in.
    assert nearest.minimum == pytest.approx(expected, abs=3e-4)
