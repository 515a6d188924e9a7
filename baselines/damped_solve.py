"""The 6x6 system of a damped step, in scalars so that it never leaves the registers.

The scalars may as well be `Lanes`: then as many systems are solved side by side.
"""

from __future__ import annotations

from robots.compiled import njit


@njit(fastmath={"contract", "reassoc"}, _nrt=False, forceinline=True)
def damped_solve(J, free, error, damping, y):  # type: ignore[no-untyped-def]
    """Solve (Σ JₖᵀJₖ + λ I) y = e over the free joints k.

    Args:
        J: (dof, 6) transposed Jacobian, one row a joint.
        free: (dof,) whether a joint may move.
        error: (6,) right-hand side e.
        damping: λ > 0.
        y: (6,) receives the solution.
    """
    packed = diagonal(damping, 0.0)
    for k in range(J.shape[0]):
        if free[k]:
            row = (J[k, 0], J[k, 1], J[k, 2], J[k, 3], J[k, 4], J[k, 5])
            packed = add_outer_product(packed, row)
    e = (error[0], error[1], error[2], error[3], error[4], error[5])
    y[0], y[1], y[2], y[3], y[4], y[5] = solve_packed(packed, e)


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def diagonal(value, zero):  # type: ignore[no-untyped-def]
    """Packed matrix with a value on its diagonal and a zero of the same type beside it."""
    first = (value, zero, value, zero, zero, value, zero, zero, zero, value)
    return first + (zero, zero, zero, zero, value, zero, zero, zero, zero, zero, value)  # noqa: RUF005 - numba unpacks nothing inside a tuple


@njit(fastmath={"contract", "reassoc"}, _nrt=False, forceinline=True)
def add_outer_product(packed, row):  # type: ignore[no-untyped-def]
    """Return a packed matrix plus rowᵀ row, row (6,) as a tuple."""
    (a00, a10, a11, a20, a21, a22, a30, a31, a32, a33) = packed[:10]
    (a40, a41, a42, a43, a44, a50, a51, a52, a53, a54, a55) = packed[10:]
    u, v, w, x, z, t = row
    a00, a10, a11 = a00 + u * u, a10 + v * u, a11 + v * v
    a20, a21, a22 = a20 + w * u, a21 + w * v, a22 + w * w
    a30, a31, a32, a33 = a30 + x * u, a31 + x * v, a32 + x * w, a33 + x * x
    a40, a41, a42, a43, a44 = a40 + z * u, a41 + z * v, a42 + z * w, a43 + z * x, a44 + z * z
    a50, a51, a52, a53, a54 = a50 + t * u, a51 + t * v, a52 + t * w, a53 + t * x, a54 + t * z
    first = (a00, a10, a11, a20, a21, a22, a30, a31, a32, a33)
    return first + (a40, a41, a42, a43, a44, a50, a51, a52, a53, a54, a55 + t * t)  # noqa: RUF005


@njit(fastmath={"contract", "reassoc"}, _nrt=False, forceinline=True)
def solve_packed(packed, error):  # type: ignore[no-untyped-def]
    """Solve A y = e by an L D Lᵀ factorisation, A (6, 6) symmetric and positive definite.

    Golub and Van Loan, "Matrix Computations", section 4.1.

    Args:
        packed: Lower triangle of A, row by row, a tuple of 21 numbers or `Lanes`.
        error: Right-hand side e, a tuple of 6.

    Returns:
        Solution y, a tuple of 6.
    """
    (a00, a10, a11, a20, a21, a22, a30, a31, a32, a33) = packed[:10]
    (a40, a41, a42, a43, a44, a50, a51, a52, a53, a54, a55) = packed[10:]
    # Column by column: d holds the inverse of a pivot, l the multipliers below it.
    d0 = 1.0 / a00
    l10, l20, l30, l40, l50 = a10 * d0, a20 * d0, a30 * d0, a40 * d0, a50 * d0
    a11, a21, a31 = a11 - l10 * a10, a21 - l20 * a10, a31 - l30 * a10
    a41, a51, a22 = a41 - l40 * a10, a51 - l50 * a10, a22 - l20 * a20
    a32, a42, a52 = a32 - l30 * a20, a42 - l40 * a20, a52 - l50 * a20
    a33, a43, a53 = a33 - l30 * a30, a43 - l40 * a30, a53 - l50 * a30
    a44, a54, a55 = a44 - l40 * a40, a54 - l50 * a40, a55 - l50 * a50
    d1 = 1.0 / a11
    l21, l31, l41, l51 = a21 * d1, a31 * d1, a41 * d1, a51 * d1
    a22, a32, a42, a52 = a22 - l21 * a21, a32 - l31 * a21, a42 - l41 * a21, a52 - l51 * a21
    a33, a43, a53 = a33 - l31 * a31, a43 - l41 * a31, a53 - l51 * a31
    a44, a54, a55 = a44 - l41 * a41, a54 - l51 * a41, a55 - l51 * a51
    d2 = 1.0 / a22
    l32, l42, l52 = a32 * d2, a42 * d2, a52 * d2
    a33, a43, a53 = a33 - l32 * a32, a43 - l42 * a32, a53 - l52 * a32
    a44, a54, a55 = a44 - l42 * a42, a54 - l52 * a42, a55 - l52 * a52
    d3 = 1.0 / a33
    l43, l53 = a43 * d3, a53 * d3
    a44, a54, a55 = a44 - l43 * a43, a54 - l53 * a43, a55 - l53 * a53
    d4 = 1.0 / a44
    l54 = a54 * d4
    d5 = 1.0 / (a55 - l54 * a54)
    # Forward substitution, then backward.
    y0 = error[0]
    y1 = error[1] - l10 * y0
    y2 = error[2] - l20 * y0 - l21 * y1
    y3 = error[3] - l30 * y0 - l31 * y1 - l32 * y2
    y4 = error[4] - l40 * y0 - l41 * y1 - l42 * y2 - l43 * y3
    y5 = error[5] - l50 * y0 - l51 * y1 - l52 * y2 - l53 * y3 - l54 * y4
    y5 = y5 * d5
    y4 = y4 * d4 - l54 * y5
    y3 = y3 * d3 - l43 * y4 - l53 * y5
    y2 = y2 * d2 - l32 * y3 - l42 * y4 - l52 * y5
    y1 = y1 * d1 - l21 * y2 - l31 * y3 - l41 * y4 - l51 * y5
    y0 = y0 * d0 - l10 * y1 - l20 * y2 - l30 * y3 - l40 * y4 - l50 * y5
    return y0, y1, y2, y3, y4, y5
