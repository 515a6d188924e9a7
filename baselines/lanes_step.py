"""One damped step of LANES configurations inside the joint limits; `baselines.damped_step`."""

from __future__ import annotations

from baselines.damped_solve import add_outer_product, diagonal, solve_packed
from baselines.lanes import greatest, lanes_of, least, load, mask_bits, select, store
from robots.compiled import njit


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def lanes_damped_step(chain, w, error, damping, moving, passes):  # type: ignore[no-untyped-def]
    """Move the joints w.q by one step where a mask holds.

    A joint at its limit whose step points outward gets a Jacobian of zero, which is the same as
    leaving it out; the lanes where none does repeat the same numbers.

    Args:
        chain: The chain of the robot.
        w: `Work`, with `jacobian` of these configurations.
        error: Tuple of 6.
        damping: λ > 0 [m² and rad²].
        moving: Mask of the lanes that move.
        passes: How often the step is solved again with joints frozen.
    """
    J, q = w.jacobian, w.q
    dof = q.shape[0]
    for k in range(dof):
        store(w.free, k, 1.0)
    for _ in range(passes + 1):
        packed = diagonal(damping, lanes_of(0.0))
        for k in range(dof):
            free = load(w.free, k)
            a, b, c, d, e, f = _row(J, k)
            packed = add_outer_product(
                packed, (free * a, free * b, free * c, free * d, free * e, free * f)
            )
        y = solve_packed(packed, error)
        frozen = damping < 0.0
        for k in range(dof):
            a, b, c, d, e, f = _row(J, k)
            free = load(w.free, k)
            step = a * y[0] + b * y[1] + c * y[2] + (d * y[3] + e * y[4] + f * y[5])
            step = free * step
            store(w.step, k, step)
            at = load(q, k)
            below = (at <= chain.lower[k]) & (step < 0.0)
            outward = below | ((at >= chain.upper[k]) & (step > 0.0))
            frozen = frozen | outward
            store(w.free, k, select(outward, 0.0, free))
        if mask_bits(frozen & moving) == 0:
            break
    for k in range(dof):
        at = load(q, k)
        moved = least(
            greatest(at + load(w.step, k), lanes_of(chain.lower[k])), lanes_of(chain.upper[k])
        )
        store(q, k, select(moving, moved, at))


@njit(fastmath={"contract"}, _nrt=False, forceinline=True)
def _row(J, k):  # type: ignore[no-untyped-def]
    a, b, c = load(J, 6 * k), load(J, 6 * k + 1), load(J, 6 * k + 2)
    return a, b, c, load(J, 6 * k + 3), load(J, 6 * k + 4), load(J, 6 * k + 5)
