"""Time and memory of ``orders`` on a record of an hour, as WAV and as CSV.

    python benchmarks/long_record.py [--minutes 60] [--wav-hz 5000] [--csv-hz 1000]

The record is of a shaft that speeds up and slows down between 20 and 30 turns a second: three orders, a
steady tone, noise, and a tacho with one pulse a turn. Each run is a process of its own; told are its
processor time and the most memory it held, beside the file's size and beside what a record of a tenth of the
time takes: memory that is bounded by blocks does not grow with the time. Last, the order maps of a minute.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import wave
from collections.abc import Iterator
from pathlib import Path

import numpy as np

BLOCK = 1 << 18
CHILD = """
import json, resource, sys
import autobalance as ab
path, channel, tacho = sys.argv[1:4]
result = ab.orders(path, channel=channel, tacho=tacho, natural=False)
used = resource.getrusage(resource.RUSAGE_SELF)
first = next(row for row in result.report["orders"] if row["order"] == 1.0)
print(json.dumps({"cpu_s": used.ru_utime + used.ru_stime, "memory_mb": used.ru_maxrss / 1024.0,
                  "order_1": first["amplitude"], "mean_rpm": result.report["speed"]["mean_rpm"]}))
"""
"""Runs one record; ``ru_maxrss`` is in KiB on Linux."""
MAPS = """
import json, resource, sys
from autobalance.signals.formats import read
from autobalance.signals.speed import order_map
from autobalance.signals.tacho import pulses
before = resource.getrusage(resource.RUSAGE_SELF)
record = read(sys.argv[1])
turning = pulses(record.channel("4"), 1).turning()
sizes = [order_map(channel, turning, 12.0).amplitudes.shape for channel in record.channels]
after = resource.getrusage(resource.RUSAGE_SELF)
print(json.dumps({"cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
                  "memory_mb": (after.ru_maxrss - before.ru_maxrss) / 1024.0}))
"""
"""Order maps of all channels of a minute; memory is what it grows by over the program itself."""


def pieces(seconds: float, rate_hz: float) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield times, samples and tacho of the record, piece by piece."""
    rng = np.random.default_rng(1)
    slow = 2.0 * np.pi / 120.0
    for start in range(0, round(seconds * rate_hz), BLOCK):
        t = np.arange(start, min(start + BLOCK, round(seconds * rate_hz))) / rate_hz
        angle = 2.0 * np.pi * (25.0 * t + 5.0 / slow * (1.0 - np.cos(slow * t)))
        wave_ = 0.2 * np.cos(angle + 0.5) + 0.1 * np.cos(2.0 * angle) + 0.05 * np.cos(4.0 * angle)
        wave_ += 0.03 * np.cos(2.0 * np.pi * 137.0 * t) + 0.02 * rng.standard_normal(len(t))
        yield t, wave_, np.where((angle / (2.0 * np.pi)) % 1.0 < 0.2, 0.8, 0.0)


def write_wav(path: Path, seconds: float, rate_hz: int) -> None:
    """Write two channels of 16 bit."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(2)
        file.setframerate(rate_hz)
        for _, samples, tacho in pieces(seconds, rate_hz):
            file.writeframes((np.column_stack([samples, tacho]) * 32767.0).astype("<i2").tobytes())


def write_minute(path: Path) -> None:
    """Write a minute of four channels at 50 kHz, the last the tacho."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(4)
        file.setsampwidth(2)
        file.setframerate(50_000)
        for _, samples, tacho in pieces(60.0, 50_000.0):
            columns = np.column_stack([samples, 0.5 * samples, 0.3 * samples, tacho])
            file.writeframes((columns * 32767.0).astype("<i2").tobytes())


def write_csv(path: Path, seconds: float, rate_hz: int) -> None:
    """Write time, acceleration and tacho as text."""
    with path.open("w", encoding="utf-8") as stream:
        stream.write("time_s,accel_g,tacho_V\n")
        for t, samples, tacho in pieces(seconds, rate_hz):
            np.savetxt(stream, np.column_stack([t, samples, tacho]), "%.6f,%.6f,%.1f")


def measured(path: Path, script: str, *names: str) -> dict[str, float]:
    """Return what a run took."""
    command = [sys.executable, "-c", script, str(path), *names]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout)
    return {**found, "file_mb": path.stat().st_size / 2**20}


def main() -> int:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--wav-hz", type=int, default=5000)
    parser.add_argument("--csv-hz", type=int, default=1000)
    arguments = parser.parse_args()
    print(f"{'record':>16} {'minutes':>8} {'file MB':>8} {'CPU s':>7} {'memory MB':>10} {'order 1':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for minutes in (0.1 * arguments.minutes, arguments.minutes):
            wav, text = Path(folder) / "record.wav", Path(folder) / "record.csv"
            write_wav(wav, 60.0 * minutes, arguments.wav_hz)
            write_csv(text, 60.0 * minutes, arguments.csv_hz)
            for path, rate, names in (
                (wav, arguments.wav_hz, ("1", "2")),
                (text, arguments.csv_hz, ("accel", "tacho")),
            ):
                found = measured(path, CHILD, *names)
                print(
                    f"{path.suffix[1:].upper() + f' {rate} Hz':>16} {minutes:8.0f} {found['file_mb']:8.1f}"
                    f" {found['cpu_s']:7.1f} {found['memory_mb']:10.0f} {found['order_1']:8.4f}"
                )
        minute = Path(folder) / "minute.wav"
        write_minute(minute)
        found = measured(minute, MAPS)
        print(
            f"order maps of a minute, 4 channels, 50 kHz, {found['file_mb']:.1f} MB:"
            f" {found['cpu_s']:.1f} s of processor, {found['memory_mb']:.0f} MB more than the program itself"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
