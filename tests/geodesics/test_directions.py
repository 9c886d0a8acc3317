"""Direction fields: index sums, closed forms, smoothness across edges, and hardly surfaces."""

import numpy as np
import pytest
from scipy.sparse import block_diag, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from surftex.errors import SurfaceError
from surftex.geodesics import connection
from surftex.geodesics.connection import Connection
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.factors import nested_order, solved_by_steps
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


def in_space(surface, face, angle):
    """Unit vectors in space from angles in the faces' frames."""
    frame = surface.frame[face]
    return np.cos(angle)[:, None] * frame[:, 0] + np.sin(angle)[:, None] * frame[:, 1]


def arms_apart(one, two, symmetry):
    """Least angle between any arms of two directions."""
    return np.abs(np.angle(np.exp(1j * symmetry * (one - two)))) / symmetry


def bumpy(subdivisions=3):
    """A ball without symmetry."""
    ball = sphere(40.0, subdivisions=subdivisions)
    x, y, z = ball.vertices.T / 40
    swell = 1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(2 * y - z) + 0.1 * z**3
    return Surface.from_arrays(ball.vertices * swell[:, None], ball.faces)


def two_pieces():
    """A ball, and a single triangle that shares no vertex with it."""
    ball = sphere(10.0, subdivisions=2)
    count = len(ball.vertices)
    vertices = np.vstack([ball.vertices, [[100, 0, 0], [101, 0, 0], [100, 1, 0]]])
    return Surface.from_arrays(vertices, np.vstack([ball.faces, [[count, count + 1, count + 2]]]))


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(
    ("shape", "euler"), [(sphere(20.0), 2), (bumpy(), 2), (torus(columns=30, rows=15), 0)]
)
def test_indices_add_up_to_the_euler_number(shape, euler, symmetry):
    fields = [
        DirectionField.smoothest(shape, symmetry),
        DirectionField.from_axis(shape, [1, 2, 0.5], symmetry),
    ]
    for field in fields:
        assert field.index.sum() == symmetry * euler
        np.testing.assert_array_equal(field.strength == 0, field.index != 0)
    if euler:
        assert np.abs(fields[0].index).sum() <= symmetry * euler + 4  # few more than must be


def test_the_smoothest_field_has_the_lowest_energy_of_all():
    shape = bumpy(2)
    connection = Connection(shape, 1)
    field = DirectionField.smoothest(shape)
    value = connection.lowest(field.vertex_value)
    matrix, mass = connection.laplacian.toarray(), connection.mass
    scaled = matrix / np.sqrt(mass[:, None] * mass[None, :])
    least = np.linalg.eigvalsh(scaled)[0]
    reached = (value.conj() @ matrix @ value).real / (mass * np.abs(value) ** 2).sum()
    assert reached == pytest.approx(least, rel=1e-3)


def test_each_component_has_its_own_lowest_mode():
    first, second = bumpy(2), torus(columns=18, rows=9)
    apart = first.vertices + np.array([200.0, 0, 0])
    both = Surface.from_arrays(
        np.vstack([second.vertices, apart]), np.vstack([second.faces, first.faces + len(second.vertices)])
    )
    connection = Connection(both, 2)
    start = np.exp(1j * np.arange(len(both.vertices)))
    value = connection.lowest(start)
    matrix, mass = connection.laplacian.toarray(), connection.mass
    scaled = matrix / np.sqrt(mass[:, None] * mass[None, :])
    for piece in (0, 1):
        member = connection.component == piece
        modes = np.linalg.eigh(scaled[np.ix_(member, member)])[1]
        lowest = modes[:, 0] * (modes[:, 0].conj() @ (np.sqrt(mass) * start)[member])
        lowest /= np.sqrt(mass[member]) * np.linalg.norm(lowest) / np.sqrt(mass[member].sum())
        np.testing.assert_allclose(value[member], lowest, atol=2e-4)  # nearest to the start, to its phase


def test_an_axis_is_followed_exactly_where_it_lies_in_the_surface():
    tube = cylinder(20.0, 60.0)
    every = np.arange(len(tube.faces))
    field = DirectionField.from_axis(tube, [0, 0, 2])
    np.testing.assert_allclose(in_space(tube, every, field.angle_rad)[:, 2], 1, atol=1e-9)
    sheet = plane(10.0)
    for angle in (0.0, 0.7, -2.0):
        field = DirectionField.constant(sheet, angle)
        expected = [np.cos(angle), np.sin(angle), 0]
        every = np.arange(len(sheet.faces))
        np.testing.assert_allclose(
            in_space(sheet, every, field.angle_rad), np.tile(expected, (len(every), 1)), atol=1e-9
        )
    upright = DirectionField.from_axis(sheet, [0, 0, 1])
    assert np.isfinite(upright.angle_rad).all()
    assert (upright.index == 0).all()


def test_bends_of_a_tube_and_a_ring():
    tube = cylinder(20.0, 60.0)
    every = np.arange(len(tube.faces))
    around = in_space(tube, every, DirectionField.from_curvature(tube, "max").angle_rad)
    along = in_space(tube, every, DirectionField.from_curvature(tube, "min").angle_rad)
    assert np.abs(around[:, 2]).max() < 1e-6
    assert np.abs(along[:, 2]).min() > 1 - 1e-6
    ring = torus(30.0, 12.0, columns=60, rows=30)
    every = np.arange(len(ring.faces))
    most = in_space(ring, every, DirectionField.from_curvature(ring, "max").angle_rad)
    middle = ring.vertices[ring.faces].mean(axis=1) * [1, 1, 0]
    ringwise = np.cross([0, 0, 1], middle / np.linalg.norm(middle, axis=1, keepdims=True))
    assert np.abs((most * ringwise).sum(axis=1)).max() < 0.05
    inside_out = Surface.from_arrays(tube.vertices, tube.faces[:, ::-1])
    turned = in_space(
        inside_out, np.arange(len(tube.faces)), DirectionField.from_curvature(inside_out).angle_rad
    )
    assert np.abs(turned[:, 2]).max() < 1e-6


def test_strokes_are_met_and_carried():
    sheet = plane(10.0, cells=12)
    points = SurfacePoints([3, 200], [[0.2, 0.3, 0.5], [1 / 3, 1 / 3, 1 / 3]])
    wanted = np.array([0.4, 1.5])
    field = DirectionField.from_strokes(sheet, points, wanted)
    assert arms_apart(field.at(points), wanted, 1).max() < 0.02
    one = SurfacePoints([3], [[0.2, 0.3, 0.5]])
    everywhere = in_space(
        sheet, np.arange(len(sheet.faces)), DirectionField.from_strokes(sheet, one, 0.4).angle_rad
    )
    expected = in_space(sheet, np.array([3]), np.array([0.4]))
    np.testing.assert_allclose(everywhere, np.repeat(expected, len(everywhere), axis=0), atol=1e-6)
    shape = bumpy()
    random = np.random.default_rng(2)
    points = SurfacePoints(random.choice(len(shape.faces), 5, replace=False), random.dirichlet([1, 1, 1], 5))
    for symmetry in (1, 2, 4):
        field = DirectionField.from_strokes(shape, points, 0.3, symmetry)
        assert arms_apart(field.at(points), 0.3, symmetry).max() < 0.05


@pytest.mark.parametrize("symmetry", [1, 4])
def test_angles_agree_across_edges(symmetry):
    shape = bumpy(2)
    field = DirectionField.smoothest(shape, symmetry)
    share = np.random.default_rng(0).random((len(shape.faces), 3))
    face = np.repeat(np.arange(len(shape.faces)), 3).astype(np.int32)
    edge = np.tile(np.arange(3), len(shape.faces))
    other, other_edge = shape.neighbor[face, edge], shape.neighbor_edge[face, edge]
    here, there = np.zeros((len(face), 3)), np.zeros((len(face), 3))
    row = np.arange(len(face))
    here[row, edge], here[row, (edge + 1) % 3] = 1 - share.ravel(), share.ravel()
    there[row, other_edge], there[row, (other_edge + 1) % 3] = share.ravel(), 1 - share.ravel()
    one, two = field.at(SurfacePoints(face, here)), field.at(SurfacePoints(other, there))
    turn = np.arctan2(shape.transport[face, edge, 1], shape.transport[face, edge, 0])
    smooth = (field.index[face] == 0) & (field.index[other] == 0)
    assert arms_apart(one + turn, two, symmetry)[smooth].max() < 1e-9


def test_rigid_motion_and_renumbering_carry_the_field_along():
    shape = bumpy()
    random = np.random.default_rng(4)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    order, rename = random.permutation(len(shape.faces)), random.permutation(len(shape.vertices))
    moved = np.zeros_like(shape.vertices)
    moved[rename] = shape.vertices @ turn.T + [5, -3, 2]
    other = Surface.from_arrays(moved, rename[np.roll(shape.faces, 1, axis=1)][order])
    axis = np.array([0.2, 1.0, 0.4])
    every = np.arange(len(order))
    for one, two in (
        (DirectionField.from_axis(shape, axis), DirectionField.from_axis(other, turn @ axis)),
        (DirectionField.from_curvature(shape, symmetry=4), DirectionField.from_curvature(other, symmetry=4)),
    ):
        calm = one.index[order] == 0
        before = in_space(shape, every, one.angle_rad)[order] @ turn.T
        after = in_space(other, every, two.angle_rad)
        if one.symmetry == 1:
            np.testing.assert_allclose(after[calm], before[calm], atol=1e-6)
        else:
            angle = np.arccos(np.clip((after * before).sum(axis=1), -1, 1))[calm]
            assert np.abs(np.sin(2 * angle)).max() < 1e-5


def test_odd_surfaces_get_finite_fields():
    alone = Surface.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    sliver = Surface.from_arrays(
        [[0, 0, 0], [1, 0, 0], [0.5, 1e-7, 0], [0.5, -1, 0], [9, 9, 9]], [[0, 1, 2], [1, 0, 3]]
    )
    fan = 500
    turn = np.arange(fan) * 2 * np.pi / fan
    ring = np.stack([np.cos(turn), np.sin(turn), 0.3 * np.cos(5 * turn)], axis=1)
    wheel = Surface.from_arrays(
        np.vstack([[0, 0, 0.5], ring]),
        np.stack([0 * np.arange(fan), np.arange(fan) + 1, (np.arange(fan) + 1) % fan + 1], axis=1),
    )
    for surface in (alone, sliver, wheel, two_pieces()):
        stroke = SurfacePoints([0], [[1.0, 0.0, 0.0]])
        for symmetry in (1, 2, 4):
            for field in (
                DirectionField.smoothest(surface, symmetry),
                DirectionField.from_axis(surface, [0, 0, 1], symmetry),
                DirectionField.from_strokes(surface, stroke, 0.5, symmetry),
            ):
                assert np.isfinite(field.angle_rad).all()
                assert np.isfinite(field.at(SurfacePoints([0] * 3, np.eye(3)))).all()
        assert np.isfinite(DirectionField.from_curvature(surface).angle_rad).all()


def test_the_same_bytes_again_and_turning():
    shape = bumpy()
    one, two = DirectionField.smoothest(shape, 2), DirectionField.smoothest(shape, 2)
    assert one.vertex_value.tobytes() == two.vertex_value.tobytes()
    quarter = one.turned(np.pi / 2)
    np.testing.assert_allclose(arms_apart(quarter.angle_rad, one.angle_rad, 2), np.pi / 2, atol=1e-9)


def neighbours_of(pairs, count):
    """A graph as rows."""
    pairs = np.array(pairs)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    return csr_array((np.ones(len(both)), both.T), shape=(count, count))


GRAPHS = {
    "ball": lambda: Connection(sphere(10.0, subdivisions=4), 1).laplacian.tocsr(),
    "bumps": lambda: Connection(bumpy(4), 1).laplacian.tocsr(),
    "two bodies": lambda: block_diag([Connection(bumpy(3), 1).laplacian] * 2).tocsr(),
    "path": lambda: neighbours_of([(i, i + 1) for i in range(2999)], 3000),
    "fan": lambda: neighbours_of(
        [(0, i) for i in range(1, 3000)] + [(i, i + 1) for i in range(1, 2999)], 3000
    ),
    "single vertices": lambda: csr_array((500, 500)),
}


@pytest.mark.parametrize("name", GRAPHS)
def test_rings_part_a_graph_and_fill_little(name):
    rows = csr_array(GRAPHS[name]())
    count = rows.shape[0]
    order = nested_order(rows)
    np.testing.assert_array_equal(np.sort(order), np.arange(count))
    matrix = csr_array(abs(rows))
    matrix = csc_array(matrix + diags_array(matrix.sum(axis=1) + 1.0))

    def fill(order):
        options = {"SymmetricMode": True}
        return splu(
            matrix[order][:, order], permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options
        ).L.nnz

    assert fill(order) < 0.5 * splu(matrix, permc_spec="COLAMD").L.nnz + 12 * count


def test_wrong_input_is_named():
    sheet = plane(10.0, cells=2)
    with pytest.raises(SurfaceError, match="symmetry is 3"):
        DirectionField.smoothest(sheet, 3)
    with pytest.raises(SurfaceError, match="no length"), np.errstate(over="ignore"):
        DirectionField.from_axis(sheet, [1e308, 1e308, 1e308])
    with pytest.raises(SurfaceError, match="no length"):
        DirectionField.from_axis(sheet, [0, 0, 0])
    with pytest.raises(SurfaceError, match="no strokes"):
        DirectionField.from_strokes(sheet, SurfacePoints(np.zeros(0, int), np.zeros((0, 3))), 0.0)
    with pytest.raises(SurfaceError, match="which"):
        DirectionField.from_curvature(sheet, "most")


def test_large_meshes_take_steps_to_the_field_that_factors_give(monkeypatch):
    """Twin: conjugate gradients beside factors, on a surface whose sides lie far from what pulls."""
    for shape in (bumpy(4), torus()):
        factored = DirectionField.from_curvature(shape, symmetry=4).vertex_value
        monkeypatch.setattr(connection, "FACTORED_VERTICES", 10)
        stepped = DirectionField.from_curvature(shape, symmetry=4).vertex_value
        monkeypatch.undo()
        assert (factored != stepped).any()
        np.testing.assert_allclose(stepped, factored, atol=2e-4)


def test_a_field_that_nothing_pulls_is_left_at_zero_by_steps():
    matrix = diags_array(np.arange(1.0, 7.0))
    assert (solved_by_steps(matrix, np.zeros(6, complex), np.zeros(6)) == 0).all()
    np.testing.assert_allclose(solved_by_steps(matrix, np.ones(6), np.ones(6)), 1 / np.arange(1.0, 7.0))
