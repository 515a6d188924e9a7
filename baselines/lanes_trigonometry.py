"""Sine, cosine and arctangent of all lanes, as polynomials."""

from __future__ import annotations

import math
from fractions import Fraction

from baselines.lanes import bit, greatest, least, select
from robots.compiled import njit
from robots.trigonometry import PER_QUARTER, beyond_quarters, sine_cosine_near_zero

# Added to a number below 2^51, it leaves the nearest whole number in the lowest bits.
_ROUNDING = 1.5 * 2.0**52
_EIGHTH, _QUARTER, _HALF = math.pi / 4, math.pi / 2, math.pi
_BEND = math.tan(math.pi / 8)
_TERMS = 11


def _arctangent_series(reach: float, terms: int) -> tuple[float, ...]:
    """Coefficients of x, x³, x⁵, ... of a polynomial for the arctangent on ±reach.

    The Chebyshev series arctan(r u) = 2 Σ (-1)ᵏ pᵐ / m Tₘ(u), m = 2 k + 1, p = r / (1 + √(1 + r²))
    (Mason and Handscomb, "Chebyshev Polynomials", section 5.2), cut off and in powers of x.
    """
    ratio = Fraction(reach / (1 + math.sqrt(1 + reach * reach)))
    before, now = [Fraction(1)], [Fraction(0), Fraction(1)]  # T₀, T₁ in powers of u
    powers = [Fraction(0)] * (2 * terms)
    for degree in range(1, 2 * terms):
        if degree % 2:
            share = Fraction(2 * (-1) ** (degree // 2), degree) * ratio**degree
            for power, number in enumerate(now):
                powers[power] += share * number
        doubled = [Fraction(0), *(2 * number for number in now)]
        padded = before + [Fraction(0)] * (len(doubled) - len(before))
        before, now = now, [a - b for a, b in zip(doubled, padded, strict=True)]
    return tuple(float(powers[k] / Fraction(reach) ** k) for k in range(1, 2 * terms, 2))


_A1, _A3, _A5, _A7, _A9, _A11, _A13, _A15, _A17, _A19, _A21 = _arctangent_series(_BEND, _TERMS)


@njit(fastmath={"contract"}, forceinline=True)
def lanes_sine_cosine(angle):  # type: ignore[no-untyped-def]
    """Sine and cosine of angles in rad, of a million radians at most."""
    rounded = angle * PER_QUARTER + _ROUNDING
    quarters = rounded - _ROUNDING
    sine, cosine = sine_cosine_near_zero(beyond_quarters(angle, quarters))
    odd, upper = bit(rounded, 0), bit(rounded, 1)
    first, second = select(odd, cosine, sine), select(odd, sine, cosine)
    return select(upper, -first, first), select(odd ^ upper, -second, second)


@njit(fastmath={"contract"}, forceinline=True)
def lanes_angle(sine, cosine):  # type: ignore[no-untyped-def]
    """Angle from 0 to π [rad] whose sine >= 0 and cosine are given, up to a common factor."""
    size = greatest(cosine, -cosine)
    low, high = least(sine, size), greatest(sine, size)
    far = low > _BEND * high  # then arctan(low / high) = π / 4 + arctan of what follows
    x = select(far, low - high, low) / select(far, low + high, high)
    z = x * x
    tail = _A11 + z * (_A13 + z * (_A15 + z * (_A17 + z * (_A19 + z * _A21))))
    angle = x * (_A1 + z * (_A3 + z * (_A5 + z * (_A7 + z * (_A9 + z * tail)))))
    angle = angle + select(far, _EIGHTH, 0.0)
    angle = select(sine > size, _QUARTER - angle, angle)
    return select(cosine < 0.0, _HALF - angle, angle)
