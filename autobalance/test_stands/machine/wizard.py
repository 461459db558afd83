"""``autobalance machine --wizard``: a machine's smallest residual by three readings and an index test."""

from __future__ import annotations

from autobalance.errors import UsageError

REPEATED_READINGS = 3
INDEX_DEG = (0.0, 180.0)
READING_FORMAT = 'amount [g·mm] and angle [deg], as "35.2 191": '


def wizard() -> int:
    """Ask for readings of one plane, and print the keys of ``[reading]`` that follow."""
    from autobalance.command.console import say
    from autobalance.report.reading_template import UMAR_G_MM, URR_PERCENT
    from autobalance.theory.machines import machine_accuracy

    say(
        f"Typical of a hard-bearing machine: urr_percent = {URR_PERCENT:g}, umar_g_mm = "
        f"{UMAR_G_MM:g}.\n"
        "One plane is read; remove the rotor and mount it again between readings."
    )
    repeated = [
        _typed_reading(f"reading {n} of {REPEATED_READINGS}, {READING_FORMAT}")
        for n in range(1, REPEATED_READINGS + 1)
    ]
    index = [
        _typed_reading(f"crank turned by {turn:g}° on its tooling, {READING_FORMAT}") for turn in INDEX_DEG
    ]
    (sizes, angles), (index_sizes, index_angles) = (zip(*each, strict=True) for each in (repeated, index))
    try:
        accuracy = machine_accuracy(sizes, angles, INDEX_DEG, index_sizes, index_angles)
    except ValueError as error:
        raise UsageError(f"the readings give no figures: {error}") from None
    say(
        f"tooling and mandrel: {accuracy.tooling_g_mm:.2f} g·mm at {accuracy.tooling_deg:.1f}°; "
        f"the crank alone: {accuracy.crank_g_mm:.2f} g·mm at {accuracy.crank_deg:.1f}°\n\n"
        f"[reading]\nurr_percent = {URR_PERCENT:g}  # usual; not in these readings: see its own test\n"
        f"umar_g_mm = {accuracy.umar_g_mm:.3g}  # by Student's t of {REPEATED_READINGS} readings, 95 %"
    )
    return 0


def _typed_reading(question: str) -> tuple[float, float]:
    try:
        words = input(question).replace(",", ".").split()
        amount, angle = map(float, words)
    except EOFError:
        raise UsageError("--wizard reads from the terminal; there is nothing more to read") from None
    except ValueError:
        raise UsageError("expected two numbers, amount and angle, with a space between") from None
    if amount < 0.0:
        raise UsageError(f"amount is {amount:g}; must be ≥ 0")
    return amount, angle
