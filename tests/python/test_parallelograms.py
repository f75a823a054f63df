"""Checks the domains of points in pictures: they are those of the deformed squares, and leave no gaps in a sheared or turned body."""
import numpy as np
import pytest

from mlgimp import fields, parallelograms

pytestmark = pytest.mark.fast


def turned(angle, gradient=((1, 0), (0, 1))):
    """A deformation gradient [2][2], and then a turn by an angle in degrees."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[cosine, -sine], [sine, cosine]]) @ gradient


def points_of(position, gradient, half):
    """The points as a frame has them, of places [n][2] and half sizes [2] before the deformation."""
    size = np.sqrt(gradient**2 @ np.array(half) ** 2)
    return {"position": position @ gradient.T, "half_size": np.tile(size, (len(position), 1)), "deformation_gradient": np.tile(gradient.ravel(), (len(position), 1))}


@pytest.mark.parametrize("angle", [0, 20, -70, 130])
@pytest.mark.parametrize("half", [(1, 1), (1, 0.5)])
def test_edges(angle, half):
    """They are F times the half sizes before the deformation; of squares also where these do not follow from the present sizes alone."""
    gradient = turned(angle, [[1.1, 0.6], [0.1, 0.9]])
    found, = parallelograms.edges_of(points_of(np.zeros((1, 2)), gradient, half))
    np.testing.assert_allclose(found, (gradient * half).T, atol=1e-5)
    eighth = turned(45)
    found, = parallelograms.edges_of(points_of(np.zeros((1, 2)), eighth, (1, 1)))
    np.testing.assert_allclose(found, eighth.T, atol=1e-7)


@pytest.mark.parametrize("gradient", [turned(30), turned(45), [[1, 0.9], [0, 1]], turned(-20, [[1.5, 0.5], [0.2, 0.6]])],
                         ids=["turned", "turned by an eighth", "sheared", "all"])
def test_no_gaps(gradient):
    """Each dot inside of a body that deformed uniformly is painted, in the colour of a point that it touches, and none far outside."""
    places = np.stack(np.meshgrid(np.arange(12) + 0.5, np.arange(12) + 0.5, indexing="ij"), axis=-1).reshape(-1, 2) - 6
    gradient = np.array(gradient, float)
    points = points_of(places, gradient, (0.5, 0.5))
    image = parallelograms.paint(points, np.arange(144.0), np.array([-12, 12, -12, 12]), (191, 207))
    y, x = np.meshgrid(24 * (np.arange(191) + 0.5) / 191 - 12, 24 * (np.arange(207) + 0.5) / 207 - 12, indexing="ij")
    before = np.stack([x, y], axis=-1) @ np.linalg.inv(gradient).T
    dot = 0.5 * np.array([24 / 207, 24 / 191]) @ np.abs(np.linalg.inv(gradient)).T  # half of one, before the deformation
    assert not np.isnan(image[np.all(np.abs(before) < 6, axis=-1)]).any()
    assert np.isnan(image[np.any(np.abs(before) > 6 + dot, axis=-1)]).all()
    painted = ~np.isnan(image)
    away = np.abs(before[painted] - places[image[painted].astype(int)])
    assert np.all(away <= 0.5 + dot + 1e-9)


def test_an_image_in_the_axis_is_an_image():
    """The left half of an axisymmetric picture mirrors the domains, too."""
    points = points_of(np.array([[3.0, 0.0]]), np.array([[1, 0.8], [0, 1]]), (0.5, 0.5)) | {"stress": np.zeros((1, 4))}
    both, _ = fields.mirrored(points, np.zeros((0, 2, 2)))
    image = parallelograms.paint(both, np.ones(2), np.array([-5, 5, -2, 2]), (80, 200))
    assert np.isfinite(image).sum() > 300
    np.testing.assert_array_equal(image, image[:, ::-1])


def test_rectangles_lie_beneath_points_inside_of_bodies():
    """A point that turned by 45 degrees leaves the corners of its rectangle to others; where it has no outer face they are its own."""
    points = points_of(np.zeros((1, 2)), turned(45), (1, 1))
    window, values = np.array([-2, 2, -2, 2]), np.ones(1)
    bare, outer, inner = (np.isfinite(parallelograms.paint(points | faces, values, window, (80, 80))) for faces in ({}, {"faces": np.ones(1)}, {"faces": np.zeros(1)}))
    corner = np.ix_(range(57, 60), range(57, 60))  # up to 1 along both axes
    assert not bare[corner].any() and not outer[corner].any() and inner[corner].all() and np.array_equal(bare, outer) and np.all(inner[bare])
