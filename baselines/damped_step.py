"""One damped step inside the joint limits, shared by the solver `lm` and the planner's tracking.

The step z + Jᵀ (J Jᵀ + λ I)⁻¹ (e - J z) goes towards the target by damped least squares and, where
a bias z is given, moves in the null space on the way (Siciliano et al., "Robotics: Modelling,
Planning and Control", section 3.5.1). A joint at its limit whose step points outward is frozen and
the step is solved again (Nocedal and Wright, "Numerical Optimization", section 16.5).
"""

from __future__ import annotations

from baselines.damped_solve import damped_solve
from baselines.linearise import find_jacobian
from robots.compiled import njit


@njit(_nrt=False, forceinline=True)
def damped_step(chain, w, bias, damping, max_active_set_passes):  # type: ignore[no-untyped-def]
    """Move the joints w.q by one step, after `find_error`.

    Args:
        chain: The chain of the robot.
        w: Arrays that one thread works in, a named tuple with: `at`, the `Linearisation`; `q`,
            `step` and `free` (dof,), joints [rad or m], their step, and which are not frozen;
            `solved` (6,), solution of the damped system; with a bias also `residual` (6,), its
            right-hand side.
        bias: (dof,) motion z [rad or m], or None: numba then compiles a version without it.
        damping: λ > 0 [m² and rad²].
        max_active_set_passes: How often the step is solved again with joints frozen.
    """
    find_jacobian(chain, w.at)
    step_inside(chain, w, bias, damping, max_active_set_passes)


@njit(_nrt=False, forceinline=True)
def step_inside(chain, w, bias, damping, max_active_set_passes):  # type: ignore[no-untyped-def]
    """Move as `damped_step`, by the error and the Jacobian that stand in w.at."""
    dof = w.q.shape[0]
    w.free[:] = True
    for _ in range(max_active_set_passes + 1):
        if bias is None:
            damped_solve(w.at.jacobian, w.free, w.at.error, damping, w.solved)
        else:
            _subtract_bias(w, bias)
            damped_solve(w.at.jacobian, w.free, w.residual, damping, w.solved)
        frozen = False
        for k in range(dof):
            if not w.free[k]:
                w.step[k] = 0.0
                continue
            total = 0.0
            if bias is not None:
                total = bias[k]
            for i in range(6):
                total += w.at.jacobian[k, i] * w.solved[i]
            w.step[k] = total
            if (w.q[k] <= chain.lower[k] and total < 0.0) or (
                w.q[k] >= chain.upper[k] and total > 0.0
            ):
                w.free[k] = False
                frozen = True
        if not frozen:
            break
    for k in range(dof):
        w.q[k] = min(max(w.q[k] + w.step[k], chain.lower[k]), chain.upper[k])


@njit(no_cpython_wrapper=True, _nrt=False, forceinline=True)
def _subtract_bias(w, bias):  # type: ignore[no-untyped-def]
    """Write e - J z over the free joints into w.residual."""
    for i in range(6):
        w.residual[i] = w.at.error[i]
    for k in range(bias.shape[0]):
        if w.free[k] and bias[k] != 0.0:
            for i in range(6):
                w.residual[i] -= w.at.jacobian[k, i] * bias[k]


@njit(_nrt=False)
def project_gradient(w, damping):  # type: ignore[no-untyped-def]
    """Write into w.bias the part of w.gradient within the null space, after `find_jacobian`.

    Args:
        w: As of `damped_step`, with `gradient` and `bias` (dof,); joints that are not `free` stay.
        damping: λ > 0 [m² and rad²].

    Returns:
        The inner product of the part and the gradient, and the largest motion in it.
    """
    J, g = w.at.jacobian, w.gradient
    w.residual[:] = 0.0
    for k in range(g.shape[0]):
        if w.free[k]:
            for i in range(6):
                w.residual[i] += J[k, i] * g[k]
    damped_solve(J, w.free, w.residual, damping, w.solved)
    along, largest = 0.0, 0.0
    for k in range(g.shape[0]):
        w.bias[k] = 0.0
        if w.free[k]:
            projected = g[k]
            for i in range(6):
                projected -= J[k, i] * w.solved[i]
            w.bias[k] = projected
            along += projected * g[k]
            largest = max(largest, abs(projected))
    return along, largest
