from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.recordings.cells import Cells, average_cells
from rfcompass.recordings.placement import PlacedReads
from rfcompass.recordings.read_table import ReadColumns

POSITIONS = 4


def _reads(seed: int, R: int = 60, *, spread_rad: float = 10.0) -> PlacedReads:
    rng = np.random.default_rng(seed)
    epc_index, position = rng.integers(0, 3, R), rng.integers(0, POSITIONS, R)
    columns = ReadColumns(
        epcs=("A", "B", "C"),
        epc_index=epc_index,
        antenna=np.ones(R, dtype=np.int64),
        frequencies_hz=np.array([920e6, 921e6]),
        freq_index=rng.integers(0, 2, R),
        pose_id=position,
        amplitude=rng.choice([0.5, 1.0, 2.0], R),
        lag_rad=0.3 * epc_index + spread_rad * rng.choice(np.linspace(-1.0, 1.0, 7), R),
        tx_antenna=None,
        stop_id=None,
    )
    return PlacedReads(columns, position, np.arange(POSITIONS), np.arange(POSITIONS))


def _permuted(reads: PlacedReads, order: np.ndarray) -> PlacedReads:
    c = reads.columns
    columns = replace(
        c, epc_index=c.epc_index[order], antenna=c.antenna[order], freq_index=c.freq_index[order],
        pose_id=c.pose_id[order], amplitude=c.amplitude[order], lag_rad=c.lag_rad[order],
    )  # fmt: skip
    return replace(reads, columns=columns, position=reads.position[order])


def _slow_channel(reads: PlacedReads, epc: str, position: int, freq_hz: float) -> complex:
    c = reads.columns
    a, u = [], []
    for r in range(c.epc_index.size):
        place = c.epcs[c.epc_index[r]], reads.position[r], c.frequencies_hz[c.freq_index[r]]
        if place == (epc, position, freq_hz):
            a.append(c.amplitude[r])
            u.append(np.exp(-1j * c.lag_rad[r]))
    return complex(np.mean(a) * np.mean(u)) if a else 0j


def _channel_at(cells: Cells, t: int, m: int, f: int) -> complex:
    return complex(cells.means.channel(half_turns=False)[t, m, f])


@given(seed=st.integers(0, 1000), R=st.integers(0, 40))
def test_each_cell_is_mean_amplitude_times_mean_phasor(seed, R):
    reads = _reads(seed, R)
    cells = average_cells(reads, ("C", "A"))
    assert cells.means.counts.sum() == np.isin(reads.columns.epc_index, [0, 2]).sum()
    for t, m, f in np.ndindex(cells.means.counts.shape):
        slow = _slow_channel(reads, cells.epcs[t], int(cells.rx_rows[m]), cells.frequencies_hz[f])
        assert _channel_at(cells, t, m, f) == pytest.approx(slow, abs=1e-12)


@given(seed=st.integers(0, 1000), half_turns=st.booleans())
def test_the_order_of_the_reads_does_not_matter_to_the_last_bit(seed, half_turns):
    reads = _reads(seed)
    order = np.random.default_rng(seed + 1).permutation(60)
    one, other = (average_cells(r, ("A", "B", "C")) for r in (reads, _permuted(reads, order)))
    assert one.means.channel(half_turns=half_turns).tobytes() == other.means.channel(half_turns=half_turns).tobytes()


@given(seed=st.integers(0, 1000))
def test_half_turns_of_single_reads_change_nothing_modulo_pi(seed):
    reads = _reads(seed, spread_rad=0.3)
    rng = np.random.default_rng(seed)
    turned = replace(reads.columns, lag_rad=reads.columns.lag_rad + np.pi * rng.integers(-3, 4, 60))
    one = average_cells(reads, ("A", "B")).means.channel(half_turns=True)
    other = average_cells(replace(reads, columns=turned), ("A", "B")).means.channel(half_turns=True)
    np.testing.assert_allclose(other**2, one**2, atol=1e-9)


@given(seed=st.integers(0, 1000), turn=st.floats(-7, 7))
def test_a_turn_of_all_phases_turns_the_channel_across_any_branch(seed, turn):
    reads = _reads(seed, spread_rad=0.3)
    turned = replace(reads.columns, lag_rad=reads.columns.lag_rad + turn)
    for half_turns, power in ((False, 1), (True, 2)):
        one = average_cells(reads, ("A",)).means.channel(half_turns=half_turns) ** power
        other = average_cells(replace(reads, columns=turned), ("A",)).means.channel(half_turns=half_turns) ** power
        np.testing.assert_allclose(other, one * np.exp(-1j * power * turn), atol=1e-9)


def test_only_positions_and_frequencies_that_were_heard_are_axes():
    reads = _reads(3)
    keep = (reads.position == 2) & (reads.columns.freq_index == 1)
    cells = average_cells(reads, ("A", "B", "C"), keep)
    assert cells.rx_rows.tolist() == [2]
    assert cells.frequencies_hz.tolist() == [921e6]
    assert cells.means.counts.sum() == keep.sum() > 0


def test_a_cell_whose_reads_disagree_counts_less():
    agreeing, scattered = _reads(4, spread_rad=0.0), _reads(4, spread_rad=2.0)
    strong, weak = (np.abs(average_cells(r, ("A",)).means.channel(half_turns=False)) for r in (agreeing, scattered))
    assert (weak <= strong + 1e-12).all()
    assert weak.sum() < 0.9 * strong.sum()
