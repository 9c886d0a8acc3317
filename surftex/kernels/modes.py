"""Steps towards the lowest mode of each component: inner products of three fields, and a new one made of them.

Shared arguments: component (n,) int64; share (n,) float64: of each vertex in its component; field (3, n) complex128: the mode,
what betters it, the last step; image (3, n) complex128: what the matrix makes of them.
"""

import math

from surftex.kernels.jit import kernel, part

ALIKE = 1e-10
"""Square of the part of a field that is not made of others, by its own, up to which it does not count."""

TURNS = 12
"""Rounds of rotations at most; they double the digits each."""


@kernel
def inner_products(component, share, field, image, inner, energy):
    """Add up products of the fields with one another, and with their images, over each component.

    -> inner, energy (c, 3, 3) complex128, given as 0: what is not below the diagonal.
    """
    for v in range(len(component)):
        c, here = component[v], share[v]
        for i in range(3):
            conjugate = field[i, v].conjugate()
            for j in range(i, 3):
                inner[c, i, j] += here * (conjugate * field[j, v])
                energy[c, i, j] += conjugate * image[j, v]


@kernel
def step(component, share, factor, level, field, image, left):
    """Replace the mode by factor (c, 3) complex128 of the three fields, and the last step by the part that is not the mode.

    level (c,) float64: energy of the new mode -> left (n,) complex128: its image, less what that would be of a mode.
    """
    for v in range(len(component)):
        c = component[v]
        change = factor[c, 1] * field[1, v] + factor[c, 2] * field[2, v]
        image_change = factor[c, 1] * image[1, v] + factor[c, 2] * image[2, v]
        field[0, v] = factor[c, 0] * field[0, v] + change
        image[0, v] = factor[c, 0] * image[0, v] + image_change
        field[2, v], image[2, v] = change, image_change
        left[v] = image[0, v] - level[c] * share[v] * field[0, v]


@part
def _orthonormal(inner, basis):
    """Make a basis of the three fields: the columns of basis (3, 3), 0 for fields that are made of those before.

    inner (3, 3): products of the fields.
    """
    for k in range(3):
        size = inner[k, k].real
        for i in range(3):
            basis[i, k] = 0.0
        if size <= 0:
            continue
        basis[k, k] = 1 / math.sqrt(size)
        for j in range(k):
            along = 0j
            for i in range(3):
                along += basis[i, j].conjugate() * inner[i, k] * basis[k, k].real
            for i in range(3):
                basis[i, k] -= along * basis[i, j]
        square = 0.0
        for i in range(3):
            for j in range(3):
                square += (basis[i, k].conjugate() * inner[i, j] * basis[j, k]).real
        for i in range(3):
            basis[i, k] = basis[i, k] / math.sqrt(square) if square > ALIKE else 0.0


@part
def _rotate(p, q, energy, basis):
    """Turn two columns of a basis until they have no energy in common (Jacobi); energy (3, 3) of the columns."""
    size = abs(energy[p, q])
    if size <= 1e-17 * (energy[p, p].real + energy[q, q].real):
        energy[p, q], energy[q, p] = 0.0, 0.0
        return
    phase = energy[p, q].conjugate() / size
    half = (energy[q, q].real - energy[p, p].real) / (2 * size)
    tangent = math.copysign(1.0, half) / (abs(half) + math.sqrt(1 + half * half))
    cosine = 1 / math.sqrt(1 + tangent * tangent)
    sine = tangent * cosine
    for i in range(3):
        one, two = basis[i, p], phase * basis[i, q]
        basis[i, p], basis[i, q] = cosine * one - sine * two, sine * one + cosine * two
        one, two = energy[i, p], phase * energy[i, q]
        energy[i, p], energy[i, q] = cosine * one - sine * two, sine * one + cosine * two
    for i in range(3):
        one, two = energy[p, i], phase.conjugate() * energy[q, i]
        energy[p, i], energy[q, i] = cosine * one - sine * two, sine * one + cosine * two


@kernel
def best(moving, inner, energy, room, factor, level):
    """Find the sum of the three fields that has the least energy at size 1 (Rayleigh and Ritz), where moving (c,) is True.

    inner, energy (c, 3, 3) complex128 as from `inner_products`; room (2, 3, 3) complex128: room to work in
    -> factor (c, 3) complex128: of the fields, the first not negative; level (c,) float64: the energy.
    """
    basis, common = room[0], room[1]
    for c in range(len(moving)):
        if not moving[c]:
            factor[c, 0], factor[c, 1], factor[c, 2] = 1.0, 0.0, 0.0
            continue
        for i in range(3):
            for j in range(i):
                inner[c, i, j], energy[c, i, j] = inner[c, j, i].conjugate(), energy[c, j, i].conjugate()
        _orthonormal(inner[c], basis)
        for p in range(3):
            for q in range(3):
                common[p, q] = 0.0
                for i in range(3):
                    for j in range(3):
                        common[p, q] += basis[i, p].conjugate() * energy[c, i, j] * basis[j, q]
        for _ in range(TURNS):
            for k in range(3):
                _rotate(max(k - 1, 0), min(k + 1, 2), common, basis)
        least = -1
        for k in range(3):
            counts = basis[0, k] != 0 or basis[1, k] != 0 or basis[2, k] != 0
            if counts and (least < 0 or common[k, k].real < common[least, least].real):
                least = k
        for i in range(3):
            factor[c, i] = basis[i, least] if least >= 0 else 0.0
        level[c] = common[least, least].real if least >= 0 else 0.0
        size = abs(factor[c, 0])
        if size > 0:
            phase = factor[c, 0].conjugate() / size
            for i in range(3):
                factor[c, i] *= phase
